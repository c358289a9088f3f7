#pragma once

#include <linux/gpio.h>
#include <linux/pps.h>
#include <linux/ptp_clock.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <deque>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "sync/system.h"

namespace sync_line::test {

/// Stands in for the kernel: one GPIO chip, one PPS source and one PTP clock, in virtual time. Each can be
/// made to fail with an error number.
class FakeSystem final : public System {
 public:
  static constexpr const char* kChip = "/dev/gpiochip0";
  static constexpr const char* kPps = "/dev/pps0";
  static constexpr const char* kPtp = "/dev/ptp0";

  // --- time
  Time now{std::chrono::seconds(100)};
  Time wall_offset{std::chrono::seconds(1'700'000'000)};  ///< CLOCK_REALTIME - CLOCK_MONOTONIC

  // --- faults
  std::map<std::string, int> open_error;       ///< by path
  std::map<unsigned long, int> control_error;  ///< by request
  int read_error = 0;

  // --- GPIO
  std::uint32_t lines = 8;
  std::set<std::uint32_t> busy_lines;
  gpio_v2_line_request requested = {};        ///< the last line request
  std::vector<std::pair<Time, bool>> levels;  ///< what an output line was set to (logical), and when
  std::deque<gpio_v2_line_event> events;      ///< an input line's edges not read yet
  bool nonblocking = false;
  unsigned reads = 0;

  // --- PPS
  int pps_modes = PPS_CAPTUREASSERT | PPS_TSFMT_TSPEC;
  int pps_mode = PPS_CAPTUREASSERT;
  pps_kinfo pps = {};
  unsigned fetches = 0;

  // --- PTP
  ptp_clock_caps caps = make_caps();
  ptp_pin_desc pin = {};
  std::vector<ptp_perout_request> periodic;
  bool duty_cycle = true;                            ///< the driver lets the pulse be chosen
  Time hardware_offset{std::chrono::seconds(5000)};  ///< hardware clock - CLOCK_MONOTONIC
  double hardware_rate = 1.0;                        ///< from `rate_from` on
  Time rate_from{std::chrono::seconds(100)};
  Time reading_width{std::chrono::nanoseconds(400)};
  std::set<unsigned long> asked;  ///< requests seen

  unsigned open_files = 0;

  Time hardware_at(Time at) const {
    const double passed = static_cast<double>((at - rate_from).count());
    return at + hardware_offset + Time(static_cast<Time::rep>(passed * (hardware_rate - 1.0)));
  }
  void edge_at(Time at) {
    gpio_v2_line_event event = {};
    event.timestamp_ns = static_cast<std::uint64_t>(at.count());
    events.push_back(event);
  }
  void pulse_at(Time at) {
    const Time wall = at + wall_offset;
    ++pps.assert_sequence;
    pps.assert_tu.sec = wall.count() / 1'000'000'000;
    pps.assert_tu.nsec = static_cast<std::int32_t>(wall.count() % 1'000'000'000);
  }

  int open(const char* path, int) noexcept override {
    if (const auto error = open_error.find(path); error != open_error.end()) return -error->second;
    const std::string name = path;
    if (name != kChip && name != kPps && name != kPtp) return -ENOENT;
    ++open_files;
    return name == kChip ? 10 : name == kPps ? 20 : 30;
  }
  void close(int) noexcept override { --open_files; }
  int set_nonblocking(int) noexcept override {
    nonblocking = true;
    return 0;
  }
  Time monotonic() noexcept override { return now; }
  Time realtime() noexcept override { return now + wall_offset; }

  long read(int, void* buffer, std::size_t size) noexcept override {
    ++reads;
    if (read_error != 0) return -read_error;
    if (events.empty()) return -EAGAIN;
    const std::size_t count = std::min(events.size(), size / sizeof(gpio_v2_line_event));
    std::copy_n(events.begin(), count, static_cast<gpio_v2_line_event*>(buffer));
    events.erase(events.begin(), events.begin() + static_cast<std::ptrdiff_t>(count));
    return static_cast<long>(count * sizeof(gpio_v2_line_event));
  }

  int control(int, unsigned long request, void* argument) noexcept override {
    asked.insert(request);
    if (const auto error = control_error.find(request); error != control_error.end()) return -error->second;
    switch (request) {
      case GPIO_GET_CHIPINFO_IOCTL:
        static_cast<gpiochip_info*>(argument)->lines = lines;
        return 0;
      case GPIO_V2_GET_LINE_IOCTL:
        return take_line(*static_cast<gpio_v2_line_request*>(argument));
      case GPIO_V2_LINE_SET_VALUES_IOCTL:
        levels.emplace_back(now, (static_cast<gpio_v2_line_values*>(argument)->bits & 1U) != 0);
        return 0;
      case PPS_GETCAP:
        *static_cast<int*>(argument) = pps_modes;
        return 0;
      case PPS_GETPARAMS:
        static_cast<pps_kparams*>(argument)->mode = pps_mode;
        return 0;
      case PPS_SETPARAMS:
        pps_mode = static_cast<pps_kparams*>(argument)->mode;
        return 0;
      case PPS_FETCH:
        ++fetches;
        static_cast<pps_fdata*>(argument)->info = pps;
        return 0;
      default:
        return control_clock(request, argument);
    }
  }

 private:
  static ptp_clock_caps make_caps() {
    ptp_clock_caps out = {};
    out.n_per_out = 2;
    out.n_pins = 4;
    return out;
  }
  static ptp_clock_time stamp(Time time) {
    ptp_clock_time out = {};
    out.sec = time.count() / 1'000'000'000;
    out.nsec = static_cast<std::uint32_t>(time.count() % 1'000'000'000);
    return out;
  }
  int take_line(gpio_v2_line_request& request) {
    if (busy_lines.count(request.offsets[0]) != 0) return -EBUSY;
    request.fd = 11;
    ++open_files;
    requested = request;
    return 0;
  }
  int control_clock(unsigned long request, void* argument) {
    const Time wall = now + wall_offset;
    switch (request) {
      case PTP_CLOCK_GETCAPS2:
        *static_cast<ptp_clock_caps*>(argument) = caps;
        return 0;
      case PTP_PIN_SETFUNC2:
        pin = *static_cast<ptp_pin_desc*>(argument);
        return 0;
      case PTP_SYS_OFFSET_PRECISE2: {
        auto& reading = *static_cast<ptp_sys_offset_precise*>(argument);
        reading.device = stamp(hardware_at(now));
        reading.sys_realtime = stamp(wall);
        return 0;
      }
      case PTP_SYS_OFFSET_EXTENDED2: {
        auto& reading = *static_cast<ptp_sys_offset_extended*>(argument);
        for (unsigned i = 0; i < reading.n_samples; ++i) {
          // The first window is the narrowest and the truest.
          const Time width = reading_width * (i + 1);
          reading.ts[i][0] = stamp(wall - width / 2);
          reading.ts[i][1] = stamp(hardware_at(now) + Time(i * 1000));
          reading.ts[i][2] = stamp(wall + width / 2);
        }
        return 0;
      }
      case PTP_SYS_OFFSET2: {
        auto& reading = *static_cast<ptp_sys_offset*>(argument);
        for (std::size_t i = 0; i < reading.n_samples; ++i) {
          const Time later = reading_width * static_cast<int>(i);
          reading.ts[2 * i] = stamp(wall + later - reading_width / 2);
          reading.ts[2 * i + 1] = stamp(hardware_at(now + later));
          reading.ts[2 * i + 2] = stamp(wall + later + reading_width / 2);
        }
        return 0;
      }
      case PTP_PEROUT_REQUEST2: {
        const auto& wanted = *static_cast<ptp_perout_request*>(argument);
        if (!duty_cycle && (wanted.flags & PTP_PEROUT_DUTY_CYCLE) != 0) return -EOPNOTSUPP;
        periodic.push_back(wanted);
        return 0;
      }
      default:
        return -ENOTTY;
    }
  }
};

/// The text of the SetupError that `make` throws; empty: none.
template <class Make>
std::string refusal(Make&& make) {
  try {
    make();
  } catch (const SetupError& error) {
    return error.what();
  }
  return "";
}

}  // namespace sync_line::test
