#pragma once

#include <cstdint>
#include <functional>

#include "can/passing_bus.h"
#include "rt/alloc_counter.h"

namespace cansyncd::test {

/// Plays the gateway between two turns of a loop, and takes the account of its thread in between: at the turn
/// `first`, and at the turn `last`, when it ends the loop.
class WatchedTurns : public can::PassingBus {
 public:
  WatchedTurns(can::Bus& line, std::uint64_t first, std::uint64_t last)
      : PassingBus(line), first_(first), last_(last) {}

  std::function<void()> end;  ///< ends the loop
  std::uint64_t turns = 0;
  rt::ThreadCalls before;
  rt::ThreadCalls after;

  can::Wake wait_until(can::Time deadline) noexcept override {
    ++turns;
    if (turns == first_) before = rt::thread_calls();
    if (turns == last_) {
      after = rt::thread_calls();
      end();
    }
    work();
    return behind_.wait_until(deadline);
  }

 protected:
  virtual void work() noexcept = 0;

 private:
  const std::uint64_t first_;
  const std::uint64_t last_;
};

}  // namespace cansyncd::test
