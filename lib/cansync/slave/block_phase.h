#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

/// The phases of a block that a slave gives or takes (M 3.2.1.3). Pure; realtime safe.
namespace cansync {

/// How far the application has got with it.
enum class BlockPhase : std::uint8_t {
  none,       ///< there is no block
  beginning,  ///< the master has asked for it, and the application has not begun it
  open,       ///< bytes are moved
};
inline constexpr unsigned kBlockPhases = 3;

/// What the master or the application means for it.
enum class BlockEvent : std::uint8_t {
  later,  ///< the application begins it later
  begun,  ///< the application has begun it
  over,   ///< it is over for the application, and the master asks for the same block again
  ended,  ///< complete, refused, cancelled or replaced
};
inline constexpr unsigned kBlockEvents = 4;

/// The phase that follows `event`, which may be the same; nothing when the event cannot come in that phase
/// and so changes nothing. docs/cansync-slave.md has the table; a test walks through every pair.
std::optional<BlockPhase> next(BlockPhase phase, BlockEvent event) noexcept;

/// English words for documents and tests; the text lives as long as the program.
std::string_view name(BlockPhase phase) noexcept;
std::string_view name(BlockEvent event) noexcept;

}  // namespace cansync
