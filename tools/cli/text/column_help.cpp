#include "cli/text/column_help.h"

#include <algorithm>

namespace cansync::cli {
namespace {

constexpr std::size_t kLineWidth = 100;
constexpr std::size_t kIndent = 2;
constexpr std::size_t kGap = 2;

/// `text` broken at spaces; the lines after the first begin with `indent` spaces, the first has them already.
std::string wrapped(std::string_view text, std::size_t indent) {
  std::string out;
  std::size_t column = indent;
  while (!text.empty()) {
    const std::string_view word = text.substr(0, text.find(' '));
    text.remove_prefix(std::min(word.size() + 1, text.size()));
    const bool first = column == indent;
    if (!first && column + 1 + display_width(word) > kLineWidth) {
      out += '\n' + std::string(indent, ' ');
      column = indent;
    } else if (!first) {
      out += ' ';
      ++column;
    }
    out += word;
    column += display_width(word);
  }
  return out;
}

}  // namespace

std::string explanation(std::string_view title, const std::vector<Explained>& entries) {
  std::size_t width = 0;
  for (const Explained& entry : entries) width = std::max(width, display_width(entry.first));
  std::string out = std::string(title) + ':';
  for (const auto& [heading, text] : entries) {
    out += '\n' + std::string(kIndent, ' ') + heading;
    out += std::string(width - display_width(heading) + kGap, ' ');
    out += wrapped(text, kIndent + width + kGap);
  }
  return out;
}

std::string columns_help(const std::vector<Table::Column>& columns) {
  std::vector<Explained> entries;
  entries.reserve(columns.size());
  for (const Table::Column& column : columns) entries.emplace_back(column.heading, column.help);
  return explanation("Columns", entries);
}

}  // namespace cansync::cli
