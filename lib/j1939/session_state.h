#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

/// A message that is being put together out of packets (SAE J1939-21). Pure; realtime safe.
namespace j1939 {

/// What is waited for.
enum class SessionState : std::uint8_t {
  free,    ///< nothing: there is no message
  packet,  ///< the next packet
  offset,  ///< extended form: that the sender says which packets follow
  window,  ///< the last packet of the window, after which those that were missed are asked for again
};
inline constexpr unsigned kSessionStates = 4;

/// What a message, its absence or an own request for packets means.
enum class SessionEvent : std::uint8_t {
  begun,           ///< a message is announced, or a connection asked for
  asked,           ///< packets were asked for
  asked_extended,  ///< so they were, in the extended form
  offset_came,     ///< the sender has said which packets follow
  packet_missing,  ///< of a connection: a later packet came, not the next one
  ended,           ///< the message is whole, or given up
};
inline constexpr unsigned kSessionEvents = 6;

/// The state that follows `event`, which may be the same; nothing when the event cannot come in that state
/// and so changes nothing. docs/j1939.md has the table; a test walks through every pair.
std::optional<SessionState> next(SessionState state, SessionEvent event) noexcept;

/// English words for documents and tests; the text lives as long as the program.
std::string_view name(SessionState state) noexcept;
std::string_view name(SessionEvent event) noexcept;

}  // namespace j1939
