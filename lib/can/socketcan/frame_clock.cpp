#include "can/socketcan/frame_clock.h"

#include <algorithm>
#include <chrono>

#include "can/clock_offset.h"

namespace can {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

/// Half of the time in which three clocks are read is longer than this only when the thread was interrupted
/// meanwhile, or where each reading is a system call.
constexpr Time kUndisturbed = std::chrono::nanoseconds(2500);
/// A frame is stamped before it can be taken; by more than this only on an overloaded machine, and never by
/// more than the second.
constexpr Time kOnItsWay = milliseconds(2);
constexpr Time kLongestWay = seconds(1);
/// Clocks differ by this much although nothing is wrong.
constexpr Time kClockNoise = microseconds(50);
constexpr unsigned kWindow = 64;
/// Kernel stamp and hardware stamp of one frame can lie this far apart before the hardware's clock must
/// have jumped.
constexpr Time kHardwareJump = milliseconds(20);

}  // namespace

/// A reading that took about as long as the shortest so far was not interrupted, and will do. What it read
/// last is the time of the look, which follows.
void FrameClock::measure_offset() noexcept {
  const ClockOffset read =
      read_clock_offset([this] { return kernel_.monotonic(); }, [this] { return kernel_.realtime(); },
                        std::max(kUndisturbed, least_doubt_ / 4 * 5));
  least_doubt_ = measured_ ? std::min(least_doubt_, read.doubt) : read.doubt;
  offset_ = -read.ahead;
  look_ = read.now;
}

Time FrameClock::begin_batch() noexcept {
  offset_before_ = offset_;
  measure_offset();
  if (!measured_) offset_before_ = offset_;
  measured_ = true;
  return look_;
}

void FrameClock::end_batch(bool complete) noexcept {
  if (complete) taken_up_to_ = look_;
}

bool FrameClock::plausible(Time at) const noexcept {
  return at <= look_ + kClockNoise && at >= taken_up_to_ - kOnItsWay;
}

std::optional<Time> FrameClock::from_software(Time stamp) const noexcept {
  for (const Time offset : {offset_, offset_before_}) {
    if (plausible(stamp + offset)) return std::min(stamp + offset, look_);
  }
  // The wall clock was not set meanwhile: the stamp is right, and the frame is an old one. Were it taken for
  // a new one, it would be answered in a slot that is not its own.
  const Time step = offset_ - offset_before_;
  const bool set = step > kClockNoise || step < -kClockNoise;
  const Time at = stamp + offset_;
  if (!set && at <= look_ && at >= look_ - kLongestWay) return at;
  return std::nullopt;
}

std::optional<Time> FrameClock::from_hardware(Time stamp, Time software) noexcept {
  const Time difference = software - stamp;
  const Time known = std::min(hardware_.before.value_or(difference), hardware_.least.value_or(difference));
  // Less than the least is normal for a frame that came through faster; a jump of the clock is not.
  if (difference > known + kHardwareJump || difference < known - kHardwareJump) hardware_ = {};
  hardware_.least = std::min(hardware_.least.value_or(difference), difference);
  const Time offset = std::min(*hardware_.least, hardware_.before.value_or(*hardware_.least));
  if (++hardware_.frames == kWindow) hardware_ = {hardware_.least, std::nullopt, 0};
  const Time at = stamp + offset;
  if (!plausible(at)) return std::nullopt;
  return std::min(at, look_);
}

StampedTime FrameClock::translate(const FrameStamps& stamps) noexcept {
  const auto software = stamps.software ? from_software(*stamps.software) : std::nullopt;
  if (stamps.hardware) {
    if (const auto at = from_hardware(*stamps.hardware, software.value_or(look_))) {
      return {*at, TimestampSource::hardware};
    }
  }
  if (software) return {*software, TimestampSource::kernel};
  return {look_, TimestampSource::thread};
}

}  // namespace can
