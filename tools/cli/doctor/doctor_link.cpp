#include "cli/doctor/doctor_link.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "can/adapter/adapters.h"
#include "can/adapter/link_remedy.h"
#include "can/bit_timing.h"
#include "can/bus_names.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

/// A queue shorter than an interval's telegrams refuses them; in a long one telegrams of past intervals wait.
constexpr std::uint32_t kShortestQueue = 4;
constexpr std::uint32_t kLongestQueue = 100;
/// A controller cannot make every sample point: half a quantum of a bit of 16 is as near as it may come.
constexpr int kSamplePointTolerance = 32;  // permille
/// Where a bus without slots wants 0.875, nodes may have 0.80 to 0.90 (SAE).
constexpr std::uint32_t kWideSamplePoint = 875;
constexpr int kEarliestWithoutSlots = -75;
constexpr int kLatestWithoutSlots = 25;
/// What a configuration without bus.bit_rate means.
constexpr std::uint32_t kUsualBitRate = 1'000'000;

std::string_view driver_kind(const can::LinkFacts& link) noexcept {
  const auto end = std::find(link.driver_kind.begin(), link.driver_kind.end(), '\0');
  return {link.driver_kind.data(), static_cast<std::size_t>(end - link.driver_kind.begin())};
}

bool is_virtual(const can::LinkFacts& link) noexcept {
  return !driver_kind(link).empty() && driver_kind(link) != "can";
}

/// Bit rate the interface should have: the daemon's; without one that which it has, when it is one of
/// CANsync.
std::optional<std::uint32_t> wanted_bit_rate(const DoctorInput& in) {
  if (in.status) return in.status->bus.bit_rate;
  if (!in.link.timing) return std::nullopt;
  const auto preset = std::find_if(can::kBitTimingPresets.begin(), can::kBitTimingPresets.end(),
                                   [&in](const can::BitTimingPreset& one) {
                                     return can::keeps_bit_rate(*in.link.timing, one.bits_per_second);
                                   });
  return preset != can::kBitTimingPresets.end() ? std::optional(preset->bits_per_second) : std::nullopt;
}

/// A line with SYNC has slots: nothing else begins at the time of a telegram, and none loses the arbitration.
bool has_slots(const DoctorInput& in) {
  return !in.status || in.status->master || !std::string_view(in.status->realtime.sync_state).empty();
}

/// Sample points that suit, the usual one first: that of the configuration when known, else on a CANsync line those of
/// the presets for this bit rate (M 4.9, O 7.3.9). None: any does.
std::vector<std::uint32_t> wanted_sample_points(const DoctorInput& in, std::uint32_t bit_rate) {
  if (in.status && in.status->bus.sample_point_wanted != 0) return {in.status->bus.sample_point_wanted};
  std::vector<std::uint32_t> points;
  if (!has_slots(in)) return points;
  for (const can::BitTimingPreset& preset : can::kBitTimingPresets) {
    if (preset.bits_per_second != bit_rate) continue;
    const auto timing = can::decode(preset.registers, can::clock_hz(preset.controller));
    if (timing) points.push_back(timing->sample_point);
  }
  return points;
}

/// Commands for an interface that must be down while it is set.
std::string set_link(const std::string& name, std::string_view setting) {
  return fmt::format("ip link set {0} down && ip link set {0} type can {1} && ip link set {0} up", name,
                     setting);
}

/// The command `ip` for the interface: also in the namespace that the example cansync-apart@.service makes.
std::string ip_of(const DoctorInput& in) {
  return is_apart(in) ? "ip -n cansync-" + in.interface_name : std::string("ip");
}

/// Commands that set the interface down and up.
std::string down_and_up(const DoctorInput& in) {
  return fmt::format("{0} link set {1} down && {0} link set {1} up", ip_of(in), in.interface_name);
}

/// Commands that set the bit timing and set the interface up.
std::string set_timing(const DoctorInput& in) {
  const std::uint32_t bit_rate = wanted_bit_rate(in).value_or(kUsualBitRate);
  const auto points = wanted_sample_points(in, bit_rate);
  std::string setting = fmt::format("bitrate {}", bit_rate);
  if (!points.empty()) setting += fmt::format(" sample-point 0.{:03}", points.front());
  if (in.link.listen_only) setting += " listen-only off";
  return set_link(in.interface_name, setting);
}

