#include "cansync/cluster/gateway_answers.h"

#include "cansync/channel/outcome_rules.h"

namespace cansync {

namespace {
using BlockAnswer = SlaveApplication::BlockAnswer;
}  // namespace

ParameterAnswer answer_above(bool write, const ParameterResult& result) noexcept {
  switch (result.outcome) {
    case Outcome::done: {
      ParameterAnswer answer;
      answer.doubleword = result.doubleword;
      answer.value = result.value;
      return answer;
    }
    case Outcome::slave_error:
      return ParameterAnswer::refused(result.error == ParameterError::none ? ParameterError::unspecified
                                                                           : result.error);
    case Outcome::word_expected:
    case Outcome::doubleword_expected:
    case Outcome::value_too_wide:
      return ParameterAnswer::refused(ParameterError::wrong_format);
    case Outcome::slave_lost:
      return ParameterAnswer::refused(ParameterError::not_available_now);
    default:
      return ParameterAnswer::refused(write && perhaps_written(result) ? ParameterError::unspecified
                                                                       : ParameterError::not_available_now);
  }
}

ParameterAnswer answer_above_parameter(Refusal refused) noexcept {
  switch (refused) {
    case Refusal::queue_full:
      return ParameterAnswer::later();
    case Refusal::slave_not_configured:
      return ParameterAnswer::refused(ParameterError::not_present);
    case Refusal::element_not_writable:
      return ParameterAnswer::refused(ParameterError::not_changeable);
    case Refusal::value_too_wide:
      return ParameterAnswer::refused(ParameterError::wrong_format);
    default:
      return ParameterAnswer::refused(ParameterError::not_available_now);
  }
}

BlockAnswer answer_above(const TransferResult& result) noexcept {
  if (result.outcome == Outcome::done) return {};
  const bool code = result.outcome == Outcome::slave_error && result.error != TransferError::none;
  return BlockAnswer::refused(code ? result.error : TransferError::cancelled_by_slave);
}

BlockAnswer answer_above_transfer(Refusal refused) noexcept {
  switch (refused) {
    case Refusal::queue_full:
      return BlockAnswer::later();
    case Refusal::address_reserved:
    case Refusal::address_overflow:
      return BlockAnswer::refused(TransferError::address_not_allowed);
    case Refusal::block_size:
      return BlockAnswer::refused(TransferError::block_too_long);
    // The table is right: what it names is away, or its bus is.
    case Refusal::slave_lost:
    case Refusal::wrong_state:
    case Refusal::bus_unavailable:
      return BlockAnswer::refused(TransferError::cancelled_by_slave);
    default:
      return BlockAnswer::refused(TransferError::not_possible);
  }
}

}  // namespace cansync
