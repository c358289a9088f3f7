#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/config/settings.h"
#include "daemon/config/value.h"

namespace cansyncd {

/// A configuration as read, together with where it came from.
struct ConfigFile {
  std::string path;
  Config config;                  ///< only to be used when there are no problems
  std::vector<Setting> settings;  ///< what was given, by the file or --set
  std::vector<Problem> problems;  ///< everything found wrong, in the order of the file
};

/// Reads and checks `path`; `overrides` are "KEY=VALUE" and win over the file. Never throws for a wrong file:
/// all of its problems are in the result. Main thread.
ConfigFile load_config(const std::string& path, std::span<const std::string> overrides);

/// The same for settings that are already there; `path` names the file in problems.
ConfigFile build_config(Settings settings, const std::string& path);

/// Most problems that are told one by one.
inline constexpr std::size_t kProblemsShown = 20;

/// The problems for people, one a line, at most `kProblemsShown` and then how many more there are.
std::string problems_text(const std::vector<Problem>& problems);

}  // namespace cansyncd
