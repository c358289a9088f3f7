#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

/// The hardware behind a CAN interface, and what a configuration says of it. Pure functions; not for the
/// realtime thread (they allocate).
namespace can {

/// What distinguishes one CAN controller of this computer from the others. A virtual interface has nothing of
/// it.
struct Adapter {
  std::array<char, 64> path{};    ///< of the slot or port, as udev's ID_PATH; empty: not known
  std::array<char, 40> serial{};  ///< of the USB device, as udev's ID_SERIAL_SHORT; empty: it has none
  std::uint32_t channel = 0;      ///< number of the controller on its adapter, from 0
  /// It is known which one it is.
  bool known() const noexcept { return path.front() != '\0' || serial.front() != '\0'; }
  friend bool operator==(const Adapter&, const Adapter&) = default;
};

/// Which adapter an interface must have; what is empty matches every one.
struct AdapterPin {
  std::string path;
  std::string serial;
  std::optional<std::uint32_t> channel;
};

/// A pin as a configuration gives it: "path=PATH", "serial=NUMBER", "channel=N", in any order, with commas.
struct ReadPin {
  AdapterPin pin;
  std::string problem;  ///< what was found and what is allowed; empty: nothing is wrong
};

/// Reads `text`; an empty one is a pin that matches every adapter.
ReadPin read_pin(std::string_view text);

/// Is `adapter` one that `pin` allows? One that is not known suits the empty pin alone.
bool matches(const AdapterPin& pin, const Adapter& adapter) noexcept;

/// In the form of `read_pin`; empty: it is not known. At most 127 characters.
std::string text_of(const Adapter& adapter);
/// In the form of `read_pin`.
std::string text_of(const AdapterPin& pin);

/// `adapter` for people: as `text_of`, or what it means that it is not known.
std::string words_of(const Adapter& adapter);

}  // namespace can
