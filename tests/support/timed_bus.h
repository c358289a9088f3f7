#pragma once

#include <algorithm>
#include <functional>
#include <map>

#include "can/passing_bus.h"

namespace cansyncd::test {

/// Does what the test wants at instants of the bus, before the loop looks.
class TimedBus : public can::PassingBus {
 public:
  explicit TimedBus(can::Bus& line) : PassingBus(line) {}

  std::multimap<can::Time, std::function<void()>> script;

  can::Wake wait_until(can::Time deadline) noexcept override {
    if (!script.empty()) deadline = std::min(deadline, script.begin()->first);
    const can::Wake wake = behind_.wait_until(deadline);
    woken(wake);
    while (!script.empty() && script.begin()->first <= behind_.now()) {
      const auto action = script.begin()->second;
      script.erase(script.begin());
      action();
    }
    return wake;
  }

 protected:
  /// Before what is to be done then.
  virtual void woken(can::Wake /*wake*/) noexcept {}
};

}  // namespace cansyncd::test
