#include "cansync/config/reload.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "config/reload.h"

namespace cansyncd {
namespace {

/// Options of the line alone: slaves, bit rate, identifiers, and what the master does with them. What belongs
/// to the process (its name, DDS, rights, files) is not among them.
bool is_of_line(const Setting& setting) {
  constexpr std::array<std::string_view, 6> kOfLine = {"slave.",   "process.",         "actual.",
                                                       "startup.", "command_channel.", "reference."};
  constexpr std::array<std::string_view, 3> kOptions = {"bus.bit_rate", "bus.send_margin_us",
                                                        "sync.can_identifier"};
  const std::string_view key = setting.option->key;
  return std::any_of(kOfLine.begin(), kOfLine.end(),
                     [key](std::string_view section) { return key.starts_with(section); }) ||
         std::find(kOptions.begin(), kOptions.end(), key) != kOptions.end();
}

}  // namespace

ConfigReload plan_reload(const ConfigFile& running, const ConfigFile& wanted) {
  // What a slave, that only one of the two files has, gives does not take effect: the set of slaves needs a
  // restart.
  config::Changes changes = config::compare(running.settings, wanted.settings, [&](const Setting& setting) {
    const std::optional<unsigned> slave = slave_of(setting);
    return !slave || (running.config.master.slaves[*slave].configured &&
                      wanted.config.master.slaves[*slave].configured);
  });
  config::Changes line = config::replace(running.settings, wanted.settings, [](const Setting& setting) {
    return is_of_line(setting) || setting.option->reload;
  });
  ConfigReload plan{build_config(std::move(changes.merged), wanted.path),
                    std::move(changes.applied),
                    std::move(changes.needs_restart),
                    build_config(std::move(line.merged), wanted.path),
                    {}};
  for (const std::string& key : plan.needs_restart) {
    if (std::find(line.applied.begin(), line.applied.end(), key) != line.applied.end())
      plan.needs_set_up.push_back(key);
  }
  return plan;
}

}  // namespace cansyncd
