#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

#include "can/candump.h"
#include "can/pcapng.h"
#include "cli/base/output.h"

namespace cansync::cli {

/// Where `cansync trace --pcapng` writes: a file, or standard output for "-", flushed after each frame so
/// that Wireshark can follow.
class TraceCapture {
 public:
  /// Writes the head of the capture; an existing file is replaced. `output` stays the caller's. Throws
  /// std::system_error with the file's name when it cannot be opened or written, UsageError when standard
  /// output is a terminal.
  TraceCapture(const std::string& path, Output& output);
  /// Writes one frame; throws as above.
  void write(const can::CandumpLine& line);

 private:
  void put(std::string_view bytes);

  std::string path_;
  Output& output_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;  ///< null: standard output
  can::PcapngWriter writer_;
};

}  // namespace cansync::cli
