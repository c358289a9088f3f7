#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "config/settings.h"
#include "layer2/config/file.h"
#include "layer2/module.h"

namespace cansyncd {

/// A configuration that is to take the place of the one in force, and what the realtime thread gets of it.
struct PreparedConfiguration {
  Layer2Config config;
  std::vector<config::Setting> settings;
  layer2::PreparedSettings module;
};

/// The configuration in force while the daemon runs, which requests change in parts. Gateway thread only,
/// once it runs.
///
/// A request has sections of a configuration file. Each option that it names takes the place of the one in force,
/// and all sections of an array ([[timer]]) that it names that of the array in force; everything else stays.
/// `[mapping]` with nothing in it ends the mapping; ranges take the place of the node filter, too. The whole is read by
/// the reader of the file.
class RunningConfiguration {
 public:
  /// `file` has no problems.
  explicit RunningConfiguration(const Layer2File& file) : config_(file.config), settings_(file.settings) {}

  /// What a text would make of the configuration; null, and `problem` says the place and the reason of the
  /// first thing that is wrong. Nothing changes. Only while none is under way.
  std::shared_ptr<PreparedConfiguration> prepare(std::string_view toml, std::string& problem);

  /// A prepared one is still used, so that another would be made of what it may replace.
  bool under_way() const noexcept { return !under_way_.expired(); }

  /// The realtime thread has taken it over.
  void adopt(const PreparedConfiguration& prepared);

  /// What was taken over last.
  const Layer2Config& config() const noexcept { return config_; }
  /// Rises with each configuration that was taken over.
  std::uint64_t changes() const noexcept { return changes_; }
  /// Of them, those with another table of the process image.
  std::uint32_t tables() const noexcept { return tables_; }

 private:
  Layer2Config config_;
  std::vector<config::Setting> settings_;
  std::weak_ptr<PreparedConfiguration> under_way_;
  std::uint64_t changes_ = 0;
  std::uint32_t tables_ = 0;
};

}  // namespace cansyncd
