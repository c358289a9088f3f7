#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "cansync/observe/evidence.h"
#include "cansync/settings/timing.h"
#include "cansync/telegram/errors.h"
#include "cansync/telegram/numbers.h"
#include "cansync/telegram/telegram.h"

/// What was on a recorded line: facts alone, no configuration of ours. Plain values; not for the realtime
/// thread.
namespace cansync::observe {

/// Where in the interval a kind of telegram stands; commands before the first reference values go elsewhere.
enum class Place : std::uint8_t {
  response,
  reference_one,
  actual_one,
  reference_two,
  actual_two,
  command,
  set_up_command,
  set_up_response,
};
inline constexpr unsigned kPlaces = 8;

/// When telegrams of a kind were started, after the SYNC edge, to the microsecond.
struct SlotUse {
  std::uint64_t count = 0;  ///< telegrams
  Duration usual{};         ///< most frequent
  Duration earliest{};
  Duration latest{};
};

/// Two neighbouring words of a process data telegram: are they one doubleword?
struct PairUse {
  std::uint64_t carries = 0;  ///< the upper one moved as the high word of a value that moves steadily
  std::uint64_t breaks = 0;   ///< it moved otherwise
};

/// The numbers that a word or doubleword had, read with a sign.
struct NumberRange {
  std::uint64_t count = 0;    ///< telegrams with it
  std::int64_t least = 0;     ///< of them
  std::int64_t greatest = 0;  ///< likewise
  std::int64_t step = 0;      ///< greatest difference from one telegram to the next
  std::int64_t newest = 0;    ///< of the newest telegram
  /// The next telegram has `number`.
  void add(std::int64_t number) noexcept;
};

/// One kind of process data telegram of one sender.
struct TelegramUse {
  std::uint64_t count = 0;                     ///< telegrams
  std::array<std::uint64_t, 5> by_words = {};  ///< telegrams of 0..4 words
  std::uint8_t moved = 0;                      ///< bit n: word n had more than one value
  std::uint8_t not_zero = 0;                   ///< bit n: word n was not always 0
  std::array<PairUse, 2> pair = {};            ///< words 0 and 1, words 2 and 3
  std::array<NumberRange, 4> word = {};        ///< each word by itself
  std::array<NumberRange, 2> doubleword = {};  ///< the pairs as doublewords, low word first
};

/// Whom the reference telegrams of a channel ask.
struct PollingUse {
  std::array<std::uint64_t, 128> asked = {};  ///< telegrams by N
  std::uint64_t rises = 0;                    ///< N + 1 follows on N in the next interval
  std::uint64_t wraps = 0;                    ///< 0 follows on a higher N in the next interval
  std::uint64_t stays = 0;                    ///< N follows on N
  std::uint64_t jumps = 0;                    ///< anything else
  std::uint8_t wraps_from_least = 127;        ///< of the wraps: the numbers they came from
  std::uint8_t wraps_from_most = 0;           ///< the highest of them
};

/// Answers of a slave to commands.
struct ResponseUse {
  std::uint64_t count = 0;  ///< telegrams
  Duration shortest{};      ///< end of the command to start of the answer
  Duration longest{};
  Duration sum{};
  std::uint64_t slow = 0;  ///< over tRSPTO
};

/// What is known of one slave number.
struct SlaveUse {
  std::uint64_t commands = 0;    ///< sent to it, repeated ones included
  std::uint64_t answers = 0;     ///< that fit the command before
  std::uint64_t busy = 0;        ///< of those
  std::uint64_t refused = 0;     ///< of those: with an error code
  std::uint64_t unanswered = 0;  ///< commands
  std::uint64_t stray = 0;       ///< answers that fit no command
  ResponseUse response;
  std::array<TelegramUse, kChannels> actual = {};
  std::array<std::uint64_t, kChannels> missed_actual = {};  ///< asked, and nothing came in that interval
  std::uint64_t cancels = 0;                                ///< cancel telegrams of transfers
  std::uint64_t cancels_taken = 0;                          ///< answered without an error
  std::uint64_t cancels_refused = 0;                        ///< answered with an error
  TransferError cancel_error = TransferError::none;         ///< the last of those
  std::uint64_t transfers_before_cancel = 0;  ///< transfers begun before the first cancel telegram
  std::uint16_t longest_block = 0;            ///< bytes
  std::uint16_t continued_block = 0;          ///< longest one with another one of the same transfer behind it
  std::uint64_t continued_blocks = 0;         ///< how many had
};

/// One parameter of a participant, as far as it was read or written.
struct ParameterUse {
  SlaveNumber slave;
  SubSlave sub_slave;
  ParameterNumber number;
  Element element;
  std::uint64_t reads = 0;                      ///< answered with a value
  std::uint64_t set_up_reads = 0;               ///< commands during start-up
  std::uint64_t writes = 0;                     ///< confirmed
  std::uint64_t refused = 0;                    ///< answered with an error code
  ParameterError error = ParameterError::none;  ///< the last refusal
  std::uint32_t value = 0;                      ///< last one read, raw
  std::uint32_t least = 0;                      ///< of those read
  std::uint32_t most = 0;                       ///< likewise
  bool doubleword = false;                      ///< format of the last value read or written
  bool written_last = false;                    ///< the newest is one written, not one read
  std::uint32_t written = 0;                    ///< last one confirmed
  bool bit_15_rose = false;                     ///< read without, later with bit 15, during start-up
  bool bit_15_fell = false;                     ///< the other way round, likewise
  bool answered_in_set_up = false;              ///< with a value
  std::uint32_t set_up_value = 0;               ///< last one read during start-up
  std::optional<Duration> asked;                ///< first command
  /// In operation, while the newest value has bit 15: intervals from one read to the next, most frequent of
  /// the first ones; how many stood so far apart.
  std::uint32_t period = 0;
  std::uint64_t periods = 0;          ///< reads that stood so far apart
  std::optional<Duration> last_read;  ///< newest read command
};

/// How a step of the master ended.
enum class StepEnd : std::uint8_t { done, refused, unanswered, open };

/// A parameter written.
struct WriteStep {
  ParameterCommand command;
  StepEnd end = StepEnd::open;
  ParameterError error = ParameterError::none;
};
/// An action command, a control word or another.
struct ActionStep {
  ActionCommand action;
};
/// An upload or download, of as many blocks as belong together.
struct TransferStep {
  TransferInitialise::Direction direction = TransferInitialise::Direction::upload;
  SlaveNumber slave;
  SubSlave sub_slave;
  std::uint32_t address = 0;  ///< of the first block
  std::uint32_t bytes = 0;    ///< of all blocks, as asked
  std::uint32_t blocks = 0;   ///< begun
  StepEnd end = StepEnd::open;
  TransferError error = TransferError::none;
  std::vector<std::uint8_t> data;  ///< what went over, while there is room
  bool whole = false;              ///< `data` has every byte
};

/// What the master did, in its order; equal ones in a row are counted.
struct Step {
  Duration at{};              ///< since the first frame of the recording
  bool in_operation = false;  ///< after the first reference values
  std::uint64_t count = 1;    ///< equal ones in a row
  std::variant<WriteStep, ActionStep, TransferStep> what;
};

/// A command of a job, for the order in which slaves are served.
struct ServedCommand {
  IntervalNumber interval = 0;
  SlaveNumber slave;
};

/// Everything. Start-up is what comes before the first reference values. Bounded whatever the recording has
/// in it; `*_over` count what found no room.
struct Observation {
  BitRate bit_rate = BitRate::mbit1;  ///< of the interval
  bool bit_rate_given = false;        ///< it was known beforehand
  LineEvidence evidence;
  StampCheck::Result stamps;
  std::uint64_t interval_votes = 0;  ///< neighbours of a kind that stood one interval apart; 0: unknown
  std::uint64_t interval_votes_against = 0;  ///< that stood one interval of another bit rate apart
  bool sync_seen = false;                    ///< the recording has SYNC edges
  Duration interval{};                       ///< mean, by the recording's clock
  Duration length{};                         ///< first to last frame
  std::uint64_t frames = 0;                  ///< of every kind
  std::uint64_t edges = 0;                   ///< SYNC edges
  std::uint64_t intervals = 0;               ///< that the recording spans
  std::uint64_t busy_bits = 0;               ///< of all frames
  std::uint64_t error_frames = 0;            ///< as the log has them
  std::array<std::uint64_t, kDecodeErrors> no_telegram = {};  ///< frames by DecodeError

