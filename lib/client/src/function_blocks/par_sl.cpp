#include <cansync/function_blocks/par_sl.h>

#include <algorithm>
#include <utility>

#include "client/src/cansync_slave/slave_side.h"

namespace cansync::client::function_blocks {
namespace {

// Error numbers of the manual (M 3.2.3.7).
constexpr std::uint16_t kUnspecified = 0xFFFF;
constexpr std::uint16_t kNotAvailable = 0xFFFA;
constexpr std::uint16_t kWrongFormat = 0xFFF9;

constexpr std::uint8_t kValueElement = 7;
constexpr UINT kParameterNumbers = 4096;

/// An answer names the job and the daemon that gave it.
cansync_slave_ParameterJob job_named(std::uint64_t number, const std::array<std::uint8_t, 16>& daemon) {
  cansync_slave_ParameterJob job = {};
  job.job = number;
  gateway::dds::set_daemon(daemon, job);
  return job;
}

/// True for a job that nobody waits for any more: its end has come, too, or its daemon has gone. What it asks
/// for must not be done; the master may have asked for the same again.
bool is_over(detail::SlaveSide& side, const cansync_slave_ParameterJob& asked) {
  if (gateway::dds::daemon_of(asked) != side.daemon()) return true;
  const auto& later = side.parameter_steps();
  return std::any_of(later.begin(), later.end(), [&](const cansync_slave_ParameterJob& step) {
    return step.job == asked.job && step.step != cansync_slave_JOB_ASKED;
  });
}

}  // namespace

PAR_SL::PAR_SL(SlaveConnection& connection, std::vector<UINT> numbers)
    : connection_(&connection), numbers_(std::move(numbers)), all_(numbers_.empty()) {
  connection.side().attach_parameters();
}

PAR_SL::~PAR_SL() {
  connection_->side().detach_parameters();
}

void PAR_SL::call() {
  detail::SlaveSide& side = connection_->side();
  if (x_RESET || !x_EN) side.serve_parameters({});
  x_STANDBY = false;
  if (x_RESET) {
    clear();
    return;
  }
  if (!x_EN) {
    const bool busy = x_BUSY;
    if (busy) clear();
    if (busy) phase_ = Phase::locked;  // M 4.13: cancelled deliberately
    side.look();
    return;
  }
  if (phase_ == Phase::locked) return;
  side.serve_parameters(numbers());
  side.look();
  error_ = side.problem();
  x_STANDBY = side.is_standby();
  const bool shown = phase_ == Phase::asked;
  if (phase_ != Phase::idle && (!side.daemon_present() || daemon_ != side.daemon())) return end(false);
  next_step();
  if (shown && phase_ == Phase::asked && (x_OK_IN || x_ERR_IN)) answer();
}

/// All but the status word, which is the daemon's, or those that were given.
const std::vector<UINT>& PAR_SL::numbers() {
  const UINT status_word = connection_->side().status().status_parameter;
  if (!all_ || (!numbers_.empty() && without_ == status_word)) return numbers_;
  without_ = status_word;
  numbers_.clear();
  for (UINT number = 0; number < kParameterNumbers; ++number) {
    if (number != without_) numbers_.push_back(number);
  }
  return numbers_;
}

/// One step that concerns the block; the rest waits for the next call.
void PAR_SL::next_step() {
  detail::SlaveSide& side = connection_->side();
  while (!side.parameter_steps().empty()) {
    const cansync_slave_ParameterJob step = side.parameter_steps().front();
    const bool own = phase_ != Phase::idle && step.job == job_;
    if (step.step != cansync_slave_JOB_ASKED) {
      side.parameter_steps().pop_front();
      if (!own) continue;
      return end(step.step == cansync_slave_JOB_ANSWERED);
    }
    if (phase_ != Phase::idle) return end(false);  // its end was lost on the way; the new job waits
    side.parameter_steps().pop_front();
    if (is_over(side, step)) continue;
    if (step.element != kValueElement) {
      if (auto* const application = side.application()) error_ = application->refuse(step, kNotAvailable);
      continue;
    }
    phase_ = Phase::asked;
    job_ = step.job;
    daemon_ = gateway::dds::daemon_of(step);
    x_RESET_JOB = x_OK = false;
    x_READ = !step.write;
    x_WRITE = step.write;
    u_PAR_NR = step.parameter;
    if (step.write) {
      x_PAR_FORMAT_WRITE = step.doubleword;
      ud_PAR_VALUE_WRITE = step.value;
    }
    x_ACTIV = x_BUSY = true;
    return;
  }
}

void PAR_SL::answer() {
  auto* const application = connection_->side().application();
  if (application == nullptr) return;
  const cansync_slave_ParameterJob job = job_named(job_, daemon_);
  std::string wrong;
  if (x_ERR_IN) {
    error_ = application->refuse(job, i_ERR == 0 ? kUnspecified : static_cast<std::uint16_t>(i_ERR));
  } else if (x_READ && !x_PAR_FORMAT_READ && !::cansync_slave::client::fits_word(ud_PAR_VALUE_READ)) {
    wrong = "client: ud_PAR_VALUE_READ " + std::to_string(ud_PAR_VALUE_READ) +
            ": wider than a word; the master is told \"wrong format\"; set x_PAR_FORMAT_READ";
    error_ = application->refuse(job, kWrongFormat);
  } else {
    const UDINT value = x_PAR_FORMAT_READ ? ud_PAR_VALUE_READ : ud_PAR_VALUE_READ & 0xFFFF;
    error_ = application->answer(job, x_READ ? value : 0, x_READ && x_PAR_FORMAT_READ);
  }
  if (!error_.empty()) return;  // the next call tries again
  error_ = std::move(wrong);
  phase_ = Phase::answered;
  x_ACTIV = false;
}

void PAR_SL::end(bool fetched) {
  phase_ = Phase::idle;
  x_READ = x_WRITE = x_ACTIV = x_BUSY = false;
  x_OK = fetched;
  x_RESET_JOB = !fetched;
}

void PAR_SL::clear() {
  phase_ = Phase::idle;
  x_READ = x_WRITE = x_ACTIV = x_BUSY = x_OK = x_RESET_JOB = false;
  error_.clear();
}

}  // namespace cansync::client::function_blocks
