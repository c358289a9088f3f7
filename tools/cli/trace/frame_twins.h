#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <memory>
#include <string>

#include "can/candump.h"
#include "cli/trace/trace_source.h"

/// Recordings that have each frame twice, as a program makes them that is given its own computer's frames by the
/// loopback of the interface besides the interface's own.
namespace cansync::cli {

/// Finds frames that stand twice: the same one comes again, beside the first, sooner than a bus of 1 Mbit/s could have carried
/// it.
class FrameTwins {
 public:
  /// Is it the second of two? Frames without a time stamp and error frames never are.
  bool take(const can::CandumpLine& line);
  /// So far, those that can be one of two.
  std::size_t frames() const noexcept { return frames_; }
  /// Do these tell that the recording has each frame twice? Not of stamps that are no time of the bus: differences, whole
  /// milliseconds, those of a virtual bus that is faster than any real one.
  bool are_doubled() const noexcept;

 private:
  static constexpr std::size_t kBeside = 4;

  struct First {
    can::CandumpLine line;
    bool has_twin = false;
  };
  std::deque<First> firsts_;  ///< the last `kBeside`
  std::size_t frames_ = 0;
  std::size_t pairs_ = 0;
  bool thrice_ = false;                   ///< one more came as soon
  std::chrono::microseconds begin_{};     ///< stamp of the first
  std::chrono::microseconds last_{};      ///< of the last
  std::chrono::microseconds closest_{};   ///< the smallest difference of two that follow each other; 0: none
  std::chrono::microseconds shortest_{};  ///< that a bus needs for those without their twins
};

/// The frames of `log`, each once; its beginning, of up to 256 frames, tells whether it has each of them twice, which a
/// remark says then. Another log comes as it is. The beginning is held back: `log` is a file that is there already. `name`: the file, for the remark.
std::unique_ptr<TraceSource> each_frame_once(std::unique_ptr<TraceSource> log, std::string name);

}  // namespace cansync::cli