  std::array<SlotUse, kPlaces> slot =
      {};  ///< empty when time stamps are bunched or coarse; so are the times of answers
  std::array<TelegramUse, kChannels> reference = {};
  std::array<PollingUse, kChannels> polling = {};
  std::array<std::uint64_t, 128> polling_distance = {};  ///< both channels: N of WRC2 - N of WRC1 by 128
  std::uint64_t references_missing = 0;     ///< intervals without WRC1 between two of less than a second
  std::optional<Duration> first_reference;  ///< since the first frame
  /// The master activated slaves when reference values were there already: its start-up goes on until then.
  std::optional<Duration> start_up_until;
  std::array<SlaveUse, kSlaves> slave = {};
  std::vector<ParameterUse> parameters;  ///< by slave, sub-slave, number, element
  std::uint64_t parameters_over = 0;     ///< commands for others
  std::vector<Step> steps;
  std::uint64_t steps_over = 0;  ///< further ones

  std::uint64_t writes_repeated = 0;  ///< unanswered and sent again next
  std::uint64_t writes_not_repeated =
      0;                            ///< unanswered, and something else was sent to the slave, or nothing
  std::uint64_t address_bytes = 0;  ///< blocks whose address counts bytes on from the block before
  std::uint64_t address_doublewords = 0;    ///< blocks whose address counts doublewords
  std::uint64_t low_addresses_taken = 0;    ///< transfers below 0x100 that the slave began
  std::uint64_t low_addresses_refused = 0;  ///< that the slave refused
  /// The first writes and transfer commands in operation: which slave in which interval.
  std::vector<ServedCommand> served;
};

/// Most entries of each list.
inline constexpr std::size_t kMostParameters = 16384;
inline constexpr std::size_t kMostSteps = 10000;
inline constexpr std::size_t kMostServed = 4096;
/// Bytes of all transfers together that are kept.
inline constexpr std::size_t kMostTransferBytes = std::size_t{4} << 20;

}  // namespace cansync::observe
