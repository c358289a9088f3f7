#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "config/problem.h"
#include "config/settings.h"
#include "daemon_config/daemon_config.h"

/// What one row of the daemon's options cannot do alone. Main thread only.
namespace cansyncd {

/// Where each option of a file was given, and what was found wrong with them.
class Findings {
 public:
  /// `path` names the file in problems; both must outlive the object.
  Findings(const std::vector<config::Setting>& settings, const std::string& path);

  /// The option as it was given, by its key with numbers; null: it was not.
  const config::Setting* place(const std::string& key) const;

  /// Something wrong with the option: where it was given, else of the whole file.
  void problem(const std::string& key, std::string text);

  /// A relative path of the file starts at its folder, one of the command line where that was typed.
  void finish_path(const std::string& key, std::string& path) const;

  const std::string& path() const noexcept { return path_; }
  std::vector<config::Problem>& problems() noexcept { return problems_; }

  /// Something wrong with an option, in the place where it was given, else in the whole file.
  config::Problem at(const std::string& key, std::string text) const;

 private:
  const std::string& path_;
  std::map<std::string_view, const config::Setting*> places_;
  std::vector<config::Problem> problems_;
};

/// Fills in defaults that follow from other options of the daemon: the names of bus and partition.
void apply_derived(DaemonConfig& config, const std::vector<config::Setting>& settings);

/// Checks that concern more than one of the daemon's options, or files that they name; makes their paths
/// absolute or relative to the working folder.
void check_daemon(DaemonConfig& config, Findings& findings);

}  // namespace cansyncd
