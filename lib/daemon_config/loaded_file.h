#pragma once

#include <string>
#include <utility>
#include <vector>

#include "config/problem.h"
#include "config/rows.h"
#include "config/settings.h"
#include "daemon_config/check_daemon.h"

namespace cansyncd {

/// A configuration as read, together with where it came from. `Config`: a DaemonConfig.
template <class Config>
struct LoadedFile {
  std::string path;
  Config config;                          ///< only to be used when there are no problems
  std::vector<config::Setting> settings;  ///< what was given, by the file or --set
  std::vector<config::Problem> problems;  ///< everything found wrong, in the order of the file
  /// Of drive profiles that are missing or wrong: their slaves have no names of parameters and no limits.
  std::vector<config::Problem> profile_problems;
  /// Of the fault script of a simulated bus: the faults that these are in are left out.
  std::vector<config::Problem> script_problems;
};

/// What keeps the file from taking the place of a running one: a profile that is wrong, too, for the names
/// and limits of the running one are known. A fault script is read at the start alone.
template <class File>
std::vector<config::Problem> refused_by_reload(const File& wanted) {
  return wanted.problems.empty() ? wanted.profile_problems : wanted.problems;
}

/// Puts the settings of the file `path` into a draft, checks them, and takes the draft's configuration.
/// `Draft`: `config`, and `begin(number)`, which tells the number of the section that the next setting is of.
/// `finish(draft, findings)`: what no row can check alone. Main thread.
template <class Draft, class Finish>
LoadedFile<decltype(Draft::config)> build_file(config::Settings settings, const std::string& path,
                                               const config::Rows<Draft>& rows, Finish finish) {
  LoadedFile<decltype(Draft::config)> file;
  file.path = path;
  file.problems = std::move(settings.problems);
  Draft draft;
  for (const config::Setting& setting : settings.items) {
    draft.begin(setting.numbers.empty() ? 0 : static_cast<unsigned>(setting.numbers.front()));
    if (auto text = rows.apply(*setting.option, setting.value, draft))
      file.problems.push_back({setting.where, setting.key, std::move(*text)});
  }
  apply_derived(draft.config, settings.items);
  // With wrong values the cross-checks would only complain about what is missing because of them.
  if (file.problems.empty()) {
    Findings findings(settings.items, path);
    check_daemon(draft.config, findings);
    finish(draft, findings);
    file.problems = std::move(findings.problems());
  }
  config::sort_by_place(file.problems);
  file.config = std::move(draft.config);
  file.settings = std::move(settings.items);
  return file;
}

}  // namespace cansyncd
