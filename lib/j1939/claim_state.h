#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

/// How a controller application comes to an address (SAE J1939-81). Pure; realtime safe.
namespace j1939 {

/// How far it has got with its address.
enum class ClaimState : std::uint8_t {
  listening,     ///< was given no address: receives only
  asking,        ///< the answers to its request for the addresses of all are waited for
  claiming,      ///< its claim is to be sent, or was sent less than 250 ms ago
  claimed,       ///< has its address
  cannot_claim,  ///< lost its address and found no other: may send nothing but that
};
inline constexpr unsigned kClaimStates = 5;

/// What moves it on. A claim that is only repeated is no event.
enum class ClaimEvent : std::uint8_t {
  ask,          ///< it begins, and asks for the addresses of all first
  claim,        ///< it claims an address: its own, another one that is free, or one that it is commanded to
  none_left,    ///< there is no address for it, or another has its NAME
  undisturbed,  ///< its claim was on the bus 250 ms ago
};
inline constexpr unsigned kClaimEvents = 4;

/// The state that follows `event`, which may be the same; nothing when the event cannot come in that state
/// and so changes nothing. docs/j1939.md has the table; a test walks through every pair.
std::optional<ClaimState> next(ClaimState state, ClaimEvent event) noexcept;

/// English words for documents and tests; the text lives as long as the program.
std::string_view name(ClaimState state) noexcept;
std::string_view name(ClaimEvent event) noexcept;

}  // namespace j1939
