#include "sync/pps.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/pps.h>

namespace sync_line {

PpsInput::PpsInput(System& system, const PpsSource& source, const std::string& option)
    : system_(system), device_(system), assert_(source.edge == Edge::rising) {
  open_or_throw(system, device_, option, source.device, O_RDWR);
  int modes = 0;
  if (const int result = system.control(device_.get(), PPS_GETCAP, &modes); result < 0) {
    throw SetupError(option, reason_and_remedy(source.device, -result));
  }
  const int wanted = assert_ ? PPS_CAPTUREASSERT : PPS_CAPTURECLEAR;
  if ((modes & wanted) == 0) {
    throw SetupError(option, fmt::format("{} cannot capture the {} edge; choose the other one with "
                                         "sync.pps_edge",
                                         source.device, assert_ ? "assert" : "clear"));
  }
  // Capturing the assert edge is every driver's default; changing it needs CAP_SYS_TIME.
  pps_kparams parameters = {};
  if (const int result = system.control(device_.get(), PPS_GETPARAMS, &parameters); result < 0) {
    throw SetupError(option, reason_and_remedy(source.device, -result));
  }
  if ((parameters.mode & wanted) != 0) return;
  parameters.api_version = 1;
  parameters.mode |= wanted | PPS_TSFMT_TSPEC;
  if (const int result = system.control(device_.get(), PPS_SETPARAMS, &parameters); result < 0) {
    throw SetupError(option, reason_and_remedy(source.device, -result));
  }
}

bool PpsInput::take(Time /*near*/, Time& at) noexcept {
  if (turn_++ % kLookEvery != 0) return false;
  pps_fdata data = {};  // no timeout: tells the newest pulse at once
  const int result = system_.control(device_.get(), PPS_FETCH, &data);
  error_ = result < 0 ? -result : 0;
  if (error_ != 0) return false;
  const std::uint32_t sequence = assert_ ? data.info.assert_sequence : data.info.clear_sequence;
  if (seen_any_ && sequence == sequence_) return false;
  const bool fresh = seen_any_;
  seen_any_ = true;
  sequence_ = sequence;
  // The first look finds a pulse of unknown age.
  if (!fresh) return false;
  const pps_ktime& stamp = assert_ ? data.info.assert_tu : data.info.clear_tu;
  at = std::chrono::seconds(stamp.sec) + Time(stamp.nsec) - realtime_minus_monotonic(system_).value;
  return true;
}

}  // namespace sync_line
