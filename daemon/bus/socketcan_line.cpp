#include "daemon/bus/socketcan_line.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>
#include <utility>

#include "daemon/bus/adapter_text.h"
#include "daemon_config/bit_timing_check.h"

namespace cansyncd {
namespace {

can::LinkWatch::Settings watch_settings(const BusConfig& bus) {
  return {bus.interface, bus.bits_per_second, bus.one_shot == OneShot::enforce,
          can::read_pin(bus.adapter).pin};
}

/// What stands in the way when the command was tried already.
std::string inexact_clock(const can::LinkFacts& facts, std::uint32_t wanted) {
  constexpr double kKernel = 0.05;  // what it accepts
  const double off = std::abs(static_cast<double>(facts.timing->bits_per_second) / wanted - 1);
  if (off > kKernel) return "";
  return fmt::format(
      ". It may be {:.1f} % off because the controller's clock makes no better one; allowed: 0.5 %, so take "
      "another adapter or another bit rate",
      off * 100);
}

}  // namespace

can::SocketcanSettings socketcan_settings(const BusPlan& plan) {
  can::SocketcanSettings settings;
  settings.wake_on_frame = plan.bus.wake_on_frame;
  settings.interval = plan.interval;
  return settings;
}

std::string interface_refusal(const BusConfig& bus, const can::LinkFacts& facts) {
  const std::string& name = bus.interface;
  if (!facts.present) return "";
  if (!facts.is_can) return fmt::format("{} is no CAN interface; give another one as bus.interface", name);
  if (!can::matches(can::read_pin(bus.adapter).pin, facts.adapter)) return wrong_adapter_text(bus, facts);
  // One that is down may not have been set up yet, at a boot.
  if (!facts.up) return "";
  const std::uint32_t wanted = bus.bits_per_second;
  if (facts.timing && !can::keeps_bit_rate(*facts.timing, wanted)) {
    return fmt::format("{} is set to {} bit/s, bus.bit_rate is {}; set it with: {}{}", name,
                       facts.timing->bits_per_second, wanted, bit_rate_command(bus, facts),
                       inexact_clock(facts, wanted));
  }
  if (bus.one_shot != OneShot::enforce || facts.one_shot.value_or(true)) return "";
  return fmt::format("{} is not in one-shot mode, bus.one_shot is \"enforce\"; {}", name,
                     one_shot_remedy(bus, facts));
}

std::string one_shot_remedy(const BusConfig& bus, const can::LinkFacts& facts) {
  if (facts.can_one_shot.value_or(true)) return "set it with: " + one_shot_command(bus);
  return "its driver has none: set bus.one_shot to \"ignore\", and let the daemon reset the controller "
         "(CAP_NET_ADMIN, see the example reset.conf)";
}

std::string one_shot_advice(const BusConfig& bus, const can::LinkFacts& facts) {
  if (bus.one_shot != OneShot::prefer || facts.one_shot.value_or(true)) return "";
  return fmt::format(
      "{} is not in one-shot mode: with nobody on the bus telegrams wait in the controller until the daemon "
      "has reset it; {}",
      bus.interface, one_shot_remedy(bus, facts));
}

SocketcanLine::SocketcanLine(const BusPlan& plan) : links_(can::make_link_kernel()) {
  const can::LinkFacts facts = links_->read(plan.bus.interface);
  const std::string refusal = interface_refusal(plan.bus, facts);
  if (!refusal.empty()) throw std::runtime_error(refusal);
  advice_ = one_shot_advice(plan.bus, facts);
  sockets_.emplace(plan.filters);
  watch_.emplace(*links_, board_, *sockets_, watch_settings(plan.bus));
  watch_->look();
  bus_ = std::make_unique<can::SocketcanBus>(socketcan_settings(plan), board_, *links_);
}

void SocketcanLine::start(LinkListener listener) {
  thread_ = std::jthread(
      [this, listener = std::move(listener)](const std::stop_token& stop) { watch_->run(stop, listener); });
}

void SocketcanLine::stop() noexcept {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
}

}  // namespace cansyncd
