#include "cli/text/table.h"

#include <algorithm>
#include <stdexcept>

namespace cansync::cli {

std::size_t display_width(std::string_view text) noexcept {
  // Every byte that does not continue a UTF-8 sequence begins a character.
  return static_cast<std::size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0u) != 0x80u; }));
}

Table::Table(std::vector<Column> columns) : columns_(std::move(columns)) {
  for (const Column& column : columns_)
    widths_.push_back(std::max(display_width(column.heading), column.width));
}

void Table::add(std::vector<std::string> cells) {
  if (cells.size() > columns_.size()) throw std::logic_error("more cells than columns");
  cells.resize(columns_.size());
  for (std::size_t i = 0; i < cells.size(); ++i) widths_[i] = std::max(widths_[i], display_width(cells[i]));
  rows_.push_back(std::move(cells));
}

std::string Table::line(const std::vector<std::string>& cells) const {
  std::string out;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::size_t width = display_width(cells[i]);
    const std::string space(widths_[i] - std::min(width, widths_[i]), ' ');
    if (i != 0) out += "  ";
    out += columns_[i].align == Align::right ? space + cells[i] : cells[i] + space;
  }
  out.erase(out.find_last_not_of(' ') + 1);
  return out;
}

std::string Table::heading() const {
  std::vector<std::string> cells;
  for (const Column& column : columns_) cells.push_back(column.heading);
  return line(cells);
}

std::vector<std::string> Table::lines() const {
  std::vector<std::string> out;
  for (const auto& row : rows_) out.push_back(line(row));
  return out;
}

}  // namespace cansync::cli
