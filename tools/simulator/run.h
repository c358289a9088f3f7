#pragma once

#include <functional>
#include <string>

#include "simulator/port.h"
#include "simulator/station.h"

namespace cansync_sim {

/// What the program says while it runs.
struct RunSettings {
  std::string interface;                           ///< for messages
  std::function<void(const std::string&)> remark;  ///< takes one line without line feed
  std::function<void()> look = {};                 ///< called after each received frame; may be empty
};

/// How to get an interface that is missing or down, as a command.
std::string remedy(Link link, const std::string& interface);

/// Lets the station live on the port until it says stop. A lost interface is told once and waited for.
void run(Station& station, Port& port, const RunSettings& settings);

}  // namespace cansync_sim
