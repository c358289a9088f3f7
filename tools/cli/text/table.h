#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

/// Columns of text for people.
namespace cansync::cli {

/// Characters `text` takes on a terminal: UTF-8 code points (combining and wide characters are not looked
/// at).
std::size_t display_width(std::string_view text) noexcept;

/// A table whose columns grow with their content and never shrink, so that lines printed later still fit
/// those printed before.
class Table {
 public:
  enum class Align : unsigned char { left, right };
  struct Column {
    std::string heading;
    Align align = Align::left;
    std::string help;       ///< what stands in it, for the verb's help (columns_help)
    std::size_t width = 0;  ///< characters it takes at least
  };

  explicit Table(std::vector<Column> columns);

  /// Adds a row; cells that are left out are empty. More cells than columns are not allowed.
  void add(std::vector<std::string> cells);
  /// Drops the rows; column widths stay.
  void clear() { rows_.clear(); }

  /// The heading line, without a line end.
  std::string heading() const;
  /// One line for each row, without line ends.
  std::vector<std::string> lines() const;
  /// One line of these cells in the columns as they are, for rows that are written as they come; a cell that
  /// is too long pushes the others on. As many cells as columns.
  std::string line(const std::vector<std::string>& cells) const;

 private:
  std::vector<Column> columns_;
  std::vector<std::size_t> widths_;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace cansync::cli
