#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>

#include "cansync/settings/reference_limits.h"
#include "cansync/settings/timing.h"
#include "cansync/telegram/mapping.h"
#include "cansync/telegram/numbers.h"
#include "cansync/telegram/telegram.h"

/// Everything about the master that can be set. Plain values; the configuration file fills them.
namespace cansync {

/// How jobs on the command channel are served.
enum class Serving : std::uint8_t {
  scan,             ///< as the manuals: a cursor per job kind rises one slave per interval (M 3.2.2.6)
  work_conserving,  ///< straight to the next slave that has a job, round robin
};

/// A slave cursor: one fixed slave, nobody, or automatic (rises by one per interval up to the maximum
/// number).
struct Cursor {
  /// `nobody`: of a kind of job none is served, of a telegram no slave is asked.
  enum class Kind : std::uint8_t { automatic, fixed, nobody };
  Kind kind = Kind::automatic;
  SlaveNumber slave;  ///< with `fixed`
  friend constexpr bool operator==(const Cursor&, const Cursor&) = default;
};

/// When active operation may be enabled (M 3.2.2.3).
enum class EnableRule : std::uint8_t {
  all_synchronized,  ///< every configured slave responds and is synchronized
  all_responding,    ///< every configured slave responds
  any,               ///< at once
};

/// What a slave that was away has to pass, once it is synchronized again, before it is released.
enum class OnReturn : std::uint8_t {
  release,  ///< nothing
  check,    ///< every return parameter is read and must have its value
  write,    ///< every return parameter is written, and read back
};

/// One parameter with the value that a slave must have there.
struct ParameterValue {
  ParameterNumber number;
  std::uint32_t value = 0;  ///< raw, as on the bus; a word takes 0..0xFFFF
  friend constexpr bool operator==(const ParameterValue&, const ParameterValue&) = default;
};
inline constexpr unsigned kListedParameters = 32;  ///< most in one list of a slave

/// One slave of the line.
struct SlaveSettings {
  bool configured = false;
  std::uint16_t status_parameter = 301;  ///< parameter number of the status word (unconfirmed)
  /// Where the status word stands among the actual values (M 3.1.1.1): in active operation bit 15 is taken
  /// from each such telegram, and the parameter is read only when none has come for `status_period`. Nothing:
  /// the parameter alone.
  std::optional<ActualWord> status_value;
  std::uint16_t block_limit = 300;  ///< most bytes per initialise, 6..4092
  ProcessMapping actual_mapping = {default_mapping(Channel::one), default_mapping(Channel::two)};
  OnReturn on_return = OnReturn::release;
  std::uint8_t return_count = 0;  ///< how many of `return_parameters` count, 0..kListedParameters
  std::array<ParameterValue, kListedParameters> return_parameters = {};
  std::uint8_t expect_count = 0;  ///< how many of `expect` count, 0..kListedParameters; 0: any drive is right
  /// Who the slave is. Read when it answers for the first time, after each return and after each loss of SYNC;
  /// it is held out and not activated until all are right.
  std::array<ParameterValue, kListedParameters> expect = {};
};

/// What follows when two drives answer as one slave.
enum class OnDuplicate : std::uint8_t {
  hold,    ///< the slave is held out, and run is not entered
  report,  ///< an event, and no more
};

/// The parameters by which the master knows that a slave is the drive that is meant; lives with `slave`.
constexpr std::span<const ParameterValue> expected_of(const SlaveSettings& slave) noexcept {
  return std::span(slave.expect).first(slave.expect_count);
}
/// What a slave that was away has to pass; empty: nothing. Lives with `slave`.
constexpr std::span<const ParameterValue> checked_on_return(const SlaveSettings& slave) noexcept {
  if (slave.on_return == OnReturn::release) return {};
  return std::span(slave.return_parameters).first(slave.return_count);
}

/// The command channel.
struct CommandChannelSettings {
  Serving serving = Serving::work_conserving;
  /// Parameter jobs, and likewise transfers, get at least one in so many intervals while they wait, before
  /// control words that enable and broadcasts 1 and 2 (never before broadcast 0 and control words that stop);
  /// 0 = strict priority as in the manuals.
  std::uint32_t minimum_share = 8;
  Cursor control_word;  ///< of words that enable; those that stop wait for no cursor
  Cursor parameter;
  Cursor transfer;
  std::uint16_t parameter_queue = 256;  ///< open parameter jobs of all slaves together
  std::uint16_t transfer_queue = 32;    ///< open transfers of all slaves together
  std::uint16_t broadcast_queue = 8;    ///< waiting broadcasts per priority
  Duration parameter_monitoring = std::chrono::seconds(3);
  Duration transfer_monitoring = std::chrono::seconds(30);  ///< per block
  Duration command_monitoring = std::chrono::seconds(1);    ///< of control words and broadcasts
  bool repeat_unanswered_writes =
      false;  ///< false: a write without an answer ends as `no_answer`, never sent twice
  std::uint8_t telegram_repeats = 1;      ///< times a failed transfer telegram is sent again
  std::uint8_t block_retries = 1;         ///< times a failed block is begun again
  bool allow_reserved_addresses = false;  ///< start addresses 0x00..0xFF
  /// A slave's first command of a start, or since it was away, cancels what a master that has gone may have
  /// left open; no transfer begins before.
  bool cancel_at_start = true;
  std::uint8_t address_step = 1;  ///< bytes per start address: 1, or 4 if addresses count doublewords (open)
};

/// What becomes of active operation when another master sends.
enum class OnSecondMaster : std::uint8_t {
  report,  ///< it goes on, and the event says so
  stop,    ///< it ends: this master is silent until the other one is gone
};

/// Start-up and supervision of slaves.
struct StartupSettings {
  /// How long the bus must have been listened to before the first frame, also after it was away; 0: not at
  /// all, for a bus on which there can be no other master.
  Duration listen{0};
  OnSecondMaster on_second_master = OnSecondMaster::report;
  EnableRule enable = EnableRule::all_synchronized;
  std::uint8_t activate_command = 2;  ///< action "SYNC mode: activate" (unconfirmed)
  std::uint8_t activate_data = 1;     ///< its data byte (unconfirmed)
  Duration status_period =
      std::chrono::seconds(1);  ///< active operation: status word of each slave; 0 = never
  std::uint8_t lost_after = 3;  ///< unanswered telegrams in a row until a slave counts as lost
  /// A control word with all of these bits enables a drive (unconfirmed): it is refused for a slave that is
  /// lost or held out (`SlaveState`), and waits for the cursor. Every other one stops. 0: none enables.
  std::uint16_t enabling_control_bits = 0x000F;
  /// Each number that is not configured is asked once for its status word in set-up; who answers is reported.
  bool census = true;
  OnDuplicate on_duplicate = OnDuplicate::hold;
};

/// True for a control word that enables a drive; every other one stops it.
constexpr bool enables(const StartupSettings& settings, std::uint16_t control_word) noexcept {
  const std::uint16_t bits = settings.enabling_control_bits;
  return bits != 0 && (control_word & bits) == bits;
}

/// Reference and actual values.
struct ProcessSettings {
  ProcessMapping reference_mapping = {default_mapping(Channel::one), default_mapping(Channel::two)};
  std::array<Cursor, kChannels> polling = {};
  /// The automatic number of the second telegram is half a round ahead of the first one's, so that every
  /// slave has sent one telegram in half a round; false, as in the manuals: both count in step.
  bool polling_apart = false;
  SlaveNumber maximum_slave;               ///< automatic cursors rise to this number
  std::uint8_t poll_nobody = kPollNobody;  ///< N of a reference telegram that asks no slave, 32..127
  bool full_length = true;  ///< WRC telegrams always have 8 bytes; false: as many as are mapped
  /// True: when no reference values are released, a telegram with no data bytes still asks the slave for its
  /// actual values. False, as in the manuals: no telegram, no actual values.
  bool poll_without_reference = false;
  std::uint32_t release_limit = 1000;  ///< most release_intervals of one update
  std::uint32_t ahead_limit = 1000;    ///< most intervals an update may lie ahead
  /// Values without newer ones are too old after so many intervals, from the one in which they were taken
  /// into use on, and no longer released; 0 = never.
  std::uint32_t too_old_after = 0;
  /// Values that grew too old while they were released are held for so many intervals more; 0 = not at all.
  std::uint32_t hold_too_old = 0;
  AllReferenceLimits reference_limits = {};  ///< what reference values may be; default: anything
};

/// The send margin that takes up as much lateness of the sender as the slots of a bit rate allow: 50 bit
/// times. More (100 were tried) lets CC go before a second actual value telegram that waits for the bus,
/// which then starts after its slot.
constexpr Duration default_send_margin(BitRate rate) noexcept {
  return 50 * slot_times(rate).bit_time();
}

/// The whole master.
struct MasterSettings {
  BitRate bit_rate = BitRate::mbit1;
  /// How long before its latest start a telegram is sent; `default_send_margin` tells what fits a bit rate.
  Duration send_margin = default_send_margin(BitRate::mbit1);
  std::array<SlaveSettings, kSlaves> slaves = {};
  ProcessSettings process;
  CommandChannelSettings command_channel;
  StartupSettings startup;

  /// Mask of the configured slaves.
  SlaveMask configured() const noexcept;
};

}  // namespace cansync
