#include "cli/base/output.h"

#include <fmt/format.h>
#include <unistd.h>

#include "cli/base/files.h"
#include "cli/text/progress.h"

namespace cansync::cli {
namespace {

constexpr std::string_view kClear = "\x1b[2J";       // whole screen
constexpr std::string_view kHome = "\x1b[H";         // cursor to the upper left
constexpr std::string_view kEraseLine = "\x1b[K\n";  // rest of the line, next line
constexpr std::string_view kEraseBelow = "\x1b[J";   // from the cursor to the end

}  // namespace

bool Output::data_on_terminal() const noexcept {
  return ::isatty(::fileno(data_)) == 1;
}

void Output::bytes(std::string_view data) {
  write_all(::fileno(data_), data, "standard output");
}

void Output::set_slave(std::optional<unsigned> slave) {
  slave_ = slave ? fmt::format("slave {}:", *slave) : "";
}

void Output::line(std::string_view text) {
  bytes(fmt::format("{}{}{}\n", slave_, slave_.empty() ? "" : " ", text));
}

void Output::table(const Table& table) {
  std::string text = slave_.empty() ? "" : slave_ + '\n';
  text += table.heading() + '\n';
  for (const std::string& row : table.lines()) text += row + '\n';
  bytes(text);
}

std::size_t Output::data_width() const noexcept {
  return terminal_width(data_) - 1;
}

void Output::redraw(const std::vector<std::string>& lines) {
  std::string text;
  if (!cleared_) text += kClear;
  cleared_ = true;
  text += kHome;
  for (const std::string& line : lines) {
    text += line;
    text += kEraseLine;
  }
  text += kEraseBelow;
  bytes(text);
}

void Output::redraw(std::string_view title, const Table& table) {
  std::vector<std::string> lines{std::string(title), table.heading()};
  for (std::string& row : table.lines()) lines.push_back(std::move(row));
  redraw(lines);
}

void Output::remark(std::string_view text) {
  last_remark_ = text;
  // Nothing is left to say when stderr itself is gone.
  static_cast<void>(std::fputs(fmt::format("cansync: {}{}\n", place_, text).c_str(), remarks_));
}

}  // namespace cansync::cli