/// False when there is nothing to set.
bool look_at_presence(const DoctorInput& in, FindingList& out) {
  const std::string& name = in.interface_name;
  const std::string list = "ip -br link show type can";
  if (name == kSimulated) {
    out.ok("interface", "simulated line: no CAN interface");
    return false;
  }
  if (!in.kernel_silent.empty()) {
    out.warning("interface", fmt::format("the kernel cannot be asked for {}: {}", name, in.kernel_silent),
                "ip -details link show " + name);
    return false;
  }
  if (is_elsewhere(in)) {
    out.ok("interface", fmt::format("{} is on computer {}: `cansync doctor` there looks at it", name,
                                    client::text(in.status->gateway.host)));
    return false;
  }
  if (is_apart(in)) {
    out.ok("interface", fmt::format("{} is in a network namespace with the daemon, which has it", name));
    return false;
  }
  if (!in.link.present) {
    out.error("interface", fmt::format("{}: there is no such interface", name),
              can::link_remedy(name, in.link));
    return false;
  }
  if (!in.link.is_can) {
    out.error("interface", fmt::format("{} is no CAN interface", name), list + "   (then set bus.interface)");
    return false;
  }
  const bool nothing_to_set = is_virtual(in.link);
  if (!in.link.up) {
    const bool is_set =
        nothing_to_set ||
        (in.link.timing && can::keeps_bit_rate(*in.link.timing, wanted_bit_rate(in).value_or(0)));
    out.error("interface", fmt::format("{} is down", name),
              is_set && !in.link.listen_only ? fmt::format("ip link set {} up", name) : set_timing(in));
  } else if (nothing_to_set) {
    out.ok("interface", fmt::format("{} is up, virtual ({}): nothing to set", name, driver_kind(in.link)));
  } else if (in.link.listen_only) {
    out.warning("interface",
                fmt::format("{} is in listen-only mode: nothing is sent, and nothing acknowledged", name),
                can::sending_remedy(name));
  } else {
    out.ok("interface", fmt::format("{} is up", name));
  }
  return !nothing_to_set;
}

/// Whose drives does this name lead to, also after the next boot?
void look_at_adapter(const DoctorInput& in, FindingList& out) {
  const std::string& name = in.interface_name;
  const std::string wanted(in.status ? client::text(in.status->bus.adapter_wanted) : "");
  const std::string found = can::words_of(in.link.adapter);
  const auto allowed = can::interfaces_of(can::read_pin(wanted).pin, in.adapters);
  const std::string fix_name = fmt::format(
      "cansync scan {} --write FOLDER --interface-name can-line1, and cansync setup FOLDER", name);
  if (wanted.empty()) {
    if (in.adapters.size() < 2 || !in.link.adapter.known()) return;
    const auto pin = can::pin_of(name, in.adapters);
    const std::string set_pin =
        pin ? fmt::format("set bus.adapter = \"{}\"", can::text_of(*pin)) : std::string("set bus.adapter");
    if (can::is_kernel_name(name))
      out.warning("adapter",
                  fmt::format("{} of {} adapters; after a boot {} can be another one", found,
                              in.adapters.size(), name),
                  fmt::format("{}, and give it a fixed name: {}", set_pin, fix_name));
    else
      out.ok("adapter", fmt::format("{}; {} is no name that the kernel gives by itself", found, name));
  } else if (in.status->bus.link_state == can::name(can::LinkState::wrong_adapter)) {
    out.error(
        "adapter",
        fmt::format("{}, but bus.adapter is {}: nothing is sent or received; {}", found, wanted,
                    allowed.empty() ? std::string("that one is not there")
                                    : fmt::format("that one is {}", fmt::join(allowed, ", "))),
        fmt::format("plug the adapters in as they were, or correct bus.adapter; fixed names: {}", fix_name));
  } else if (allowed.size() > 1) {
    out.warning("adapter",
                fmt::format("bus.adapter is {}, which {} have", wanted, fmt::join(allowed, " and ")),
                "add path= or channel= to bus.adapter, so that only one matches");
  } else {
    out.ok("adapter", fmt::format("{}, as bus.adapter demands", found));
  }
}

