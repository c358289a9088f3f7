#include "cli/base/output.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>

#include "cli/base/files.h"
#include "cli/text/progress.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

constexpr std::string_view kClear = "\x1b[2J";       // whole screen
constexpr std::string_view kHome = "\x1b[H";         // cursor to the upper left
constexpr std::string_view kEraseLine = "\x1b[K\n";  // rest of the line, next line
constexpr std::string_view kEraseBelow = "\x1b[J";   // from the cursor to the end

/// A variable of the environment that is set to something.
bool environment_has(const char* variable) {
  const char* value = std::getenv(variable);  // NOLINT(concurrency-mt-unsafe): nobody changes the environment
  return value != nullptr && *value != '\0';
}

bool terminal_is_dumb() {
  const char* kind = std::getenv("TERM");  // NOLINT(concurrency-mt-unsafe): nobody changes the environment
  return kind == nullptr || std::string_view(kind) == "dumb" || *kind == '\0';
}

/// What follows "ESC[" for a style; empty: nothing.
std::string_view colour_of(Style style) {
  switch (style) {
    case Style::bad:
      return "31";  // red
    case Style::warning:
      return "33";  // yellow
    case Style::good:
      return "32";  // green
    default:
      return "";
  }
}

}  // namespace

bool Output::colours() const noexcept {
  if (colours_ != ColourUse::automatic) return colours_ == ColourUse::always;
  return data_on_terminal() && !environment_has("NO_COLOR") && !terminal_is_dumb();
}

std::string Output::painted(std::string_view text, Style style) const {
  const std::string_view colour = colour_of(style);
  if (colour.empty() || !colours()) return std::string(text);
  return fmt::format("\x1b[{}m{}\x1b[0m", colour, text);
}

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

void Output::table(const Table& table, const std::vector<Style>& rows) {
  const std::size_t width = fitting_width();
  const Table shown = table.fitted_to(width);
  std::string text = slave_.empty() ? "" : slave_ + '\n';
  text += shown.heading() + '\n';
  const std::vector<std::string> lines = shown.lines(width);
  for (std::size_t i = 0; i < lines.size(); ++i)
    text += (i < rows.size() ? painted(lines[i], rows[i]) : lines[i]) + '\n';
  bytes(text);
  if (const std::size_t left_out = table.columns() - shown.columns(); left_out != 0)
    remark(text::counted(left_out, "column does not fit or has only zeros",
                         "columns do not fit or have only zeros") +
           ": --wide shows all");
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
