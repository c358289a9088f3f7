#include "cli/text/table.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "text/visible.h"

namespace cansync::cli {
namespace {

constexpr std::size_t kColumnGap = 2;
/// Where fewer characters and less than half of a line are left for the last cell, it gets lines of its own,
/// set in by so many.
constexpr std::size_t kReadable = 24;
constexpr std::size_t kSetIn = 4;

/// Whether a cell that takes so many characters and begins there belongs on lines of its own.
bool on_own_lines(std::size_t taken, std::size_t column, std::size_t width) noexcept {
  return width != 0 && column + taken > width && column + std::min(kReadable, width / 2) > width;
}

}  // namespace

std::size_t display_width(std::string_view text) noexcept {
  // Every byte that does not continue a UTF-8 sequence begins a character.
  return static_cast<std::size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0u) != 0x80u; }));
}

std::string folded(std::string_view text, std::size_t indent, std::size_t width) {
  if (width == 0) return std::string(text);
  std::string out;
  std::size_t column = indent;
  bool first = true;
  while (!text.empty()) {
    const std::string_view word = text.substr(0, text.find(' '));
    text.remove_prefix(std::min(word.size() + 1, text.size()));
    if (!first && column + 1 + display_width(word) > width) {
      out += '\n' + std::string(indent, ' ');
      column = indent;
    } else if (!first) {
      out += ' ';
      ++column;
    }
    first = false;
    out += word;
    column += display_width(word);
  }
  return out;
}

Table::Table(std::vector<Column> columns) : columns_(std::move(columns)) {
  for (const Column& column : columns_)
    widths_.push_back(std::max(display_width(column.heading), column.width));
}

void Table::add(std::vector<std::string> cells) {
  if (cells.size() > columns_.size()) throw std::logic_error("more cells than columns");
  cells.resize(columns_.size());
  for (std::string& cell : cells) cell = text::visible(cell);
  for (std::size_t i = 0; i < cells.size(); ++i) widths_[i] = std::max(widths_[i], display_width(cells[i]));
  rows_.push_back(std::move(cells));
}

Table Table::fitted_to(std::size_t width) const {
  if (width == 0) return *this;
  const auto only_zeros = [this](std::size_t column) {
    return std::all_of(rows_.begin(), rows_.end(), [column](const auto& row) { return row[column] == "0"; });
  };
  std::vector<std::size_t> by_place(columns_.size());
  std::iota(by_place.begin(), by_place.end(), 0u);
  std::stable_sort(by_place.begin(), by_place.end(), [this](std::size_t one, std::size_t other) {
    return columns_[one].place < columns_[other].place;
  });
  std::vector<std::size_t> chosen;
  std::size_t used = 0;
  for (const std::size_t i : by_place) {
    const Column& column = columns_[i];
    const std::size_t wanted = widths_[i] + (chosen.empty() ? 0 : kColumnGap);
    if (column.place != 0 && (used + wanted > width || (column.counts && only_zeros(i)))) continue;
    used += wanted;
    chosen.push_back(i);
  }
  std::sort(chosen.begin(), chosen.end());
  std::vector<Column> columns;
  columns.reserve(chosen.size());
  for (const std::size_t i : chosen) columns.push_back(columns_[i]);
  Table out(std::move(columns));
  for (const auto& row : rows_) {
    std::vector<std::string> cells;
    cells.reserve(chosen.size());
    for (const std::size_t i : chosen) cells.push_back(row[i]);
    out.add(std::move(cells));
  }
  return out;
}

std::string Table::line(const std::vector<std::string>& cells, std::size_t width) const {
  std::string out;
  std::size_t column = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::size_t taken = display_width(cells[i]);
    const std::size_t space = widths_[i] - std::min(taken, widths_[i]);
    const bool last = i + 1 == cells.size() && columns_[i].align == Align::left;
    if (last && i != 0 && on_own_lines(taken, column, width)) {
      out.erase(out.find_last_not_of(' ') + 1);
      return out + '\n' + std::string(kSetIn, ' ') + folded(cells[i], kSetIn, width);
    }
    if (i != 0) out.append(kColumnGap, ' ');
    const bool right = columns_[i].align == Align::right;
    if (right) out.append(space, ' ');
    out += last ? folded(cells[i], column, width) : cells[i];
    if (!right && !last) out.append(space, ' ');
    column += std::max(taken, widths_[i]) + kColumnGap;
  }
  out.erase(out.find_last_not_of(' ') + 1);
  return out;
}

std::string Table::heading() const {
  std::vector<std::string> cells;
  for (const Column& column : columns_) cells.push_back(column.heading);
  return line(cells);
}

std::vector<std::string> Table::lines(std::size_t width) const {
  std::vector<std::string> out;
  for (const auto& row : rows_) out.push_back(line(row, width));
  return out;
}

}  // namespace cansync::cli