void look_at_timing(const DoctorInput& in, FindingList& out) {
  if (!in.link.timing) {
    // A controller that was never set is down, which has been said.
    if (in.link.up)
      out.warning("bit rate", "its driver does not tell it", "ip -details link show " + in.interface_name);
    return;
  }
  const can::LinkTiming timing = *in.link.timing;
  const auto wanted = wanted_bit_rate(in);
  const std::string found = fmt::format("{} bit/s", timing.bits_per_second);
  if (!wanted) {
    out.error("bit rate", found + ": no bit rate of CANsync", set_timing(in));
    return;
  }
  if (!can::keeps_bit_rate(timing, *wanted)) {
    out.error("bit rate", fmt::format("{}, but the bus has {}: nothing is sent", found, *wanted),
              set_timing(in));
    return;
  }
  out.ok("bit rate", timing.bits_per_second == *wanted
                         ? found
                         : fmt::format("{}: the controller's clock makes no {}; up to 0.5 % is no matter",
                                       found, *wanted));
  const auto points = wanted_sample_points(in, *wanted);
  if (timing.sample_point == 0 || points.empty()) return;
  const std::string point = fmt::format("0.{:03}", timing.sample_point);
  const bool slots = has_slots(in);
  const bool suits = std::any_of(points.begin(), points.end(), [&](std::uint32_t one) {
    const bool wide = !slots && one == kWideSamplePoint;
    const int earliest = wide ? kEarliestWithoutSlots : -kSamplePointTolerance;
    const int latest = wide ? kLatestWithoutSlots : kSamplePointTolerance;
    const int later = static_cast<int>(timing.sample_point) - static_cast<int>(one);
    return later >= earliest && later <= latest;
  });
  if (suits)
    out.ok("sample point", point);
  else
    out.warning(
        "sample point",
        fmt::format("{} instead of 0.{:03}: on long lines bits are read wrongly", point, points.front()),
        set_timing(in) + "   (or set bus.btr0 and bus.btr1 to what the line has)");
}

void look_at_restart(const DoctorInput& in, FindingList& out) {
  if (!in.link.restart_ms) return;
  if (*in.link.restart_ms == 0)
    out.warning("restart-ms", "0: after bus-off the controller stays silent until somebody restarts it",
                set_link(in.interface_name, "restart-ms 100"));
  else
    out.ok("restart-ms", fmt::format("{} ms after bus-off the kernel restarts it", *in.link.restart_ms));
}

/// Without one-shot a frame that nobody acknowledges is repeated for ever, and goes out late; with it, one
/// that loses the arbitration is not sent.
void look_at_one_shot(const DoctorInput& in, FindingList& out) {
  if (!in.link.one_shot) return;
  if (!has_slots(in)) {
    if (*in.link.one_shot)
      out.warning("one-shot", "on: a frame that loses the arbitration is not sent",
                  set_link(in.interface_name, "one-shot off"));
    else
      out.ok("one-shot", "off: a frame that loses the arbitration is sent after the other");
    return;
  }
  if (*in.link.one_shot)
    out.ok("one-shot", "on: no telegram goes out late");
  else if (in.link.can_one_shot.value_or(true))
    out.warning(
        "one-shot", "off: with nobody on the bus telegrams wait in the controller and go out late",
        set_link(in.interface_name, "one-shot on") + "   (with systemd-networkd: OneShot=yes in [CAN])");
  else
    out.ok("one-shot",
           "its driver has none: the daemon holds telegrams back and resets the controller (CAP_NET_ADMIN)");
}

/// Without echoes of its driver the kernel takes a frame for sent when it is handed over.
void look_at_echo(const DoctorInput& in, FindingList& out) {
  if (in.link.echoes)
    out.ok("echo", "its driver tells when a frame was on the bus");
  else
    out.warning("echo",
                "its driver does not tell when a frame was on the bus: nobody can know that it was not",
                "use another adapter; ip link show " + in.interface_name + " says ECHO for those that do");
}

