#pragma once

#include <string>
#include <string_view>

#include "row.h"

namespace given {

/// What was seen of a row while something happened to it.
struct Seen {
  std::string bus;
  std::string giver;
  std::string others;
};

/// Lets the event that a column of the table is named after happen to what was given. Throws std::out_of_range when
/// there is no such column.
Seen let_happen(std::string_view column, Row& row);

}  // namespace given
