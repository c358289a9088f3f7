#include "layer2/status_image.h"

#include <algorithm>

namespace layer2 {
namespace {

constexpr std::uint16_t kWarning = 96;
constexpr std::uint16_t kPassive = 128;

constexpr std::uint8_t bit(bool set, unsigned place) noexcept {
  return static_cast<std::uint8_t>(set ? 1u << place : 0u);
}

constexpr std::uint8_t counter(std::uint16_t errors) noexcept {
  return static_cast<std::uint8_t>(std::min<std::uint16_t>(errors, 255));
}

std::uint8_t half(const StatusFacts::Queues& queues) noexcept {
  return static_cast<std::uint8_t>(bit(queues.high_half_full, 3) | bit(queues.overflowed, 2) |
                                   bit(queues.normal_half_full, 1) | bit(queues.empty, 0));
}

std::uint8_t state_byte(const StatusFacts& facts) noexcept {
  return static_cast<std::uint8_t>(bit(error_register(facts) != 0, 7) | bit(true, 6) | bit(facts.running, 0));
}

}  // namespace

std::uint8_t error_register(const StatusFacts& facts) noexcept {
  const bool transmit_warning = facts.bus_off || facts.transmit_errors >= kWarning;
  const bool receive_warning = facts.receive_errors >= kWarning;
  return static_cast<std::uint8_t>(bit(facts.receive_overrun, 6) | bit(facts.bus_off, 5) |
                                   bit(facts.bus_off || facts.transmit_errors >= kPassive, 4) |
                                   bit(facts.receive_errors >= kPassive, 3) | bit(transmit_warning, 2) |
                                   bit(receive_warning, 1) | bit(transmit_warning || receive_warning, 0));
}

std::uint8_t queue_byte(const StatusFacts& facts) noexcept {
  return static_cast<std::uint8_t>(half(facts.send) << 4 | half(facts.receive));
}

std::array<std::uint8_t, 16> status_image(const StatusFacts& facts) noexcept {
  std::array<std::uint8_t, 16> image = {};
  image[0] = state_byte(facts);
  image[1] = error_register(facts);
  image[2] = queue_byte(facts);
  image[3] = counter(facts.transmit_errors);
  image[4] = counter(facts.receive_errors);
  image[8] = facts.node;
  return image;
}

BusFault bus_fault(const StatusFacts& facts) noexcept {
  const std::uint16_t worst = std::max(facts.transmit_errors, facts.receive_errors);
  if (facts.bus_off) return BusFault::bus_off;
  if (facts.stopped) return BusFault::stopped;
  if (worst >= kPassive) return BusFault::passive;
  if (worst != 0) return BusFault::errors;
  const bool lost = facts.receive_overrun || facts.send.overflowed || facts.receive.overflowed;
  return lost ? BusFault::overflow : BusFault::off;
}

std::string_view name_of(BusFault fault) noexcept {
  switch (fault) {
    case BusFault::off:
      return "off";
    case BusFault::bus_off:
      return "bus-off";
    case BusFault::stopped:
      return "stopped";
    case BusFault::passive:
      return "passive";
    case BusFault::errors:
      return "errors";
    case BusFault::overflow:
      break;
  }
  return "overflow";
}

std::uint16_t status_word(const StatusFacts& facts) noexcept {
  return static_cast<std::uint16_t>(state_byte(facts) << 8 | queue_byte(facts));
}

}  // namespace layer2
