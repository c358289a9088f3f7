#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "cansync/telegram/errors.h"
#include "cansync/telegram/mapping.h"
#include "cansync/telegram/numbers.h"
#include "cansync/telegram/telegram.h"

/// What can be asked of the master, and how each request ends. Plain values; safe on the realtime thread.
namespace cansync {

/// Names one request for its whole life; chosen by the caller, never interpreted here.
using JobId = std::uint64_t;

/// Format of a parameter value on the bus.
enum class ParameterFormat : std::uint8_t {
  word,           ///< 16 bits
  doubleword,     ///< 32 bits
  as_slave_says,  ///< read: take what comes; write: read first, then write in the format the slave answered
};

/// Reads or writes one parameter of one slave.
struct ParameterRequest {
  JobId id = 0;
  bool write = false;
  SlaveNumber slave;
  SubSlave sub_slave;
  ParameterNumber number;
  Element element = kValueElement;  ///< a write allows 7 alone
  ParameterFormat format = ParameterFormat::as_slave_says;
  std::uint32_t value = 0;      ///< write: raw value; a word takes 0..0xFFFF
  Duration monitoring_time{0};  ///< 0: the setting's default (3 s)
};

/// Uploads (slave to master) or downloads (master to slave) `data`, in as many blocks as it takes.
struct TransferRequest {
  using Direction = TransferInitialise::Direction;
  JobId id = 0;
  Direction direction = Direction::upload;
  SlaveNumber slave;
  SubSlave sub_slave;
  std::uint32_t address = 0;     ///< start address; 0x00..0xFF refused unless the settings allow them
  std::uint16_t block_size = 0;  ///< bytes per initialise, 1..4092; 0: the slave's limit (default 300)
  Duration monitoring_time{0};   ///< per block; 0: the setting's default (30 s)
  /// Download: what to send. Upload: where to put it, its size is the length asked for. Stays valid until the
  /// job's terminal result; only the master touches it meanwhile.
  std::span<std::uint8_t> data;
};

/// Control word to one slave. One waits for each slave; a newer one replaces it (M 3.2.2.6).
struct ControlWordRequest {
  JobId id = 0;
  SlaveNumber slave;
  std::uint16_t control_word = 0;  ///< the slave's own bits; enabling ones: `enabling_control_bits`
  Duration monitoring_time{0};  ///< in which it is sent or ends as `timeout`; 0: the setting's default (1 s)
  /// The failsafe reaction's: waits for no cursor whatever its bits are and without a time limit, and no
  /// other word replaces it.
  bool failsafe = false;
};

/// Action command to a group of slaves.
struct BroadcastRequest {
  JobId id = 0;
  std::uint8_t priority = 2;    ///< 0 (before everything else), 1 or 2
  ActionCommand action;         ///< command 1 or 128..255
  Duration monitoring_time{0};  ///< as of a control word
};

/// Gives new reference values of one telegram.
struct ReferenceUpdate {
  Channel channel = Channel::one;
  std::array<std::uint32_t, 4> value = {};  ///< values 0..3 (channel one) or 4..7 (channel two)
  std::uint8_t valid_mask = 0;              ///< bit n: value[n] is new; the others keep their last value
  IntervalNumber from_interval = 0;         ///< first interval to release in; 0 = the next
  std::uint32_t release_intervals =
      1;  ///< intervals in a row in which the telegram is released; 1 = exactly once
  bool takes_over =
      false;  ///< from another giver: what the one before gave for later is forgotten, also when this is refused
  std::uint64_t mapping_number =
      1;  ///< of the reference mapping the values were made for; 1: that of the settings
  /// First interval in which the values are too old for their release to begin; 0: they never are.
  IntervalNumber too_old_from = 0;