void look_at_queue(const DoctorInput& in, FindingList& out) {
  const std::uint32_t length = in.link.queue_length;
  const std::string found = text::counted(length, "frame");
  const std::string remedy = fmt::format("ip link set {} txqueuelen 10", in.interface_name);
  if (length < kShortestQueue)
    out.warning("txqueuelen", found + ": an interval's telegrams do not fit", remedy);
  else if (length > kLongestQueue)
    out.warning("txqueuelen", found + ": telegrams of past intervals can wait in it", remedy);
  else
    out.ok("txqueuelen", found);
}

/// Out of bus-off, as root; and by the daemon, where its protocol has a command for it and it has the right.
std::string out_of_bus_off(const DoctorInput& in) {
  std::string as_root = down_and_up(in);
  if (!in.status || in.status->reset_command.empty()) return as_root;
  return fmt::format("{}; or as root: {}", in.status->reset_command, as_root);
}

void look_at_state(const DoctorInput& in, std::string_view state, const std::string& wiring,
                   FindingList& out) {
  if (state == "error-active")
    out.ok("controller", std::string(state));
  else if (state == "bus-off")
    out.error("controller", "bus-off: takes no part in the bus", out_of_bus_off(in));
  else if (state == "stopped")
    out.error("controller", "stopped", fmt::format("{} link set {} up", ip_of(in), in.interface_name));
  else
    out.warning("controller", std::string(state), wiring);
}

/// Does anybody acknowledge what the daemon sends?
void look_at_delivery(const DoctorInput& in, const std::string& wiring, FindingList& out) {
  const std::string_view state = in.status->bus.link_state;
  if (state == can::name(can::Delivery::unacknowledged))
    out.error("controller", "nobody on the bus acknowledges what the daemon sends", wiring);
  else if (state == can::name(can::Delivery::not_emptied))
    out.error(
        "controller",
        "nobody on the bus acknowledges, and it cannot be reset: telegrams stand in it and go out later",
        "before the cable is back: " + down_and_up(in));
}

}  // namespace

bool is_elsewhere(const DoctorInput& in) {
  return in.status && !client::text(in.status->gateway.host).empty() &&
         client::text(in.status->gateway.host) != in.host_name;
}

bool is_apart(const DoctorInput& in) {
  return !in.link.present && in.kernel_silent.empty() && in.interface_name != kSimulated && in.status &&
         !is_elsewhere(in) && in.status->bus.link_state != can::name(can::LinkState::missing);
}

void look_at_link(const DoctorInput& in, FindingList& out) {
  const bool has_settings = look_at_presence(in, out);
  if (in.link.is_can && !is_elsewhere(in)) look_at_adapter(in, out);
  if (!has_settings) return;
  look_at_timing(in, out);
  look_at_restart(in, out);
  look_at_one_shot(in, out);
  look_at_echo(in, out);
  look_at_queue(in, out);
}

void look_at_controller(const DoctorInput& in, FindingList& out) {
  const std::string wiring = fmt::format(
      "check wiring, the two terminators of 120 ohm and every slave's bit rate; {} -details -statistics "
      "link show {}",
      ip_of(in), in.interface_name);
  std::uint32_t transmit = in.link.transmit_errors;
  std::uint32_t receive = in.link.receive_errors;
  if (in.status) {
    look_at_delivery(in, wiring, out);
    look_at_state(in, in.status->bus.controller_state, wiring, out);
    transmit = in.status->bus.transmit_errors;
    receive = in.status->bus.receive_errors;
  } else {
    // One that is down is stopped, which has been said.
    if (in.link.up && in.link.state) look_at_state(in, can::name(*in.link.state), wiring, out);
    if (!in.link.has_counters) return;
  }
  const std::string counters = fmt::format("{} transmit, {} receive", transmit, receive);
  if (transmit == 0 && receive == 0)
    out.ok("error counters", counters);
  else
    out.warning("error counters", counters, wiring);
}

}  // namespace cansync::cli
