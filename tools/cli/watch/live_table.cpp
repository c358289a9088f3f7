#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "cli/text/column_help.h"
#include "cli/watch/live_layout.h"

namespace cansync::cli {
namespace {

constexpr std::array<std::string_view, 8> kUnicodeLevels{"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
constexpr std::array<std::string_view, 4> kAsciiLevels{"_", ".", "-", "'"};
constexpr std::int64_t kOld = 1000;  // ms after which an actual value is marked

constexpr std::size_t kNumberWidth = 3;
constexpr std::size_t kStateWidth = 9;  // "returning"
constexpr std::size_t kStatusWidth = 6;
constexpr std::size_t kAgeWidth = 7;
constexpr std::size_t kAnswersWidth = 8;
constexpr std::size_t kGap = 2;
constexpr std::size_t kValueWidth = 12;  // "-2147483648", "position rev"
constexpr std::size_t kLeastTrend = 6;
constexpr std::size_t kMostTrend = 20;
constexpr std::size_t kRoomy = 110;    // columns from which the number of answers is shown
constexpr std::size_t kFewValues = 3;  // where fewer fit with their trends, values go before trends

/// Where everything stands in a line of this width.
struct Plan {
  std::size_t name = 4;
  std::size_t status = kStatusWidth;
  bool age = true;
  bool read = false;  ///< age of the parameters' values
  bool answers = false;
  std::size_t trend = kLeastTrend;  ///< 0: no trends
  std::vector<unsigned> values;     ///< those that fit, the chosen one among them
  std::size_t left_of = 0;          ///< values further left
  std::size_t right_of = 0;
};

/// The status word, and its faults in words.
std::string status_cell(const LiveSlave& slave) {
  if (!slave.status_word) return "-";
  return fmt::format("0x{:04X}{}{}", *slave.status_word, slave.fault.empty() ? "" : " ", slave.fault);
}

bool is_old(const LiveSlave& slave) {
  return !slave.age_ms || *slave.age_ms > kOld;
}

/// Ages are to be seen when the table is sorted by them, or when one is marked.
bool age_matters(const LiveModel& model, const ViewState& state) {
  return state.sort == SortBy::age || std::any_of(model.slaves().begin(), model.slaves().end(), is_old);
}

/// Characters of a value with its trend.
std::size_t value_width(const Plan& plan) {
  return kValueWidth + (plan.trend == 0 ? 0 : 1 + plan.trend);
}

std::size_t fixed_width(const Plan& plan) {
  return kNumberWidth + kGap + plan.name + kGap + kStateWidth + kGap + plan.status +
         (plan.age ? kGap + kAgeWidth : 0) + (plan.read ? kGap + kAgeWidth : 0) +
         (plan.answers ? kGap + kAnswersWidth : 0);
}

Plan make_plan(const LiveModel& model, const ViewState& state, std::size_t columns) {
  Plan plan;
  plan.answers = columns >= kRoomy;
  const std::size_t longest_name = columns >= kRoomy ? 20 : 12;
  const std::size_t widest_status = columns >= kRoomy ? 40 : 26;
  for (const LiveSlave& slave : model.slaves()) {
    plan.name = std::clamp(display_width(slave.name), plan.name, longest_name);
    plan.status = std::clamp(display_width(status_cell(slave)), plan.status, widest_status);
  }
  const std::vector<unsigned> values = shown_values(model);
  plan.read = !values.empty() && values.front() >= kSlaveValues;
  const auto room_now = [&] { return columns - std::min(columns, fixed_width(plan)); };
  std::size_t room = room_now();
  std::size_t least = kGap + kValueWidth + 1 + kLeastTrend;
  if (room / least < std::min(kFewValues, values.size())) {
    least = kGap + kValueWidth;
    plan.age = columns >= kRoomy || room / least >= values.size() || age_matters(model, state);
    room = room_now();
  }
  const std::size_t fitting = std::min(room / least, values.size());
  if (fitting == 0) return plan;
  const auto found = std::find(values.begin(), values.end(), state.value);
  const auto chosen = found == values.end() ? 0 : static_cast<std::size_t>(found - values.begin());
  plan.left_of = chosen < fitting ? 0 : chosen - fitting + 1;
  plan.right_of = values.size() - fitting - plan.left_of;
  const auto first = values.begin() + static_cast<std::ptrdiff_t>(plan.left_of);
  plan.values.assign(first, first + static_cast<std::ptrdiff_t>(fitting));
  const std::size_t spare = room / fitting - kGap - kValueWidth;
  plan.trend = spare > kLeastTrend ? std::min(spare - 1, kMostTrend) : 0;
  return plan;
}

std::string heading_text(const LiveModel& model, const ViewState& state, unsigned value) {
  const ValueHeading heading = value_heading(model, value);
  const std::string name = heading.name.empty() ? fmt::format("value {}", value) : heading.name;
  if (state.raw) return name + " raw";
  return heading.unit.empty() ? name : name + " " + heading.unit;
}

/// A heading, and an arrow when the table is sorted by it.
void add_heading(StyledLine& line, const ViewState& state, std::optional<SortBy> by, std::string_view text,
                 std::size_t width, bool right, bool chosen = false) {
  const bool sorted = by && *by == state.sort && (*by != SortBy::value || chosen);
  const std::string marked =
      sorted ? std::string(text) + (state.descending ? " v" : " ^") : std::string(text);
  line.add(
      fitted(sorted && display_width(marked) > width ? shortened(text, width - 1) + marked.back() : marked,
             width, right),
      sorted || chosen ? Style::chosen : Style::heading);
}

StyledLine heading_line(const LiveModel& model, const ViewState& state, const Plan& plan) {
  const std::string gap(kGap, ' ');
  StyledLine line;
  add_heading(line, state, SortBy::number, "NO", kNumberWidth, true);
  line.add(gap, Style::heading);
  add_heading(line, state, SortBy::name, "NAME", plan.name, false);
  line.add(gap, Style::heading);
  add_heading(line, state, SortBy::state, "STATE", kStateWidth, false);
  line.add(gap, Style::heading);
  add_heading(line, state, std::nullopt, "STATUS", plan.status, false);
  if (plan.age) {
    line.add(gap, Style::heading);
    add_heading(line, state, SortBy::age, "AGE ms", kAgeWidth, true);
  }
  if (plan.read) {
    line.add(gap, Style::heading);
    add_heading(line, state, std::nullopt, "READ ms", kAgeWidth, true);
  }
  if (plan.answers) {
    line.add(gap, Style::heading);
    add_heading(line, state, std::nullopt, "ANSWERS", kAnswersWidth, true);
  }
  for (const unsigned value : plan.values) {
    const std::string text = heading_text(model, state, value);
    const std::size_t marked =
        display_width(text) + (state.sort == SortBy::value && value == state.value ? 2 : 0);
    // Over the numbers where it fits there, else over the trend too.
    const std::size_t width = marked <= kValueWidth ? kValueWidth : value_width(plan);
    line.add(gap, Style::heading);
    add_heading(line, state, SortBy::value, text, width, marked <= kValueWidth, value == state.value);
    line.add(std::string(value_width(plan) - width, ' '), Style::heading);
  }
  return line;
}

Style state_style(const LiveSlave& slave) {
  if (slave.state == "released") return Style::good;
  return slave.state == "lost" || slave.state == "held" ? Style::bad : Style::warning;
}

std::string value_text(const LiveValue& value, const ViewState& state, bool with_unit) {
  if (!value.scaled) return "-";
  if (state.raw) return fmt::format("{}", value.raw);
  // As many digits as stand still at 65536 increments a revolution, and no more than fit.
  std::string text = fmt::format("{:.7g}", *value.scaled);
  if (with_unit && !value.unit.empty()) text += " " + value.unit;
  return value.words.empty() ? text : text + ": " + value.words;
}

StyledLine slave_line(const LiveModel& model, const LiveSlave& slave, const ViewState& state,
                      const Plan& plan, Symbols symbols) {
  const std::string gap(kGap, ' ');
  StyledLine line;
  line.highlighted = state.selected >= 0 && static_cast<unsigned>(state.selected) == slave.number;
  line.add(fitted(fmt::format("{}", slave.number), kNumberWidth, true)).add(gap);
  line.add(fitted(slave.name, plan.name), Style::strong).add(gap);
  line.add(fitted(slave.state, kStateWidth), state_style(slave)).add(gap);
  line.add(fitted(status_cell(slave), plan.status), slave.fault.empty() ? Style::plain : Style::bad);
  if (plan.age)
    line.add(gap).add(fitted(slave.age_ms ? fmt::format("{}", *slave.age_ms) : "-", kAgeWidth, true),
                      is_old(slave) ? Style::warning : Style::plain);
  if (plan.read)
    line.add(gap).add(fitted(slave.read_ms ? fmt::format("{}", *slave.read_ms) : "-", kAgeWidth, true),
                      slave.read_failed ? Style::warning : Style::plain);
  if (plan.answers) line.add(gap).add(fitted(fmt::format("{}", slave.answers), kAnswersWidth, true));
  for (const unsigned i : plan.values) {
    const LiveValue& value = slave.values[i];
    const bool own_unit = !value_heading(model, i).agreed;
    line.add(gap).add(fitted(value_text(value, state, own_unit), kValueWidth, true));
    if (plan.trend == 0) continue;
    line.add(" ").add(fitted(trend_line(value.trend.last(plan.trend), plan.trend, symbols), plan.trend),
                      Style::trend);
  }
  return line;
}

/// First of `count` rows when `page` fit and the row `chosen` is to be seen, in the middle where it can be.
std::size_t first_row(std::size_t count, std::size_t page, std::size_t chosen) {
  if (count <= page) return 0;
  return std::min(chosen - std::min(chosen, page / 2), count - page);
}

/// What lies outside the screen; empty when nothing does.
std::string outside_text(const Plan& plan, std::size_t first, std::size_t shown, std::size_t count) {
  std::string text;
  if (shown < count) text = fmt::format("slaves {} to {} of {}", first + 1, first + shown, count);
  if (plan.left_of + plan.right_of > 0)
    text += fmt::format("{}values further away: {} (<- ->)", text.empty() ? "" : "   ",
                        plan.left_of + plan.right_of);
  return text;
}

}  // namespace

std::string trend_line(const std::vector<std::optional<double>>& points, std::size_t width, Symbols symbols) {
  const std::size_t levels = symbols == Symbols::unicode ? kUnicodeLevels.size() : kAsciiLevels.size();
  std::optional<double> least;
  std::optional<double> most;
  const std::size_t first = points.size() - std::min(points.size(), width);
  for (std::size_t i = first; i < points.size(); ++i) {
    if (!points[i] || !std::isfinite(*points[i])) continue;
    least = std::min(least.value_or(*points[i]), *points[i]);
    most = std::max(most.value_or(*points[i]), *points[i]);
  }
  // New points come in on the right.
  std::string out(width - std::min(width, points.size()), ' ');
  for (std::size_t i = first; i < points.size(); ++i) {
    if (!points[i] || !std::isfinite(*points[i])) {
      out += ' ';
      continue;
    }
    const double span = *most - *least;
    const double share = span > 0 ? (*points[i] - *least) / span : 0.0;
    const auto level = std::min(static_cast<std::size_t>(share * static_cast<double>(levels)), levels - 1);
    out += symbols == Symbols::unicode ? kUnicodeLevels[level] : kAsciiLevels[level];
  }
  return out;
}

std::vector<StyledLine> table_lines(const LiveModel& model, const ViewState& state, std::size_t columns,
                                    std::size_t rows, Symbols symbols) {
  const Plan plan = make_plan(model, state, columns);
  const auto slaves = shown_slaves(model, state);
  std::vector<StyledLine> lines{
      heading_line(model, state, plan).pad_to(columns, Style::heading).cut(columns)};
  // The last line tells what does not fit.
  const bool tells = slaves.size() > rows || plan.left_of + plan.right_of > 0;
  const std::size_t page = rows - (tells && rows > 1 ? 1 : 0);
  const auto chosen = std::find_if(slaves.begin(), slaves.end(), [&state](const LiveSlave* slave) {
    return state.selected >= 0 && slave->number == static_cast<unsigned>(state.selected);
  });
  const std::size_t first =
      chosen == slaves.end()
          ? 0
          : first_row(slaves.size(), page, static_cast<std::size_t>(chosen - slaves.begin()));
  const std::size_t shown = std::min(page, slaves.size() - first);
  for (std::size_t i = first; i < first + shown; ++i)
    lines.push_back(slave_line(model, *slaves[i], state, plan, symbols).pad_to(columns).cut(columns));
  if (slaves.empty())
    lines.push_back(StyledLine{}.add(
        "     no slave " + std::string(state.filter.empty() ? "is configured" : "passes the filter"),
        Style::dim));
  lines.resize(rows + 1);
  if (tells && rows > 1)
    lines.back() =
        StyledLine{}.add("     " + outside_text(plan, first, shown, slaves.size()), Style::dim).cut(columns);
  return lines;
}

std::string live_help() {
  return explanation(
      "Full screen",
      {{"NO, NAME", "the slave's number and configured name"},
       {"STATE", "what the master makes of it, as in `slaves`"},
       {"STATUS", "status word of its last answer, and the faults in it by its profile; - = none yet"},
       {"AGE ms",
        "time since its newest actual value telegram; - = none yet, marked when over 1 s; a narrow "
        "screen has it only then"},
       {"READ ms",
        "with --parameter: time since the oldest of its parameters' values was read, marked when the newest "
        "read of one failed; - = none yet"},
       {"ANSWERS", "its answers on the command channel since the daemon started; on wide screens"},
       {"values",
        "each mapped value, and each parameter, in the unit of its heading, and how it went at the last looks, from the least to "
        "the greatest value of that time"}});
}

}  // namespace cansync::cli
