#pragma once

#include <functional>
#include <string>

#include "simulator/bench.h"
#include "simulator/port.h"

namespace cansync_sim {

/// What the program says while it runs.
struct RunSettings {
  std::string interface;                           ///< for messages
  bool verbose = false;                            ///< tell every change of a drive's state
  std::function<void(const std::string&)> remark;  ///< takes one line without line feed
};

/// How to get an interface that is missing or down, as a command.
std::string remedy(Link link, const std::string& interface);

/// Lets the drives live on the port until it says stop. A lost interface is told once and waited for.
void run(Bench& bench, Port& port, const RunSettings& settings);

/// What was done, in one line.
std::string summary(const Bench& bench, std::uint64_t dropped);

}  // namespace cansync_sim
