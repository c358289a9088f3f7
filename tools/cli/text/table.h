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

/// `text` broken at blanks so that no line is over `width` characters wide, unless a word is; the first line
/// begins at column `indent`, which is not put there, the others with so many spaces. `width` 0: as it is.
std::string folded(std::string_view text, std::size_t indent, std::size_t width);

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
    /// Where room is short (fitted_to): 0 stays, and of the others those with greater numbers go first.
    unsigned place = 0;
    bool counts = false;  ///< goes there, too, when its cells are all "0"
  };

  explicit Table(std::vector<Column> columns);

  /// Adds a row; cells that are left out are empty. More cells than columns are not allowed.
  void add(std::vector<std::string> cells);
  /// The same rows in those columns that matter most and fit into `width` characters; 0: in all.
  Table fitted_to(std::size_t width) const;
  std::size_t columns() const noexcept { return columns_.size(); }
  /// Drops the rows; column widths stay.
  void clear() { rows_.clear(); }

  /// The heading line, without a line end.
  std::string heading() const;
  /// One line for each row, without line ends. Where `width` is not 0, what is longer is folded within the
  /// last column, which is then to the left; where that has too little room, its cell follows on lines of its
  /// own.
  std::vector<std::string> lines(std::size_t width = 0) const;
  /// One line of these cells in the columns as they are, for rows that are written as they come; a cell that
  /// is too long pushes the others on. As many cells as columns; `width` as above.
  std::string line(const std::vector<std::string>& cells, std::size_t width = 0) const;

 private:
  std::vector<Column> columns_;
  std::vector<std::size_t> widths_;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace cansync::cli
