#include "cli/text/row_writer.h"

#include <algorithm>
#include <utility>

namespace cansync::cli {
namespace {

constexpr std::size_t kGapOfRow = 2;

}  // namespace

RowWriter::RowWriter(std::vector<Table::Column> columns) : columns_(std::move(columns)) {
  for (const Table::Column& column : columns_)
    widths_.push_back(std::max(display_width(column.heading), column.width));
}

void RowWriter::append_heading(std::string& out) const {
  std::vector<std::string_view> cells;
  for (const Table::Column& column : columns_) cells.emplace_back(column.heading);
  append(out, cells);
}

void RowWriter::append(std::string& out, std::span<const std::string_view> cells) const {
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::size_t taken = display_width(cells[i]);
    const std::size_t space = widths_[i] - std::min(taken, widths_[i]);
    const bool right = columns_[i].align == Table::Align::right;
    if (i != 0) out.append(kGapOfRow, ' ');
    if (right) out.append(space, ' ');
    out += cells[i];
    if (!right && i + 1 != cells.size()) out.append(space, ' ');
  }
  out.erase(out.find_last_not_of(' ') + 1);
  out += '\n';
}

}  // namespace cansync::cli
