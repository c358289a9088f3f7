#include "cansync/channel/outcome_rules.h"

namespace cansync {

Outcome outcome_of(JobKnown known, JobEnd end) noexcept {
  switch (can::ending_of(known, end)) {
    case can::JobEnding::no_answer:
      return Outcome::no_answer;
    case can::JobEnding::timeout:
      return Outcome::timeout;
    case can::JobEnding::cancelled:
      return Outcome::cancelled;
    case can::JobEnding::stopped:
      return Outcome::master_stopped;
    case can::JobEnding::lost:
      return Outcome::slave_lost;
    case can::JobEnding::taken:
      break;
  }
  return Outcome::taken;
}

bool perhaps_written(const ParameterResult& result) noexcept {
  switch (result.outcome) {
    case Outcome::done:
    case Outcome::taken:
    case Outcome::no_answer:
      return true;
    case Outcome::timeout:
      return result.busy_replies != 0;  // else the time was over before the write was sent
    case Outcome::slave_error:
      return result.error == ParameterError::unspecified;  // so a gateway says that it does not know
    default:
      return false;
  }
}

}  // namespace cansync
