#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <variant>

#include "can/candump.h"

/// Where `cansync trace` takes its frames from.
namespace cansync::cli {

/// A line that is no frame, or a comment in the log.
struct TraceProblem {
  std::string text;  ///< of a file: "FILE:7:3: what is wrong there"
};
/// Something worth telling that is no error, e.g. a comment in the log.
struct TraceRemark {
  std::string text;
};
/// Nothing more comes.
struct TraceEnd {};
/// Nothing came for a moment; look whether a signal has come, and ask again.
struct TraceNothing {};

using TraceItem = std::variant<can::CandumpLine, TraceProblem, TraceRemark, TraceNothing, TraceEnd>;

/// How much of a file was read.
struct TraceProgress {
  std::uint64_t done = 0;   ///< bytes
  std::uint64_t total = 0;  ///< bytes; 0: not known, as of a pipe
};

class TraceSource {
 public:
  virtual ~TraceSource() = default;
  /// The next item; waits at most some 50 ms when there is none. Throws std::system_error when the source
  /// cannot be read.
  virtual TraceItem next() = 0;
  /// Where the last item is in the file, e.g. "line 7"; empty: it is none of a file.
  virtual std::string place() const { return {}; }
  /// Of a file; nothing of an interface.
  virtual TraceProgress progress() const noexcept { return {}; }
  /// It has no end of its own.
  virtual bool endless() const noexcept { return false; }
  /// Frames the kernel dropped because they were not taken in time.
  virtual std::uint64_t dropped() const noexcept { return 0; }
};

/// Longest line of a log, in characters, as a CAN XL frame of 2048 bytes needs it; what is longer is named as a problem
/// and skipped.
inline constexpr std::size_t kLongestTraceLine = 8192;

/// Reads the candump text log or pcapng capture (its first bytes tell which) in `path`, of standard input for
/// "-"; of a log that has each frame twice each comes once. Throws std::system_error with the file's name when it cannot be opened; `next` throws
/// std::runtime_error, with the remedy, when the file is of another format that is recognized.
std::unique_ptr<TraceSource> open_log(const std::string& path);

/// Which frames of an interface are taken.
enum class HeardFrames : std::uint8_t {
  telegrams,  ///< CANsync telegrams, the software SYNC frame and error frames alone
  all,        ///< and what is none of CANsync
};

/// Listens to a SocketCAN interface. It sends nothing. Throws std::runtime_error, with the remedy, when there
/// is no such interface.
std::unique_ptr<TraceSource> open_interface(const std::string& name, std::uint32_t sync,
                                            HeardFrames frames = HeardFrames::telegrams);

/// The file, standard input for "-", or the interface of this name; of a file all frames come. Throws as
/// those above; std::runtime_error when there is neither.
std::unique_ptr<TraceSource> open_trace_source(const std::string& source, std::uint32_t sync,
                                               HeardFrames frames = HeardFrames::telegrams);

/// Is this a file or standard input, and not the name of an interface?
bool is_trace_file(const std::string& source);

}  // namespace cansync::cli
