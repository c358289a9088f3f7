#include "sync/phc.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/ptp_clock.h>

#include <cerrno>

namespace sync_line {
namespace {

/// Part of the interval for which the pulse lasts where the driver lets it be chosen.
constexpr int kPulsePart = 4;
constexpr unsigned kReadings = 5;

Time from_kernel(const ptp_clock_time& time) noexcept {
  return std::chrono::seconds(time.sec) + Time(time.nsec);
}

ptp_clock_time to_kernel(Time time) noexcept {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(time);
  ptp_clock_time out = {};
  out.sec = seconds.count();
  out.nsec = static_cast<std::uint32_t>((time - seconds).count());
  return out;
}

bool not_offered(int result) noexcept {
  return result == -EOPNOTSUPP || result == -ENOTTY || result == -EINVAL;
}

/// The narrowest of several windows around a reading, as [system, clock, system].
struct Window {
  ClockSample sample;
  bool any = false;

  void add(Time before, Time clock, Time after) noexcept {
    const Time width = after - before;
    if (any && width >= sample.uncertainty) return;
    any = true;
    sample = {before + width / 2, clock, width};
  }
};

}  // namespace

PhcDevice::PhcDevice(System& system, const PhcPin& pin, const PhcOptions& options)
    : system_(system), device_(system), pin_(pin) {
  open_or_throw(system, device_, options.device, pin.device, O_RDWR);
  ptp_clock_caps caps = {};
  if (const int result = system.control(device_.get(), PTP_CLOCK_GETCAPS2, &caps); result < 0) {
    throw SetupError(options.device, reason_and_remedy(pin.device, -result));
  }
  if (caps.n_per_out <= 0) {
    throw SetupError(
        options.device,
        fmt::format("{} has no periodic output; use a clock that has one, or output = \"gpio\"", pin.device));
  }
  if (pin.channel >= static_cast<std::uint32_t>(caps.n_per_out)) {
    throw SetupError(options.channel, fmt::format("found {}; {} has channels 0..{}", pin.channel, pin.device,
                                                  caps.n_per_out - 1));
  }
  if (pin.pin >= caps.n_pins) {
    throw SetupError(options.pin,
                     caps.n_pins == 0
                         ? fmt::format("found {}; the pins of {} are fixed, so give -1", pin.pin, pin.device)
                         : fmt::format("found {}; {} has pins 0..{}", pin.pin, pin.device, caps.n_pins - 1));
  }
  if (caps.cross_timestamping != 0) method_ = Method::precise;
  if (pin.pin >= 0) {
    ptp_pin_desc description = {};
    description.index = static_cast<unsigned>(pin.pin);
    description.func = PTP_PF_PEROUT;
    description.chan = pin.channel;
    if (const int result = system.control(device_.get(), PTP_PIN_SETFUNC2, &description); result < 0) {
      throw SetupError(options.pin,
                       reason_and_remedy(fmt::format("{} pin {}", pin.device, pin.pin), -result));
    }
  }
  if (!sample() && error_ != 0) throw SetupError(options.device, reason_and_remedy(pin.device, error_));
}

std::optional<ClockSample> PhcDevice::sample() noexcept {
  // The kernel gives its own side of the reading on CLOCK_REALTIME.
  const ClockDifference before = realtime_minus_monotonic(system_);
  std::optional<ClockSample> found;
  if (method_ == Method::precise) found = read_precise();
  if (!found && method_ == Method::extended) found = read_extended();
  if (!found && method_ == Method::plain) found = read_plain();
  if (!found) return std::nullopt;
  const ClockDifference after = realtime_minus_monotonic(system_);
  constexpr Time kSet = std::chrono::microseconds(2);
  if (std::chrono::abs(after.value - before.value) > kSet + before.uncertainty + after.uncertainty) {
    return std::nullopt;
  }
  const ClockDifference& narrow = after.uncertainty < before.uncertainty ? after : before;
  found->monotonic -= narrow.value;
  found->uncertainty += narrow.uncertainty;
  return found;
}

std::optional<ClockSample> PhcDevice::read_precise() noexcept {
  ptp_sys_offset_precise reading = {};
  const int result = system_.control(device_.get(), PTP_SYS_OFFSET_PRECISE2, &reading);
  if (not_offered(result)) method_ = Method::extended;
  error_ = result < 0 && !not_offered(result) ? -result : 0;
  if (result < 0) return std::nullopt;
  return ClockSample{from_kernel(reading.sys_realtime), from_kernel(reading.device), Time{0}};
}

std::optional<ClockSample> PhcDevice::read_extended() noexcept {
  ptp_sys_offset_extended reading = {};
  reading.n_samples = kReadings;
  const int result = system_.control(device_.get(), PTP_SYS_OFFSET_EXTENDED2, &reading);
  if (not_offered(result)) method_ = Method::plain;
  error_ = result < 0 && !not_offered(result) ? -result : 0;
  if (result < 0) return std::nullopt;
  Window narrowest;
  for (unsigned i = 0; i < kReadings; ++i) {
    const auto& stamps = reading.ts[i];
    narrowest.add(from_kernel(stamps[0]), from_kernel(stamps[1]), from_kernel(stamps[2]));
  }
  return narrowest.sample;
}

std::optional<ClockSample> PhcDevice::read_plain() noexcept {
  ptp_sys_offset reading = {};
  reading.n_samples = kReadings;
  const int result = system_.control(device_.get(), PTP_SYS_OFFSET2, &reading);
  error_ = result < 0 ? -result : 0;
  if (result < 0) return std::nullopt;
  Window narrowest;
  for (std::size_t i = 0; i < kReadings; ++i) {
    narrowest.add(from_kernel(reading.ts[2 * i]), from_kernel(reading.ts[2 * i + 1]),
                  from_kernel(reading.ts[2 * i + 2]));
  }
  return narrowest.sample;
}

bool PhcDevice::start(Time from, Time interval) noexcept {
  const Time first = (from + interval - Time(1)) / interval * interval;
  const Time pulse = interval / kPulsePart;
  // The output rises at its start time. For a falling SYNC the rise lies where the pulse ends.
  const bool falling = pin_.edge == Edge::falling;
  const Time start = falling ? first - interval + pulse : first;
  const Time on = falling ? interval - pulse : pulse;
  if (request(start, interval, on)) return true;
  if (!not_offered(-error_)) return false;
  // Without a choice the output is high for half of its period.
  return request(falling ? first - interval + interval / 2 : first, interval, Time{0});
}

bool PhcDevice::stop() noexcept {
  return request(Time{0}, Time{0}, Time{0});
}

/// `on` 0: whatever the driver does by itself. `interval` 0: off.
bool PhcDevice::request(Time start, Time interval, Time on) noexcept {
  ptp_perout_request request = {};
  request.start = to_kernel(start);
  request.period = to_kernel(interval);
  request.index = pin_.channel;
  if (on > Time{0}) {
    request.flags = PTP_PEROUT_DUTY_CYCLE;
    request.on = to_kernel(on);
  }
  const int result = system_.control(device_.get(), PTP_PEROUT_REQUEST2, &request);
  error_ = result < 0 ? -result : 0;
  return result >= 0;
}

}  // namespace sync_line
