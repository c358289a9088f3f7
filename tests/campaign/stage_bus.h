#pragma once

#include <deque>

#include "can/passing_bus.h"
#include "plan.h"
#include "sim/line.h"
#include "sync/sync_wire.h"

namespace cansyncd::campaign {

/// Is told what the realtime loop does with its bus, on the thread of the loop.
class BusObserver {
 public:
  virtual ~BusObserver() = default;
  /// A wait begins: the loop has done what there was to do.
  virtual void waits(can::Time now) noexcept = 0;
  virtual void edge(can::Time due, can::Time now) noexcept = 0;
  virtual void handed_over(const can::Frame& frame, can::Time now, can::SendResult result) noexcept = 0;
  virtual void received(const can::ReceivedFrame& frame) noexcept = 0;
};

/// The simulated line as a loop sees it whose thread may wake late, and may be woken by slots alone.
class StageBus final : public can::PassingBus, public sync_line::SyncWire {
 public:
  /// All must outlive the bus.
  StageBus(const Plan& plan, sim::Line& line, BusObserver& observer)
      : PassingBus(line), plan_(plan), line_(line), observer_(observer), dice_(plan.seed ^ 0x57A6E) {}

  can::Wake wait_until(can::Time deadline) noexcept override {
    observer_.waits(line_.now());
    if (deadline <= line_.now()) return line_.wait_until(deadline);
    if (!came_.empty() && !plan_.rare_looks) return can::Wake::frame;
    const can::Time late = lateness();
    while (line_.wait_until(deadline) == can::Wake::frame) {
      collect();
      if (plan_.rare_looks) continue;
      sleep_on(line_.now() + late);
      return can::Wake::frame;
    }
    sleep_on(deadline + late);
    return can::Wake::deadline;
  }

  bool receive(can::ReceivedFrame& out) noexcept override {
    collect();
    if (came_.empty()) return false;
    out = came_.front();
    came_.pop_front();
    observer_.received(out);
    return true;
  }

  can::SendResult send(const can::Frame& frame) noexcept override {
    const can::SendResult result = line_.send(frame);
    observer_.handed_over(frame, line_.now(), result);
    return result;
  }

  void sync_edge(can::Time due) noexcept override {
    observer_.edge(due, line_.now());
    line_.sync_edge(due);
  }

 private:
  /// In virtual time the line stands still while a frame waits in it.
  void collect() noexcept {
    can::ReceivedFrame frame;
    while (line_.receive(frame)) came_.push_back(frame);
  }

  void sleep_on(can::Time until) noexcept {
    while (until > line_.now() && line_.wait_until(until) == can::Wake::frame) collect();
  }

  can::Time lateness() noexcept {
    for (const Lateness& late : plan_.lateness) {
      if (!late.when.has(line_.intervals()) || !dice_.chance(late.per_mille)) continue;
      return can::Time(dice_.below(static_cast<std::uint64_t>(late.most.count()) + 1));
    }
    return can::Time{0};
  }

  const Plan& plan_;
  sim::Line& line_;
  BusObserver& observer_;
  Dice dice_;
  std::deque<can::ReceivedFrame> came_;
};

}  // namespace cansyncd::campaign
