#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <thread>

#include "sim/trace.h"
#include "sim/trace_ring.h"

namespace sim {

/// How a trace is written.
struct TraceFileSettings {
  std::string path;         ///< file to write; an existing one is replaced
  std::string bus = "sim";  ///< the bus's name; `trace_interface` of it stands in the frames' lines
  /// False: the calling thread writes, nothing is ever lost (virtual time). True: a thread of its own writes,
  /// the calling thread only fills a ring and never waits (real time).
  bool background = false;
  std::size_t ring_lines = 65536;  ///< background: lines that may wait for the writing thread, at least 1
  /// Added to the line's time in every stamp. At least 1 s by default, because can-utils' log2asc takes
  /// second 0 for "no time seen yet".
  std::chrono::nanoseconds offset = std::chrono::seconds(1);
};

/// The interface name under which the frames of bus `bus` stand in a trace: at most 15 characters, spaces and
/// what does not print as '_', and never "sync".
std::string trace_interface(std::string_view bus);

/// What became of a trace.
struct TraceSummary {
  std::uint64_t lines = 0;  ///< lines written
  std::uint64_t lost = 0;   ///< background: lines that found no room in the ring
  int error = 0;            ///< errno of the first write that failed; 0 = all went well
};

/// Writes everything on a simulated line as a candump text log.
///
/// A frame's time stamp is the *start* of its transmission, in seconds with 6 decimals, rounded down, because
/// the slot times of CANsync are starts. SYNC edges are lines `(time) sync 080#` on an interface of their
/// own; error frames have the error flag in their identifier (`20000008#...`). The lines are in the order of
/// their stamps. If lines were lost, the last line is a comment that says how many.
class TraceFile final : public TraceSink {
 public:
  /// Opens the file. Throws std::system_error when that fails, std::invalid_argument for a wrong setting.
  explicit TraceFile(const TraceFileSettings& settings);
  /// Closes as `close` does.
  ~TraceFile() override;
  TraceFile(const TraceFile&) = delete;
  TraceFile& operator=(const TraceFile&) = delete;

  void frame(const TracedFrame& frame) noexcept override;
  void sync(can::Time at) noexcept override;

  /// Writes what still waits and closes the file. Call it when nobody tells the trace anything any more; it
  /// may block. Later calls return the same summary.
  TraceSummary close() noexcept;

 private:
  struct Line {
    can::Time at{};
    can::Frame frame;
    bool sync = false;
  };
  struct CloseFile {
    void operator()(std::FILE* file) const noexcept { std::fclose(file); }
  };

  void put(const Line& line) noexcept;
  void write(const Line& line) noexcept;
  void write_text(const char* text, std::size_t size) noexcept;
  void drain() noexcept;
  void run() noexcept;

  TraceFileSettings settings_;
  std::string interface_;
  std::unique_ptr<std::FILE, CloseFile> file_;
  TraceSummary summary_;
  TraceRing<Line> ring_;
  std::atomic<std::uint64_t> lost_{0};
  std::atomic<bool> stop_{false};
  std::thread writer_;  // last: it uses everything above
};

}  // namespace sim
