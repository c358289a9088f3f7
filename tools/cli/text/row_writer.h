#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cli/text/table.h"

namespace cansync::cli {

/// Writes the rows of a table as they come, as `Table::line` does; for very many of them.
class RowWriter {
 public:
  explicit RowWriter(std::vector<Table::Column> columns);

  /// Appends the heading to `out`, with its line end.
  void append_heading(std::string& out) const;
  /// Appends one row, with its line end; a cell that is too long pushes the others on. As many cells as columns.
  void append(std::string& out, std::span<const std::string_view> cells) const;

 private:
  std::vector<Table::Column> columns_;
  std::vector<std::size_t> widths_;
};

}  // namespace cansync::cli
