#include "recovery.h"

#include <algorithm>
#include <bit>

#include "cansync/supervision/supervision.h"

namespace cansyncd::campaign {
namespace {

/// Resetting the controller takes 1408 bit times, at most 1.5 intervals; the operator sees it one interval
/// later, looks at the mode every fourth, and gives each its time; late frames may still come meanwhile.
constexpr std::uint64_t kOperator = 20 + kLatestIntervals;
constexpr std::uint64_t kBytesPerTelegram = 6;

std::uint64_t in_intervals(cansync::Duration time, const Plan& plan) {
  return static_cast<std::uint64_t>((time + plan.interval() - can::Time(1)) / plan.interval());
}

}  // namespace

std::uint64_t Recovery::bound(const Ledger& ledger) const noexcept {
  const cansync::MasterSettings& settings = plan_.settings;
  const auto slaves = static_cast<std::uint64_t>(std::popcount(settings.configured().bits));
  const bool scans = settings.command_channel.serving == cansync::Serving::scan;
  const std::uint64_t turn = scans ? settings.process.maximum_slave.value() + 1u : 1u;
  std::uint64_t telegrams = 0;
  for (const auto& [id, job] : ledger.open()) {
    // A parameter that answers busy does it three times; a write may read its format before.
    telegrams += 8;
    if (job.kind != Job::Kind::transfer) continue;
    const std::uint64_t limit = settings.slaves[job.slave.value()].block_limit;
    const std::uint64_t blocks = (job.bytes + limit - 1) / limit;
    const std::uint64_t once = job.bytes / kBytesPerTelegram + 4 * blocks;
    const std::uint64_t busy = plan_.drives.front().memory.busy_replies;
    // A block that was spoilt is begun again.
    telegrams += (once + (settings.command_channel.block_retries + 1u) * (limit / kBytesPerTelegram + 4)) *
                 (1 + std::max<std::uint64_t>(busy, 2));
  }
  const std::uint64_t period = std::max(in_intervals(settings.startup.status_period, plan_), slaves);
  std::uint64_t lock = 0;
  for (const sim::DriveSettings& drive : plan_.drives) {
    lock = std::max(lock, in_intervals(drive.lock_time, plan_));
  }
  const std::uint64_t activated = in_intervals(cansync::kActivateAgain, plan_);
  return kOperator + activated + telegrams * turn + 2 * (period + slaves) + lock + period + 2 * slaves +
         slaves * (2 * turn + 2);
}

void Recovery::look(std::uint64_t tick, const MasterSnapshot& now, const Ledger& ledger) noexcept {
  if (phase_ == Phase::faults || phase_ == Phase::normal) return;
  missing_.clear();
  if (now.controller.state == can::ControllerState::bus_off) missing_ += " the controller is in bus-off;";
  if (!cansync::is_active(now.state)) missing_ += " the master is not active;";
  if (now.responding != now.configured) missing_ += " not every slave responds;";
  if (now.synchronized != now.configured) missing_ += " not every slave is synchronized;";
  const bool all_there = missing_.empty();
  if (!ledger.open().empty()) {
    missing_ += " " + std::to_string(ledger.open().size()) + " jobs are open, the oldest is " +
                std::to_string(ledger.open().begin()->first) + ";";
  }
  ready_ = phase_ == Phase::recovering && all_there && ledger.open().empty();
  overdue_ = overdue_ || tick > deadline_;
}

}  // namespace cansyncd::campaign
