#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "daemon/config/options.h"

/// The option table by sections, for what is printed of it.
namespace cansyncd {

/// "bus" of "bus.name", "slave.value" of "slave.value.unit".
std::string_view section_of(const Option& option);

/// "name" of "bus.name".
std::string_view name_of(const Option& option);

/// Every section, in the order of the table.
std::vector<std::string_view> sections();

/// As it stands in a file: in single brackets, or in double ones when it is repeated.
std::string section_title(std::string_view section);

/// What is to be said of a section; empty: nothing.
std::string_view section_help(std::string_view section);

}  // namespace cansyncd
