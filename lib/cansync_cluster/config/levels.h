#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/document.h"
#include "config/option.h"
#include "config/settings.h"

/// The levels of a cluster's file: what stands below `upper` and `lower` is the file of a slave and of a
/// master. Main thread.
namespace cansyncd {

/// One level.
struct LevelOptions {
  std::string_view name;        ///< "upper"
  const config::Table& table;   ///< what stands below it
  const config::Table& common;  ///< what all levels have, which stands without a level
  /// Options of `table` that mean nothing here; "sync.input" and the like, each with the reason.
  struct Excluded {
    std::string_view key;
    std::string_view why;
  };
  std::span<const Excluded> excluded;
};

/// Takes what belongs to the level out of the file's document, and the level's name out of its paths.
config::Document take_level(config::Document& document, std::string_view name);

/// Resolves the level's part of the file and of `overrides` ("upper.KEY=VALUE"), without what is wrong, and
/// adds what all levels have: `common`, of which the name of the bus and the partition get the level's name,
/// the former `bus` when it is not given.
config::Settings level_settings(const config::Document& document, const LevelOptions& level,
                                std::span<const std::string> overrides,
                                const std::vector<config::Setting>& common, const std::string& bus);

/// Puts the level's name before the keys of problems that are not of common options.
void name_level(std::vector<config::Problem>& problems, const LevelOptions& level);

}  // namespace cansyncd
