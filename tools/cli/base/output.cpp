#include "cli/base/output.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <utility>

#include "cli/base/files.h"
#include "cli/text/progress.h"
#include "cli/text/values.h"
#include "text/counts.h"
#include "text/visible.h"

namespace cansync::cli {
namespace {

/// Stands for a slave and its number; no text for people has it.
constexpr std::string_view kSlaveHere = "\x01";

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

/// What `painted` writes around a text, at the beginning of `text`; empty: something else is there.
std::string_view own_sequence(std::string_view text) {
  for (const std::string_view own : {"\x1b[31m", "\x1b[32m", "\x1b[33m", "\x1b[0m"})
    if (text.starts_with(own)) return own;
  return {};
}

/// The text as a terminal may have it: our own colours stay, every other control character is written.
std::string for_terminal(std::string_view text, bool colours) {
  std::string out;
  std::size_t begin = 0;
  for (std::size_t at = 0; colours && at < text.size(); ++at) {
    const std::string_view own = own_sequence(text.substr(at));
    if (own.empty()) continue;
    out += text::visible(text.substr(begin, at - begin), "\n\t");
    out += own;
    begin = at + own.size();
    at = begin - 1;
  }
  return out + text::visible(text.substr(begin), "\n\t");
}

}  // namespace

bool Output::colours() const noexcept {
  if (colours_ != ColourUse::automatic) return colours_ == ColourUse::always;
  return data_on_terminal() && !environment_has("NO_COLOR") && !terminal_is_dumb();
}

std::string Output::painted(std::string_view text, Style style) const {
  const std::string_view colour = colour_of(style);
  if (colour.empty() || !colours()) return text::visible(text, "\n");
  return fmt::format("\x1b[{}m{}\x1b[0m", colour, text::visible(text, "\n"));
}

bool Output::data_on_terminal() const noexcept {
  return ::isatty(::fileno(data_)) == 1;
}

void Output::bytes(std::string_view data) {
  write_all(::fileno(data_), data, "standard output");
}

void Output::set_slave(std::optional<unsigned> slave) {
  if (of_slave_ && !kept_.empty()) {
    auto group =
        std::find_if(groups_.begin(), groups_.end(), [this](const Group& one) { return one.said == kept_; });
    if (group == groups_.end()) group = groups_.insert(group, {0, kept_});
    group->slaves |= 1u << *of_slave_;
    kept_.clear();
  }
  of_slave_ = slave;
  slave_ = slave ? fmt::format("slave {}:", *slave) : "";
}

void Output::keep(bool data, std::string_view text) {
  const std::string own = fmt::format("slave {}", *of_slave_);
  std::string out;
  for (std::size_t from = 0;;) {
    const std::size_t at = text.find(own, from);
    const std::size_t behind = at + own.size();
    out += text.substr(from, at - from);
    if (at == std::string_view::npos) break;
    const bool longer = behind < text.size() && text[behind] >= '0' && text[behind] <= '9';
    out += longer ? own : std::string(kSlaveHere);
    from = behind;
  }
  kept_.push_back({data, std::move(out)});
}

void Output::say(const Group& group) {
  const bool one = std::popcount(group.slaves) == 1;
  const std::string who = fmt::format("{} {}", one ? "slave" : "slaves", format_slave_set(group.slaves));
  for (const Kept& kept : group.said) {
    std::string text = kept.text;
    for (std::size_t at = 0; (at = text.find(kSlaveHere)) != std::string::npos;)
      text.replace(at, kSlaveHere.size(), who);
    if (kept.data)
      line(fmt::format("{}: {}", who, text));
    else
      remark(text);
  }
}

void Output::say_kept() {
  if (!grouping_ || !of_slave_) return;
  const unsigned slave = *of_slave_;
  const Group own{1u << slave, std::exchange(kept_, {})};
  set_slave(std::nullopt);
  say(own);
  set_slave(slave);
}

void Output::end_group() {
  grouping_ = false;
  for (const Group& group : std::exchange(groups_, {})) say(group);
}

void Output::line(std::string_view text) {
  if (grouping_ && of_slave_) return keep(true, text);
  bytes(fmt::format("{}{}{}\n", slave_, slave_.empty() ? "" : " ", for_terminal(text, colours())));
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
    text += for_terminal(line, true);
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
  last_remark_ = text::visible(text, "\n\t");
  if (grouping_ && of_slave_) return keep(false, text);
  remark_now(last_remark_);
}

void Output::remark_now(std::string_view text) const {
  // Nothing is left to say when stderr itself is gone.
  static_cast<void>(std::fputs(
      fmt::format("cansync: {}{}\n", text::visible(place_), text::visible(text, "\n\t")).c_str(), remarks_));
}

}  // namespace cansync::cli
