#pragma once

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "cansync/observe/observation.h"
#include "cansync/observe/observer.h"
#include "cli/base/output.h"
#include "cli/trace/trace_source.h"

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
  std::string interface;       ///< that the frames stood on; empty: none came
  std::uint64_t problems = 0;  ///< lines that were no frames
  std::uint64_t dropped = 0;   ///< by the kernel
  std::uint64_t breaks = 0;    ///< times the clock of the recording went back, or nothing came for long
};

/// Takes a recording as it is read.
class RecordingSink {
 public:
  virtual ~RecordingSink() = default;
  /// Before the first frame.
  virtual void begin(observe::Stamps stamps, std::optional<BitRate> bit_rate) = 0;
  /// A SYNC edge, and the frame that marks it; null: SYNC has a wire of its own.
  virtual void edge(Duration at, const can::Frame* frame) = 0;
  /// Any other frame.
  virtual void frame(Duration at, const can::Frame& frame) = 0;
  /// What comes next has no relation in time to what came before; it follows it at once.
  virtual void begin_anew() = 0;
};

/// An interface is listened to until Ctrl-C.
inline constexpr std::chrono::seconds kWithoutEnd{0};

/// How an interface is listened to; all its frames are received, whatever their protocol.
struct Listening {
  std::chrono::seconds seconds = kWithoutEnd;  ///< without --seconds
};

/// SOURCE and the options that say how it is read.
void add_recording_options(CLI::App& verb, RecordingTexts& texts, std::string_view seconds_default);

/// Reads all of it; of an interface until --seconds have passed or Ctrl-C. What is wrong with lines is said
/// in remarks. Throws UsageError, std::runtime_error, std::system_error.
RecordingEnd read_recording(Output& output, const RecordingTexts& texts, RecordingSink& sink,
                            const Listening& listening);

/// The same for what a recording tells of its master.
struct ObservedRecording {
  RecordingEnd end;
  observe::Observation observation;
};
ObservedRecording observe_recording(Output& output, const RecordingTexts& texts);

/// The bit rate of --bit-rate; nothing when it is not given. Throws UsageError.
std::optional<BitRate> given_bit_rate(const std::string& text);

}  // namespace cansync::cli
