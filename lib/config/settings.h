#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/document.h"
#include "config/option.h"
#include "config/problem.h"
#include "config/value.h"

/// From what stands in a file, or behind --set, to options with their values. Main thread only.
namespace config {

/// One option as it was given.
struct Setting {
  const Option* option = nullptr;
  std::vector<int> numbers;  ///< of the numbered sections it stands in, outermost first
  std::string key;           ///< the option's key with those numbers: "outer.3.inner.0.unit"
  Value value;
  Position where;
  bool overridden = false;  ///< given by --set, not by the file
};

/// Settings and what is wrong with them.
struct Settings {
  std::vector<Setting> items;
  std::vector<Problem> problems;
};

/// Finds the option of each value of a file; unknown sections and options, missing and repeated numbers are
/// problems. Values are not looked at, except the numbers. `table` must outlive the settings.
Settings resolve(const Document& document, const Table& table);

/// Takes one "KEY=VALUE" of --set into `settings`, in place of what the file says. The value is in TOML's
/// notation; strings may go without quotes.
void override_setting(Settings& settings, std::string_view assignment, const Table& table);

/// The settings of the file `source`, with `overrides` ("KEY=VALUE" of --set), which win over it. Never throws
/// for a wrong file: its problems are in the result.
Settings read_settings(const Source& source, std::span<const std::string> overrides, const Table& table);

}  // namespace config
