#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>

#include "cansync/observe/observation.h"
#include "cli/base/output.h"

/// Recordings as verbs take them: a log, a capture, or an interface that is listened to.
namespace cansync::cli {

/// What was typed.
struct RecordingTexts {
  std::string source;
  std::string seconds;
  std::string sync;
  std::string stamps;
  std::string bit_rate;
  std::string from;
};

/// What came of reading it.
struct RecordingEnd {
  observe::Observation observation;
  std::string interface;       ///< that the frames stood on; empty: none came
  std::uint64_t problems = 0;  ///< lines that were no frames
  std::uint64_t dropped = 0;   ///< by the kernel
};

/// SOURCE and the options that say how it is read.
void add_recording_options(CLI::App& verb, RecordingTexts& texts);

/// Reads all of it; of an interface until --seconds have passed or Ctrl-C. What is wrong with lines is said
/// in remarks. Throws UsageError, std::runtime_error, std::system_error.
RecordingEnd observe_recording(Output& output, const RecordingTexts& texts);

}  // namespace cansync::cli
