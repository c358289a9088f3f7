#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

/// The phases of one upload or download on the command channel (M 3.2.1.3), the same for both directions.
/// Pure; realtime safe.
namespace cansync {

/// Which telegram of a transfer is to be sent.
enum class TransferPhase : std::uint8_t {
  initialise,  ///< the one that begins a block
  body,        ///< six bytes of the block, or the last of them
  cancel,      ///< the one that closes what the slave may have open
  ended,       ///< none: the result is final
};
inline constexpr unsigned kTransferPhases = 4;

/// What an answer, its absence or the clock means for a transfer. What only repeats a telegram is no event.
enum class TransferEvent : std::uint8_t {
  accepted,     ///< the slave has begun the block
  bytes_taken,  ///< six bytes went over, and the block has more
  block_done,   ///< the block is complete, and another one follows
  given_up,     ///< the block is given up, and the slave may have it open
  begun_again,  ///< the slave has nothing open, or does not say: the block begins anew
  ended,        ///< everything went over, or the transfer failed or was cancelled
};
inline constexpr unsigned kTransferEvents = 6;

/// The phase that follows `event`, which may be the same; nothing when the event cannot come in that phase
/// and so changes nothing. docs/cansync-protocol.md has the table; a test walks through every pair.
std::optional<TransferPhase> next(TransferPhase phase, TransferEvent event) noexcept;

/// English words for documents and tests; the text lives as long as the program.
std::string_view name(TransferPhase phase) noexcept;
std::string_view name(TransferEvent event) noexcept;

}  // namespace cansync
