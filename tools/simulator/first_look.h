#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "can/link_facts.h"
#include "cansync/telegram/numbers.h"
#include "simulator/port.h"
#include "simulator/setup.h"

namespace cansync_sim {

/// How long a bus that is not virtual is listened to before the first frame.
inline constexpr can::Time kListen = std::chrono::seconds(1);

/// Who was heard on a bus.
struct Heard {
  std::optional<std::uint32_t> master;  ///< identifier of a frame that only a master sends
  cansync::SlaveMask slaves;            ///< those that sent something
};

/// "1, 5, 7".
std::string list_of(cansync::SlaveMask slaves);

/// True when frames on this interface reach no device: drivers "vcan" and "vxcan".
bool is_virtual(const can::LinkFacts& facts) noexcept;

/// Takes a frame of another node into account; `sync_identifier`: of the software SYNC frame.
void hear(const can::Frame& frame, std::uint32_t sync_identifier, Heard& heard) noexcept;

/// Listens for `kListen`, all of it with the interface up. Nothing: the program is to stop.
std::optional<Heard> listen(Port& port, std::uint32_t sync_identifier);

/// Why the program must not begin beside who was heard, with the remedy; empty: nothing is against it.
std::string conflict(const Setup& setup, const Heard& heard);

}  // namespace cansync_sim
