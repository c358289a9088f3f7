#include "sync/phc_output.h"

namespace sync_line {
namespace {

/// From the decision to start until the first edge; drivers want it in their future.
constexpr Time kLead = std::chrono::milliseconds(50);
/// Readings before the thread takes over, so that the relation is there at the start.
constexpr int kFirstReadings = 4;

}  // namespace

PhcOutput::PhcOutput(System& system, const PhcPin& pin, Time interval, const PhcOptions& options)
    : interval_(interval),
      device_(system, pin, options),
      // A process that was killed leaves its edges running.
      running_(device_.stop() ? std::optional(false) : std::nullopt) {
  for (int i = 0; i < kFirstReadings; ++i) step();
}

PhcOutput::~PhcOutput() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  stop_.notify_all();
  if (thread_.joinable()) thread_.join();
  if (running_ != false) device_.stop();
}

void PhcOutput::start_thread() {
  thread_ = std::thread([this] { run(); });
}

void PhcOutput::run() noexcept {
  std::unique_lock lock(mutex_);
  while (!stop_.wait_for(lock, kPeriod, [this] { return stopping_; })) {
    lock.unlock();
    step();
    lock.lock();
  }
}

void PhcOutput::step() noexcept {
  const auto sample = device_.sample();
  if (!sample) {
    if (device_.error() != 0) error_.store(device_.error(), std::memory_order_relaxed);
    return;
  }
  relation_.add(*sample);
  clock_steps_.store(relation_.steps(), std::memory_order_relaxed);
  error_.store(0, std::memory_order_relaxed);
  if (!relation_.valid()) return;
  line_.write(relation_.line());
  const bool wanted = wanted_.load(std::memory_order_relaxed);
  const bool restart = running_ == true && steps_known_ != relation_.steps();
  if (restart || wanted != running_) switch_output(wanted);
}

void PhcOutput::switch_output(bool on) noexcept {
  const bool done = on ? device_.start(relation_.line().hardware + kLead, interval_) : device_.stop();
  if (!done) {
    error_.store(device_.error(), std::memory_order_relaxed);
    return;
  }
  running_ = on;
  steps_known_ = relation_.steps();
}

bool PhcOutput::take(Time near, Time& at) noexcept {
  if (line_.read(known_)) any_ = true;
  if (!any_ || near - known_.monotonic > kFresh) return false;
  const Time hardware = known_.to_hardware(near) + interval_ / 2;
  at = known_.to_monotonic(hardware / interval_ * interval_);
  // The edge taken last may have moved a little with a new relation.
  if (at - last_ < interval_ / 2) return false;
  last_ = at;
  return true;
}

}  // namespace sync_line
