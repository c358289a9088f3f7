#include "daemon/bus/socketcan_line.h"

#include <fmt/format.h>

#include <stdexcept>

#include "cansync/telegram.h"
#include "cansync/timing.h"
#include "daemon/bus/bit_timing_check.h"

namespace cansyncd {
namespace {

/// Frames with the number of an identifier, whatever their flags: remote and extended ones come too, to be
/// counted, as they do not belong here.
can::FrameFilter frames_numbered(std::uint32_t identifier) {
  return {.identifier = identifier, .extended = can::FlagFilter::either, .remote = can::FlagFilter::either};
}

/// Likewise, for a whole channel.
can::FrameFilter frames_of_channel(std::uint32_t channel) {
  can::FrameFilter filter = frames_numbered(channel);
  filter.mask &= ~cansync::identifier::number_bits;
  return filter;
}

can::LinkWatch::Settings watch_settings(const Config& config) {
  return {config.bus.interface, cansync::slot_times(config.master.bit_rate).bits_per_second,
          config.bus.one_shot == OneShot::enforce};
}

}  // namespace

can::SocketcanSettings socketcan_settings(const Config& config) {
  namespace identifier = cansync::identifier;
  can::SocketcanSettings settings;
  settings.wake_on_frame = config.bus.wake_on_frame;
  settings.interval = cansync::slot_times(config.master.bit_rate).interval;
  settings.filters = {frames_numbered(identifier::action), frames_of_channel(identifier::reference_one),
                      frames_of_channel(identifier::reference_two), frames_of_channel(identifier::command)};
  if (config.sync.input == SyncInput::can || config.sync.output == SyncOutput::can)
    settings.filters.push_back(frames_numbered(config.sync.can_identifier));
  for (std::uint32_t slave = 0; slave < cansync::kSlaves; ++slave) {
    if (!config.master.slaves[slave].configured) continue;
    settings.filters.push_back(frames_numbered(identifier::actual_one + slave));
    settings.filters.push_back(frames_numbered(identifier::actual_two + slave));
    settings.filters.push_back(frames_numbered(identifier::response + slave));
  }
  return settings;
}

std::string interface_refusal(const Config& config, const can::LinkFacts& facts) {
  const std::string& name = config.bus.interface;
  if (!facts.present) return "";
  if (!facts.is_can) return fmt::format("{} is no CAN interface; give another one as bus.interface", name);
  const std::uint32_t wanted = cansync::slot_times(config.master.bit_rate).bits_per_second;
  if (facts.timing && facts.timing->bits_per_second != wanted) {
    return fmt::format("{} is set to {} bit/s, bus.bit_rate is {}; set it with: {}", name,
                       facts.timing->bits_per_second, wanted, bit_rate_command(config));
  }
  if (config.bus.one_shot != OneShot::enforce || facts.one_shot.value_or(true)) return "";
  return fmt::format("{} is not in one-shot mode, bus.one_shot is \"enforce\"; {}", name,
                     one_shot_remedy(config, facts));
}

std::string one_shot_remedy(const Config& config, const can::LinkFacts& facts) {
  if (facts.can_one_shot.value_or(true)) return "set it with: " + one_shot_command(config);
  return "its driver has none: set bus.one_shot to \"ignore\", and let the daemon reset the controller "
         "(CAP_NET_ADMIN, see the example reset.conf)";
}

std::string one_shot_advice(const Config& config, const can::LinkFacts& facts) {
  if (config.bus.one_shot != OneShot::prefer || facts.one_shot.value_or(true)) return "";
  return fmt::format(
      "{} is not in one-shot mode: with nobody on the bus telegrams wait in the controller until the daemon "
      "has reset it; {}",
      config.bus.interface, one_shot_remedy(config, facts));
}

SocketcanLine::SocketcanLine(const Config& config)
    : links_(can::make_link_kernel()), watch_(*links_, board_, watch_settings(config)) {
  const can::LinkFacts facts = watch_.look();
  const std::string refusal = interface_refusal(config, facts);
  if (!refusal.empty()) throw std::runtime_error(refusal);
  advice_ = one_shot_advice(config, facts);
  bus_ = std::make_unique<can::SocketcanBus>(socketcan_settings(config), board_, *links_);
}

void SocketcanLine::start(Exchange& exchange) {
  thread_ = std::jthread([this, &exchange](const std::stop_token& stop) {
    watch_.run(stop, [&exchange](const can::LinkFacts& facts) {
      exchange.link.write(facts);
      exchange.gateway_wake.signal();
    });
  });
}

void SocketcanLine::stop() noexcept {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
}

}  // namespace cansyncd
