#include "cli/text/column_help.h"

#include <algorithm>

namespace cansync::cli {
namespace {

constexpr std::size_t kLineWidth = 100;
constexpr std::size_t kIndent = 2;
constexpr std::size_t kGap = 2;

}  // namespace

std::string explanation(std::string_view title, const std::vector<Explained>& entries) {
  std::size_t width = 0;
  for (const Explained& entry : entries) width = std::max(width, display_width(entry.first));
  std::string out = std::string(title) + ':';
  for (const auto& [heading, text] : entries) {
    out += '\n' + std::string(kIndent, ' ') + heading;
    out += std::string(width - display_width(heading) + kGap, ' ');
    out += folded(text, kIndent + width + kGap, kLineWidth);
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
