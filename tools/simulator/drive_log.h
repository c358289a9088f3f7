#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "simulator/bench.h"

namespace cansync_sim {

/// Tells when a drive's state has changed: activation, SYNC, control word, fault.
class DriveLog {
 public:
  /// `bench` must outlive the log; `remark` takes one line without line feed.
  DriveLog(const Bench& bench, std::function<void(const std::string&)> remark)
      : bench_(bench), remark_(std::move(remark)), states_(bench.drives().size()) {}

  /// Looks once per interval, however often it is called.
  void look();

 private:
  struct State {
    bool activated = false;
    bool synchronized = false;
    std::uint16_t control_word = sim::control_bit::run;
    std::uint16_t fault = sim::fault_code::none;
  };

  void look(const sim::Drive& drive, State& before);

  const Bench& bench_;
  std::function<void(const std::string&)> remark_;
  std::vector<State> states_;
  std::uint64_t looked_at_ = 0;
};

/// What was done, in one line.
std::string summary(const Bench& bench, std::uint64_t dropped);

}  // namespace cansync_sim
