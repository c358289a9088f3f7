#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cansync/config/config.h"
#include "config/rows.h"
#include "config/settings.h"

/// What the daemon's rows of options fill while a file is read. Main thread only.
namespace cansyncd {

using config::Option;
using config::OptionType;
using config::Position;
using config::Problem;
using config::Scalar;
using config::Setting;
using config::Settings;
using config::Value;

/// One telegram's mapping while a file is being read.
struct MappingDraft {
  std::optional<std::array<std::uint8_t, cansync::kWords>> registers;
  std::optional<std::array<int, cansync::kWords>> values;
  std::optional<std::array<bool, cansync::kWords>> high;
};
using MappingDrafts = std::array<MappingDraft, cansync::kChannels>;

/// A configuration while it is being read.
struct Draft {
  Config config;
  MappingDrafts reference = {};
  MappingDrafts actual_common = {};  ///< of slaves that do not give their own
  std::array<MappingDrafts, cansync::kSlaves> actual = {};
  std::array<std::optional<bool>, cansync::kSlaves> status_high = {};
  std::vector<Problem> profile_problems = {};  ///< they cost names and limits, not the start
  std::array<std::optional<Value>, cansync::kValues> start_within = {};  ///< of reference values
  std::array<std::vector<std::string>, cansync::kSlaves> expect = {};    ///< as given
  unsigned slave = 0;  ///< slave number an option of [[slave]] belongs to
  unsigned value = 0;  ///< value number an option of [[slave.value]], [[actual]] or [[reference]] belongs to
};

using Row = config::Row<Draft>;

}  // namespace cansyncd