  /// First interval in which the release may no longer begin, 0: none. Values for a later interval may wait
  /// for it, however old they are then, but not longer.
  constexpr IntervalNumber begins_before() const noexcept {
    return too_old_from == 0 ? 0 : std::max(too_old_from, from_interval + 1);
  }
};

/// How a job ended.
enum class Outcome : std::uint8_t {
  done,         ///< a control word or broadcast: its frame was seen on the bus
  slave_error,  ///< the slave answered with an error code
  timeout,      ///< no (final) answer within the monitoring time; a control word or broadcast: not sent
  /// A write was not answered, or a control word or broadcast was handed over and not seen on the bus within
  /// its interval; whether the slave took it is not known.
  no_answer,
  word_expected,        ///< the slave's parameter is a word, doubleword was asked
  doubleword_expected,  ///< the slave's parameter is a doubleword, word was asked
  value_too_wide,       ///< write "as the slave says": the slave's word cannot hold the value
  cancelled,            ///< of a write: nothing of it was sent (else `no_answer` or `taken`)
  master_stopped,       ///< the master left the operating state while the job was open; of a write likewise
  slave_lost,           ///< the slave stopped answering; nothing of a write was sent (else `no_answer`)
  slave_held,           ///< a control word that was not sent: meanwhile the slave was held out
  replaced,  ///< a control word or broadcast that was not sent: a newer word, or a stop, took its place
  taken,     ///< a write that the slave has, for it was busy with it; how it ended is not known
};

/// Why a request is not taken at all; nothing was sent.
enum class Refusal : std::uint8_t {
  none,
  slave_not_configured,
  element_not_writable,  ///< only element 7 may be written
  value_too_wide,        ///< a word holds 0..0xFFFF; a reference value sent as a word -32768..65535
  length_zero,
  block_size,        ///< 1..4092 and not over the slave's limit
  address_reserved,  ///< 0x00..0xFF
  address_overflow,  ///< start address + length is over 32 bits
  command_reserved,  ///< action command 0 and 2..127
  priority,          ///< broadcast priority 0..2
  no_slaves,         ///< empty group mask
  queue_full,
  wrong_state,       ///< the master is not in set-up or active operation
  interval_passed,   ///< reference values for an interval that is over or too far ahead
  release_too_long,  ///< release_intervals 1..limit
  nothing_valid,     ///< valid_mask is 0 or over 15
  slaves_missing,    ///< active operation needs slaves that have not reported
  unknown_job,       ///< cancel of a job that is not open
  mapping,           ///< a word names a value of the other telegram
  not_permitted,     ///< the controller cannot be reset without a right the program has not got
  bus_unavailable,   ///< the interface is missing or down, or its driver does not do it
  slave_lost,        ///< the slave does not answer
  slave_held,        ///< the control word would enable a slave that is held out
  not_held,          ///< release of a slave that is not held out
  too_old,           ///< reference values whose `ReferenceUpdate::too_old_from` has come
  mapping_changed,   ///< reference values for another mapping than the one in force
  lead_axis,         ///< reference values of a telegram that the lead axis of a cluster gives
  listening,         ///< synchronous operation before the bus was listened to long enough
  other_master,      ///< synchronous operation while another master sends
  beyond_limit,      ///< a reference value is beyond one of its limits
};

/// A short English word group for logs and messages, never empty; the text lives as long as the program.
std::string_view name(Outcome outcome) noexcept;
std::string_view name(Refusal refusal) noexcept;

/// Terminal result of a parameter job.
struct ParameterResult {
  Outcome outcome = Outcome::done;
  ParameterError error = ParameterError::none;  ///< set with Outcome::slave_error
  std::uint32_t value = 0;                      ///< read: the value; write: what was written
  bool doubleword = false;                      ///< format on the bus
  std::uint32_t intervals = 0;                  ///< intervals from the first telegram to the answer
  std::uint32_t busy_replies = 0;               ///< times the slave said that it needs longer
};

/// Terminal result of a transfer job.
struct TransferResult {
  Outcome outcome = Outcome::done;
  TransferError error = TransferError::none;  ///< set with Outcome::slave_error
  std::uint32_t bytes = 0;                    ///< bytes transferred and confirmed
  std::uint32_t error_offset = 0;             ///< byte offset in the data where it failed
  std::uint32_t intervals = 0;                ///< intervals from the first telegram to the last answer
  std::uint32_t repeated_telegrams = 0;       ///< sent again after silence or a refusal
  std::uint32_t repeated_blocks = 0;          ///< begun anew after a failure
};

}  // namespace cansync
