#include "layer2/timers.h"

#include <algorithm>

#include "can/frame_length.h"

namespace layer2 {
namespace {

constexpr bool is_timer(unsigned number) noexcept {
  return number >= 1 && number <= Timers::kMost;
}

}  // namespace

std::int64_t share_of_bus(const TimerSettings& timer, std::uint32_t bits_per_second) noexcept {
  if (!timer.cyclic) return 0;
  return can::share_of_bus(can::least_bits(timer.frame), timer.period, bits_per_second);
}

std::int64_t Timers::share_of_others(unsigned number, std::uint32_t bits_per_second) const noexcept {
  std::int64_t share = 0;
  for (unsigned other = 1; other <= kMost; ++other) {
    if (other != number && configured(other)) share += share_of_bus(settings(other), bits_per_second);
  }
  return share;
}

bool Timers::configured(unsigned number) const noexcept {
  return is_timer(number) && timers_[number - 1].configured;
}

bool Timers::running(unsigned number) const noexcept {
  return is_timer(number) && timers_[number - 1].running;
}

bool Timers::configure(unsigned number, const TimerSettings& settings) noexcept {
  if (!is_timer(number) || settings.period <= Time{0} || settings.phase < Time{0}) return false;
  Timer& timer = timers_[number - 1];
  const bool same_grid = timer.settings.period == settings.period && timer.settings.phase == settings.phase &&
                         timer.settings.cyclic == settings.cyclic;
  timer.settings = settings;
  timer.configured = true;
  if (!same_grid) (void)stop(number);
  return true;
}

bool Timers::forget(unsigned number) noexcept {
  if (!stop(number)) return false;
  timers_[number - 1].configured = false;
  return true;
}

bool Timers::set_frame(unsigned number, const can::Frame& frame) noexcept {
  if (!configured(number)) return false;
  timers_[number - 1].settings.frame = frame;
  return true;
}

bool Timers::start(unsigned number, Time now) noexcept {
  if (!configured(number)) return false;
  Timer& timer = timers_[number - 1];
  timer.running = true;
  timer.due = false;
  timer.next = now + timer.settings.phase;
  return true;
}

bool Timers::stop(unsigned number) noexcept {
  if (!is_timer(number)) return false;
  timers_[number - 1].running = false;
  timers_[number - 1].due = false;
  return true;
}

void Timers::stop_all() noexcept {
  for (unsigned number = 1; number <= kMost; ++number) (void)stop(number);
}

void Timers::advance(Time now) noexcept {
  for (Timer& timer : timers_) {
    if (!timer.running || now < timer.next) continue;
    const auto passed = (now - timer.next) / timer.settings.period;
    const Time newest = timer.next + passed * timer.settings.period;
    if (!timer.settings.cyclic) {
      timer.running = false;
      timer.due = true;
      timer.due_since = timer.next;
      continue;
    }
    timer.left_out += static_cast<std::uint64_t>(passed) + (timer.due ? 1 : 0);
    timer.due = true;
    timer.due_since = newest;
    timer.next = newest + timer.settings.period;
  }
}

Time Timers::next_deadline() const noexcept {
  Time next = Time::max();
  for (const Timer& timer : timers_) {
    if (timer.running) next = std::min(next, timer.next);
  }
  return next;
}

std::optional<unsigned> Timers::due() const noexcept {
  std::optional<unsigned> found;
  for (unsigned number = 1; number <= kMost; ++number) {
    const Timer& timer = timers_[number - 1];
    if (timer.due && (!found || timer.due_since < timers_[*found - 1].due_since)) found = number;
  }
  return found;
}

void Timers::taken(unsigned number) noexcept {
  if (!is_timer(number) || !timers_[number - 1].due) return;
  timers_[number - 1].due = false;
  ++timers_[number - 1].sent;
}

WindowProblem check(const WindowSettings& settings) noexcept {
  if (settings.repeat <= Time{0}) return WindowProblem::repeat_not_over_zero;
  if (settings.begin < Time{0} || settings.end <= settings.begin) return WindowProblem::end_not_after_begin;
  return settings.end > settings.repeat ? WindowProblem::end_after_repeat : WindowProblem::none;
}

void SyncWindow::timer_started(unsigned number, Time now) noexcept {
  if (number == 2 && begun_) {
    running_ = true;
    start_ = *begun_;
  }
  begun_.reset();
  if (number == 1) {
    begun_ = now;
    running_ = false;
  }
}

void SyncWindow::timer_stopped(unsigned number) noexcept {
  begun_.reset();
  if (number == 1 || number == 2) running_ = false;
}

bool SyncWindow::open(Time now, Time length) const noexcept {
  if (!runs()) return true;
  const Time at = (now - start_) % settings_.repeat;
  return at >= settings_.begin && at + length <= settings_.end;
}

Time SyncWindow::next_opening(Time now) const noexcept {
  if (!runs()) return Time::max();
  const Time since = now - start_;
  const Time grid = start_ + since / settings_.repeat * settings_.repeat + settings_.begin;
  return grid > now ? grid : grid + settings_.repeat;
}

}  // namespace layer2
