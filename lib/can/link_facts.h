#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "can/adapter/adapter.h"
#include "can/bus.h"

namespace can {

/// Bit timing an interface is set to.
struct LinkTiming {
  std::uint32_t bits_per_second = 0;
  std::uint16_t sample_point = 0;  ///< in 1/1000 of a bit
  friend bool operator==(const LinkTiming&, const LinkTiming&) = default;
};

/// True when an interface with this timing is in step with nodes of `bits_per_second`: a controller whose clock does
/// not divide exactly is set to a bit rate beside the wanted one. Half a percent is what two nodes may differ by.
constexpr bool keeps_bit_rate(const LinkTiming& timing, std::uint32_t bits_per_second) noexcept {
  constexpr std::uint64_t kOneIn = 200;
  const std::uint64_t is = timing.bits_per_second;
  const std::uint64_t wanted = bits_per_second;
  return (is > wanted ? is - wanted : wanted - is) * kOneIn <= wanted;
}

/// What the kernel knows about a network interface. A virtual one has neither timing nor controller.
struct LinkFacts {
  bool present = false;
  std::uint32_t index = 0;  ///< over 0 when present
  bool is_can = false;
  bool up = false;
  std::uint32_t queue_length = 0;      ///< txqueuelen, in frames
  std::array<char, 16> driver_kind{};  ///< "can", "vcan", ..., as text with a zero at its end
  std::optional<LinkTiming> timing;
  std::optional<ControllerState> state;
  std::optional<std::uint32_t> restart_ms;  ///< time until the kernel restarts a bus-off controller; 0: never
  bool has_counters = false;                ///< the two error counters are known
  std::uint16_t transmit_errors = 0;
  std::uint16_t receive_errors = 0;
  bool echoes = false;           ///< its driver tells when a frame was on the bus, not when it was given one
  std::optional<bool> one_shot;  ///< each frame is tried once; nothing: no real controller
  bool listen_only = false;      ///< the controller neither sends nor acknowledges
  std::optional<bool>
      can_one_shot;  ///< its driver has that mode; nothing: the kernel does not tell (before 5.17)
  Adapter adapter;   ///< the hardware behind it; netlink says nothing of it
  friend bool operator==(const LinkFacts&, const LinkFacts&) = default;
};

/// Reads the kernel's answer to a RTM_GETLINK request: one netlink message, or several. Nothing when it tells
/// nothing of an interface `name`: an error, another interface, or cut off. Pure; never reads beyond the
/// bytes.
std::optional<LinkFacts> read_link_message(std::span<const std::byte> bytes, std::string_view name) noexcept;

}  // namespace can
