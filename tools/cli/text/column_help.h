#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/text/table.h"

/// Explanations in a verb's help, made of the same description as what the verb writes.
namespace cansync::cli {

/// A column's heading or a line's label, and what stands there in words.
using Explained = std::pair<std::string, std::string>;

/// `title` with a colon, then each heading with its explanation, wrapped and indented; no line end after the
/// last line.
std::string explanation(std::string_view title, const std::vector<Explained>& entries);

/// The explanation of these columns under the title "Columns".
std::string columns_help(const std::vector<Table::Column>& columns);

}  // namespace cansync::cli
