#include "cansync/channel/jobs.h"
#include "cansync/channel/transfer_phase.h"
#include "cansync/master.h"
#include "cansync/settings/mode.h"
#include "cansync/supervision/slave_state.h"
#include "cansync/supervision/strays.h"
#include "cansync/telegram/errors.h"
#include "cansync/telegram/telegram.h"

// No `default` in these switches: the compiler then warns when an enumerator has no name.
namespace cansync {

std::string_view name(DecodeError error) noexcept {
  switch (error) {
    case DecodeError::not_for_us:
      return "not for us";
    case DecodeError::extended:
      return "extended frame";
    case DecodeError::remote:
      return "remote frame";
    case DecodeError::error_frame:
      return "error frame";
    case DecodeError::wrong_slave:
      return "wrong slave number";
    case DecodeError::wrong_length:
      return "wrong length";
    case DecodeError::reserved_bits:
      return "reserved bits used";
  }
  return "unknown decode error";
}

std::string_view name(Unexpected kind) noexcept {
  switch (kind) {
    case Unexpected::wrong_slave:
      return "other slave than asked";
    case Unexpected::wrong_answer:
      return "other answer than asked for";
    case Unexpected::late:
      return "late";
    case Unexpected::duplicate:
      return "duplicate";
    case Unexpected::unasked:
      return "nobody asked";
  }
  return "unknown kind";
}

std::string_view meaning(ParameterError error) noexcept {
  switch (error) {
    case ParameterError::none:
      return "no error";
    case ParameterError::unspecified:
      return "unspecified error";
    case ParameterError::below_minimum:
      return "value below the minimum";
    case ParameterError::above_maximum:
      return "value above the maximum";
    case ParameterError::not_changeable:
      return "element cannot be changed";
    case ParameterError::not_present:
      return "no such parameter or element";
    case ParameterError::not_available_now:
      return "data not available now";
    case ParameterError::wrong_format:
      return "wrong data format";
  }
  return "unknown error code";
}

std::string_view meaning(TransferError error) noexcept {
  switch (error) {
    case TransferError::none:
      return "no error";
    case TransferError::wrong_block_acknowledged:
      return "slave acknowledged a wrong block number";
    case TransferError::longer_than_300_bytes:
      return "length over 300 bytes";
    case TransferError::other_block_expected:
      return "slave expects the block its counter names";
    case TransferError::end_expected:
      return "slave expects the end of the block";
    case TransferError::end_not_expected:
      return "slave does not yet expect the end of the block";
    case TransferError::cancelled_by_slave:
      return "slave cancelled the transfer";
    case TransferError::not_possible:
      return "transfer not possible";
    case TransferError::address_not_allowed:
      return "start address not allowed";
    case TransferError::block_too_long:
      return "block longer than the slave's maximum";
    case TransferError::mode_not_allowed:
      return "telegram not allowed in this phase of the transfer";
  }
  return "unknown error code";
}

std::string_view name(Outcome outcome) noexcept {
  switch (outcome) {
    case Outcome::done:
      return "done";
    case Outcome::slave_error:
      return "slave error";
    case Outcome::timeout:
      return "timeout";
    case Outcome::no_answer:
      return "no answer";
    case Outcome::word_expected:
      return "word expected";
    case Outcome::doubleword_expected:
      return "doubleword expected";
    case Outcome::value_too_wide:
      return "value too wide";
    case Outcome::cancelled:
      return "cancelled";
    case Outcome::master_stopped:
      return "master stopped";
    case Outcome::slave_lost:
      return "slave lost";
    case Outcome::slave_held:
      return "slave held out";
    case Outcome::replaced:
      return "replaced";
    case Outcome::taken:
      return "taken by the slave, no final answer";
  }
  return "unknown outcome";
}

namespace {

/// Of the refusals that reference values alone meet.
std::string_view name_of_values_refusal(Refusal refusal) noexcept {
  switch (refusal) {
    case Refusal::interval_passed:
      return "interval passed or too far ahead";
    case Refusal::release_too_long:
      return "release too long";
    case Refusal::nothing_valid:
      return "valid mask out of range";
    case Refusal::too_old:
      return "too old";
    case Refusal::mapping_changed:
      return "made for another mapping";
    case Refusal::lead_axis:
      return "given by the lead axis";
    default:
      return "unknown refusal";
  }
}

}  // namespace

std::string_view name(Refusal refusal) noexcept {
  switch (refusal) {
    case Refusal::none:
      return "not refused";
    case Refusal::slave_not_configured:
      return "slave not configured";
    case Refusal::element_not_writable:
      return "element not writable";
    case Refusal::value_too_wide:
      return "value too wide";
    case Refusal::length_zero:
      return "length zero";
    case Refusal::block_size:
      return "block size out of range";
    case Refusal::address_reserved:
      return "address reserved";
    case Refusal::address_overflow:
      return "address overflow";
    case Refusal::command_reserved:
      return "action command reserved";
    case Refusal::priority:
      return "priority out of range";
    case Refusal::no_slaves:
      return "slave mask empty or names a slave that is not configured";
    case Refusal::queue_full:
      return "queue full";
    case Refusal::wrong_state:
      return "wrong state";
    case Refusal::slaves_missing:
      return "slaves missing";
    case Refusal::unknown_job:
      return "unknown job";
    case Refusal::mapping:
      return "mapping names a value of the other telegram";
    case Refusal::not_permitted:
      return "not permitted";
    case Refusal::bus_unavailable:
      return "bus unavailable";
    case Refusal::slave_lost:
      return "slave lost";
    case Refusal::slave_held:
      return "slave held out";
    case Refusal::not_held:
      return "not held out";
    case Refusal::listening:
      return "the master still listens";
    case Refusal::other_master:
      return "another master sends";
    case Refusal::beyond_limit:
      return "beyond a limit";
    default:
      return name_of_values_refusal(refusal);
  }
}

std::string_view name(State state) noexcept {
  switch (state) {
    case State::start_up:
      return "start-up";
    case State::waiting_for_initialisation:
      return "waiting for initialisation data";
    case State::waiting_for_start:
      return "stop";
    case State::setting_up_master:
    case State::setting_up_slave:
      return "setup";
    case State::active_master:
    case State::active_slave:
      return "run";
  }
  return "unknown state";
}

std::string_view name(ControlCommand command) noexcept {
  switch (command) {
    case ControlCommand::cold_restart:
      return "restart";
    case ControlCommand::handshake:
      return "handshake";
    case ControlCommand::take_over_initialisation:
      return "take over initialisation data";
    case ControlCommand::start_synchronous:
      return "setup";
    case ControlCommand::enable_active:
      return "run";
    case ControlCommand::reset_can:
      return "reset-can";
  }
  return "unknown command";
}

std::string_view name(SlaveState state) noexcept {
  switch (state) {
    case SlaveState::absent:
      return "absent";
    case SlaveState::starting:
      return "starting";
    case SlaveState::released:
      return "released";
    case SlaveState::lost:
      return "lost";
    case SlaveState::returning:
      return "returning";
    case SlaveState::checking:
      return "checking";
    case SlaveState::held:
      return "held";
  }
  return "unknown";
}

std::string_view name(SlaveEvent event) noexcept {
  switch (event) {
    case SlaveEvent::begun:
      return "begun";
    case SlaveEvent::answered:
      return "answered";
    case SlaveEvent::gone:
      return "gone";
    case SlaveEvent::synchronized:
      return "synchronized";
    case SlaveEvent::not_synchronized:
      return "not synchronized";
    case SlaveEvent::check_begun:
      return "check begun";
    case SlaveEvent::check_passed:
      return "check passed";
    case SlaveEvent::check_failed:
      return "check failed";
    case SlaveEvent::asked_who:
      return "asked who";
    case SlaveEvent::wrong_drive:
      return "wrong drive";
    case SlaveEvent::duplicated:
      return "duplicated";
  }
  return "unknown event";
}

std::string_view name(TransferPhase phase) noexcept {
  switch (phase) {
    case TransferPhase::initialise:
      return "initialise";
    case TransferPhase::body:
      return "body";
    case TransferPhase::cancel:
      return "cancel";
    case TransferPhase::ended:
      return "ended";
  }
  return "unknown phase";
}

std::string_view name(TransferEvent event) noexcept {
  switch (event) {
    case TransferEvent::accepted:
      return "accepted";
    case TransferEvent::bytes_taken:
      return "bytes taken";
    case TransferEvent::block_done:
      return "block done";
    case TransferEvent::given_up:
      return "given up";
    case TransferEvent::begun_again:
      return "begun again";
    case TransferEvent::ended:
      return "ended";
  }
  return "unknown event";
}

std::string_view name(MasterEvent::Code code) noexcept {
  switch (code) {
    case MasterEvent::Code::slave_responds:
      return "slave_responds";
    case MasterEvent::Code::slave_returned:
      return "slave_returned";
    case MasterEvent::Code::slave_checked:
      return "slave_checked";
    case MasterEvent::Code::slave_check_failed:
      return "slave_check_failed";
    case MasterEvent::Code::slave_identified:
      return "slave_identified";
    case MasterEvent::Code::wrong_drive:
      return "wrong_drive";
    case MasterEvent::Code::duplicate_slave:
      return "duplicate_slave";
    case MasterEvent::Code::unknown_slave:
      return "unknown_slave";
    case MasterEvent::Code::slave_released:
      return "slave_released";
    case MasterEvent::Code::slave_status_refused:
      return "slave_status_refused";
    case MasterEvent::Code::slave_lost:
      return "slave_lost";
    case MasterEvent::Code::slave_synchronized:
      return "slave_synchronized";
    case MasterEvent::Code::slave_not_synchronized:
      return "slave_not_synchronized";
    case MasterEvent::Code::all_synchronized:
      return "all_synchronized";
    case MasterEvent::Code::references_stopped:
      return "references_stopped";
    case MasterEvent::Code::references_released:
      return "references_released";
    case MasterEvent::Code::references_too_old:
      return "references_too_old";
    case MasterEvent::Code::references_held:
      return "references_held";
    case MasterEvent::Code::second_master:
      return "second_master";
    case MasterEvent::Code::second_master_gone:
      return "second_master_gone";
  }
  return "unknown_event";
}

}  // namespace cansync
