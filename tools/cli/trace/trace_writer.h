#pragma once

#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

#include "can/frame.h"
#include "can/pcapng.h"
#include "cli/base/output.h"

namespace cansync::cli {

/// Where `cansync trace --pcapng` and `can dump --write` write: a file, or standard output for "-".
class TraceCapture {
 public:
  /// Writes the head of the capture; an existing file is replaced. `output` stays the caller's. Throws
  /// std::system_error with the file's name when it cannot be opened or written, UsageError, which names
  /// `option`, when standard output is a terminal.
  TraceCapture(const std::string& path, Output& output, std::string_view option);
  /// Writes one frame; throws as above. `time` since 1970 (UTC).
  void write(std::chrono::nanoseconds time, std::string_view interface, const can::Frame& frame);
  /// What was written is in the file, so that Wireshark can follow; throws as above.
  void flush();

 private:
  void put(std::string_view bytes);

  std::string path_;
  Output& output_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;  ///< null: standard output
  can::PcapngWriter writer_;
};

}  // namespace cansync::cli
