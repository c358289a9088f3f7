#include <cansync/function_blocks/updownload_sl.h>

#include <algorithm>
#include <utility>

#include "client/src/cansync_slave/slave_side.h"

namespace cansync::client::function_blocks {
namespace {

constexpr std::size_t kBytes = 4;        // of a doubleword
constexpr std::size_t kAreaBytes = 300;  // M 3.2.3.7: a block of the area
constexpr std::uint16_t kNotPossible = 0x0104;
constexpr std::uint16_t kTooLong = 0x0107;

constexpr std::size_t doublewords(std::size_t bytes) noexcept {
  return (bytes + kBytes - 1) / kBytes;
}

}  // namespace

UPDOWNLOAD_SL::UPDOWNLOAD_SL(SlaveConnection& connection) : connection_(&connection) {
  connection.side().attach_blocks();
}

UPDOWNLOAD_SL::~UPDOWNLOAD_SL() {
  connection_->side().detach_blocks();
}

void UPDOWNLOAD_SL::call(Clock::time_point now) {
  detail::SlaveSide& side = connection_->side();
  x_STANDBY = false;
  if (x_RESET) {
    side.serve_blocks(false);
    return clear();
  }
  if (!x_EN || phase_ == Phase::locked) {
    side.serve_blocks(false);
    side.look();
    if (x_BUSY) lock();  // M 4.25: cancelled deliberately
    return;
  }
  side.serve_blocks(true);
  side.look();
  x_STANDBY = side.is_standby();
  if (!side.problem().empty()) error_ = side.problem();
  if (x_BUSY && (!side.daemon_present() || daemon_ != side.daemon()))
    return cancelled("client: the daemon has gone");
  while (!side.block_steps().empty() && phase_ != Phase::locked) {
    const detail::BlockStep step = std::move(side.block_steps().front());
    side.block_steps().pop_front();
    if (gateway::dds::daemon_of(step.job) == side.daemon()) take(step, now);
  }
  if (x_BUSY && now >= deadline_) return fail(updownload_sl_error::timeout, "client: not done within t_TIME");
  if (phase_ == Phase::pausing && now >= pause_end_) finish();
}

void UPDOWNLOAD_SL::take(const detail::BlockStep& step, Clock::time_point now) {
  if (step.job.step == cansync_slave_BLOCK_BEGUN) return begin(step, now);
  if (phase_ != Phase::moving || step.job.job != job_) return;
  if (step.job.step == cansync_slave_BLOCK_ENDED) return ended(step, now);
  if (step.job.step != cansync_slave_BLOCK_COMPLETE) return;
  for (std::size_t i = 0; i < doublewords(step.data.size()); ++i) {
    std::uint32_t value = 0;
    for (std::size_t byte = 0; byte < kBytes && i * kBytes + byte < step.data.size(); ++byte)
      value |= std::uint32_t{step.data[i * kBytes + byte]} << (8 * byte);
    if (place_ + i < a_DOWNLOAD.size()) a_DOWNLOAD[place_ + i] = static_cast<DINT>(value);
  }
  if (auto* const application = connection_->side().application()) error_ = application->take(step.job);
}

void UPDOWNLOAD_SL::begin(const detail::BlockStep& step, Clock::time_point now) {
  auto* const application = connection_->side().application();
  if (application == nullptr) return;
  const bool follows = phase_ == Phase::pausing && step.job.download == x_UPDOWN;
  if (!follows) {
    clear();
    place_ = 0;
    deadline_ = now + t_TIME;
  }
  const std::size_t room = (a_DOWNLOAD.size() - place_) * kBytes;
  const std::size_t bytes = step.job.length == 0 ? std::min(room, kAreaBytes) : step.job.length;
  if (!step.job.whole || bytes > room) {
    error_ = application->refuse(step.job, step.job.whole ? kTooLong : kNotPossible);
    if (error_.empty())
      error_ = step.job.whole ? "client: a block beyond [2047] was refused"
                              : "client: a block that moves telegram by telegram was refused";
    return;
  }
  phase_ = Phase::moving;
  job_ = step.job.job;
  daemon_ = gateway::dds::daemon_of(step.job);
  bytes_ = bytes;
  x_UPDOWN = step.job.download;
  x_ORDER_ACTIV = x_BUSY = true;
  u_LENGTH = static_cast<UINT>(doublewords(bytes));
  std::vector<std::uint8_t> data;
  for (std::size_t i = 0; !x_UPDOWN && i < bytes; ++i)
    data.push_back(static_cast<std::uint8_t>(static_cast<std::uint32_t>(a_UPLOAD[place_ + i / kBytes]) >>
                                             (8 * (i % kBytes))));
  error_ = application->allow(step.job, data);
}

void UPDOWNLOAD_SL::ended(const detail::BlockStep& step, Clock::time_point now) {
  switch (step.job.result) {
    case cansync_slave_BLOCK_DONE:
      break;
    case cansync_slave_BLOCK_TIMED_OUT:
      return fail(updownload_sl_error::timeout, "daemon: nothing of the block moved for slave.block_time_ms");
    case cansync_slave_BLOCK_CANCELLED:
      return cancelled("daemon: the master cancelled the block, or began another one");
    case cansync_slave_BLOCK_REFUSED:
    case cansync_slave_BLOCK_APPLICATION_GONE:
      return cancelled("daemon: the block was given up");
  }
  place_ += doublewords(bytes_);
  u_TRANSFERRED = static_cast<UINT>(place_);
  if (bytes_ < kAreaBytes || place_ >= a_DOWNLOAD.size()) return finish();
  phase_ = Phase::pausing;
  pause_end_ = now + t_NEXT;
}

void UPDOWNLOAD_SL::finish() {
  phase_ = Phase::idle;
  x_ORDER_ACTIV = x_BUSY = false;
  x_OK = true;
}

/// The job is over and none was done; the next one may come.
void UPDOWNLOAD_SL::cancelled(std::string reason) {
  phase_ = Phase::idle;
  x_ORDER_ACTIV = x_BUSY = x_OK = false;
  error_ = std::move(reason);
}

void UPDOWNLOAD_SL::fail(WORD bits, std::string reason) {
  lock();
  connection_->side().serve_blocks(false);
  x_ERR = true;
  w_ERR = bits;
  error_ = std::move(reason);
}

/// Nothing more until x_RESET.
void UPDOWNLOAD_SL::lock() {
  phase_ = Phase::locked;
  x_ORDER_ACTIV = x_BUSY = x_OK = false;
}

void UPDOWNLOAD_SL::clear() {
  phase_ = Phase::idle;
  x_ORDER_ACTIV = x_BUSY = x_OK = x_ERR = false;
  w_ERR = 0;
  u_LENGTH = u_TRANSFERRED = 0;
  error_.clear();
}

}  // namespace cansync::client::function_blocks
