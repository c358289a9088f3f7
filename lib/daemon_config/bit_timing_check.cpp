#include "daemon_config/bit_timing_check.h"

#include <fmt/format.h>

#include <string_view>

#include "can/bit_timing.h"

namespace cansyncd {
namespace {

can::BitTimingRegisters registers(const BusConfig& bus) {
  return {bus.btr0.value_or(0), bus.btr1.value_or(0)};
}

/// The presets of this bit rate, as a hint.
std::string presets(std::uint32_t wanted) {
  std::string text;
  for (const can::BitTimingPreset& preset : can::kBitTimingPresets) {
    if (preset.bits_per_second != wanted) continue;
    text += fmt::format("{}0x{:02X} and 0x{:02X} ({})", text.empty() ? "" : ", ", preset.registers.btr0,
                        preset.registers.btr1, preset.controller == can::Controller::plc ? "plc" : "omega");
  }
  return text;
}

}  // namespace

std::optional<BitTimingProblem> check_bit_timing(const BusConfig& bus) {
  if (!bus.btr0 && !bus.btr1) return std::nullopt;
  if (!bus.btr0 || !bus.btr1) {
    const bool first = bus.btr0.has_value();
    return BitTimingProblem{
        first ? "bus.btr0" : "bus.btr1",
        fmt::format("found without {}; allowed: both together", first ? "bus.btr1" : "bus.btr0")};
  }
  const std::uint32_t wanted = bus.bits_per_second;
  const std::uint32_t clock = can::clock_hz(bus.registers_of);
  const auto timing = can::decode(registers(bus), clock);
  if (timing && timing->exact && timing->bits_per_second == wanted) return std::nullopt;
  const std::string found =
      timing ? fmt::format("{} bit/s at {} MHz", timing->bits_per_second, clock / 1'000'000)
             : std::string("a jump width over a segment");
  return BitTimingProblem{
      "bus.btr0",
      fmt::format("found 0x{:02X} and 0x{:02X}, which give {}; allowed: registers that give bus.bit_rate, {} "
                  "bit/s, as {} do",
                  *bus.btr0, *bus.btr1, found, wanted, presets(wanted))};
}

std::uint16_t wanted_sample_point(const BusConfig& bus) {
  can::BitTimingRegisters chosen = registers(bus);
  can::Controller controller = bus.registers_of;
  if (!bus.btr0 || !bus.btr1) {
    if (bus.sample_point) return *bus.sample_point;
    controller = can::Controller::plc;
    for (const can::BitTimingPreset& preset : can::kBitTimingPresets) {
      if (preset.controller == controller && preset.bits_per_second == bus.bits_per_second) {
        chosen = preset.registers;
      }
    }
  }
  const auto timing = can::decode(chosen, can::clock_hz(controller));
  return timing ? timing->sample_point : std::uint16_t{0};
}

std::string bit_rate_command(const BusConfig& bus, const can::LinkFacts& link) {
  const unsigned wanted = wanted_sample_point(bus);
  const std::string sample_point = wanted != 0 ? fmt::format(" sample-point 0.{:03}", wanted) : std::string();
  return fmt::format("ip link set {0} down; ip link set {0} type can bitrate {1}{2}{3}; ip link set {0} up",
                     bus.interface, bus.bits_per_second, sample_point,
                     link.listen_only ? " listen-only off" : "");
}

std::string set_up_command(const BusConfig& bus, const can::LinkFacts& link) {
  const std::string_view driver(link.driver_kind.data());
  if (driver.empty() || driver == "can") return bit_rate_command(bus, link);
  return fmt::format("ip link set {} up", bus.interface);
}

std::string one_shot_command(const BusConfig& bus) {
  return fmt::format("ip link set {0} down; ip link set {0} type can one-shot on; ip link set {0} up",
                     bus.interface);
}

}  // namespace cansyncd
