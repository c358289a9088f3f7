#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "daemon/config/document.h"
#include "daemon/config/options.h"
#include "daemon/config/value.h"

/// From what stands in a file, or behind --set, to options with their values. Main thread only.
namespace cansyncd {

/// One option as it was given.
struct Setting {
  const Option* option = nullptr;
  int slave = -1;        ///< slave number of an option of [[slave]]
  int value_index = -1;  ///< value number of an option of [[slave.value]], [[actual]] or [[reference]]
  Value value;
  Position where;
  bool overridden = false;  ///< given by --set, not by the file

  /// The option's key with its numbers: "bus.name", "slave.3.value.0.unit", "reference.2.name".
  std::string key() const;
};

/// Settings and what is wrong with them.
struct Settings {
  std::vector<Setting> items;
  std::vector<Problem> problems;
};

/// Finds the option of each value of a file; unknown sections and options, missing and repeated numbers are
/// problems. Values are not looked at, except the numbers.
Settings resolve(const Document& document);

/// Takes one "KEY=VALUE" of --set into `settings`, in place of what the file says. The value is in TOML's
/// notation; strings may go without quotes.
void override_setting(Settings& settings, std::string_view assignment);

}  // namespace cansyncd
