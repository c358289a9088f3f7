#include "cli/watch/live_layout.h"

#include <fmt/format.h>

#include <algorithm>

#include "cli/base/session.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

constexpr std::size_t kHeaderLines = 4;   // title, timing, load, remark
constexpr std::uint32_t kHighLoad = 700;  // permille
constexpr std::uint32_t kFullLoad = 900;

/// Lines for events by the height of the screen, without their heading.
std::size_t event_rows(std::size_t rows) {
  if (rows >= 30) return 6;
  if (rows >= 22) return 4;
  return rows >= 16 ? 2 : 1;
}

/// Rows of the table without its heading.
std::size_t table_rows(std::size_t rows) {
  return rows - kHeaderLines - 1 - (1 + event_rows(rows)) - 1;
}

StyledLine title_line(const LiveModel& model, const ViewState& state, std::size_t columns) {
  const LiveMaster& master = model.master();
  const std::string now = time_text(model.now(), false).substr(0, 8);
  const std::string right = (state.paused ? "PAUSED at " : "") + now + " ";
  const std::size_t room = columns - std::min(columns, display_width(right) + 1);
  std::string left =
      fmt::format(" cansync  bus {}: {}   slaves {}: {} synchronized, {} released", master.line.bus,
                  master.state, master.configured, master.synchronized, master.released);
  if (display_width(left) > room)
    left = fmt::format(" {}: {}   {} released", master.line.bus, master.state,
                       text::counted_of(master.released, master.configured, "slave"));
  StyledLine line;
  line.add(shortened(left, room), Style::bar);
  return line.pad_to(columns - std::min(columns, display_width(right)), Style::bar)
      .add(right, state.paused ? Style::chosen : Style::bar);
}

std::string bound_text(const TimingReport& report, double percent) {
  const auto bound = percentile_us(report.histogram, percent);
  return bound ? fmt::format("<{} us", *bound) : ">16 ms";
}

StyledLine timing_line(const LiveModel& model, std::size_t columns) {
  StyledLine line;
  line.add(fmt::format(" SYNC {:.3g} ms", static_cast<double>(model.master().line.interval_length) / 1e6),
           Style::strong);
  if (!model.timing()) return line.add("  no timing figures yet", Style::dim);
  const TimingReport& report = *model.timing();
  std::uint64_t late = 0;
  std::uint64_t left_out = 0;
  for (const SlotReport& slot : report.slots) {
    late += slot.late;
    left_out += slot.left_out.value_or(0);
  }
  // The counts first; of the rest as much as fits, whole words each.
  const auto count = [&line](std::string_view name, std::uint64_t number) {
    line.add(fmt::format("  {} ", name), Style::dim);
    line.add(fmt::format("{}", number), number > 0 ? Style::warning : Style::good);
  };
  count("missed", report.missed_syncs);
  count("late", late);
  count("left out", left_out);
  const std::string since =
      report.seconds ? fmt::format("  (last {} s)", *report.seconds) : "  (since the start)";
  const std::string most =
      fmt::format("  wake-up max {:.1f} us", static_cast<double>(report.lateness_maximum) / 1000.0);
  const std::string high = "  p99.9 " + bound_text(report, 99.9);
  const std::string middle = "  p50 " + bound_text(report, 50);
  std::size_t room = columns - std::min(columns, line.width());
  const auto fits = [&room](const std::string& text) {
    const bool enough = room >= text.size();
    room = enough ? room - text.size() : 0;
    return enough;
  };
  if (!fits(most)) return line.cut(columns);
  line.add(most);
  const bool says_since = fits(since);
  if (says_since && fits(high)) {
    line.add(high);
    if (fits(middle)) line.add(middle);
  }
  if (says_since) line.add(since, Style::dim);
  return line.cut(columns);
}

StyledLine load_line(const LiveModel& model, std::size_t columns, Symbols symbols) {
  StyledLine line;
  line.add(" Bus load ", Style::strong);
  if (!model.timing()) return line.add(" -", Style::dim);
  const std::uint32_t load = model.timing()->bus_load;
  const Style style = load >= kFullLoad ? Style::bad : load >= kHighLoad ? Style::warning : Style::good;
  const std::string numbers =
      fmt::format(" {:.1f} % of {} kbit/s", load / 10.0, model.master().line.bit_rate / 1000);
  const std::size_t width = std::min<std::size_t>(columns - line.width() - numbers.size() - 3, 60);
  return line.add("[").add(load_bar(load, width, symbols), style).add("]").add(numbers);
}

StyledLine remark_line(const LiveModel& model, const ViewState& state, std::size_t columns) {
  StyledLine line;
  if (!model.daemon_present()) {
    line.add(" The daemon has gone; looking for it (" + model.place() + "). What is shown is old.",
             Style::bad);
  } else if (state.typing_filter) {
    line.add(" Filter, by numbers or names (Enter keeps it, Esc drops it): ", Style::strong);
    line.add(state.filter).add("_", Style::chosen);
  } else {
    line.add(
        fmt::format(" sorted by {}{}", sort_text(model, state), state.descending ? ", from the top" : ""),
        Style::dim);
    if (!state.filter.empty())
      line.add(fmt::format("   only {} ", state.filter), Style::chosen)
          .add(" " + text::counted_of(shown_slaves(model, state).size(), model.slaves().size(), "slave"),
               Style::dim);
    if (state.raw) line.add("   numbers as on the bus", Style::dim);
  }
  return line.cut(columns);
}

Style severity_style(gateway_EventSeverity severity) {
  if (severity == gateway_SEVERITY_ERROR) return Style::bad;
  return severity == gateway_SEVERITY_WARNING ? Style::warning : Style::plain;
}

std::vector<StyledLine> event_lines(const LiveModel& model, std::size_t columns, std::size_t rows) {
  std::vector<StyledLine> lines{StyledLine{}.add(fitted(" LAST EVENTS", columns), Style::heading)};
  const std::size_t shown = std::min(rows, model.events().size());
  const std::size_t code_width = columns >= 100 ? 24 : 16;
  for (std::size_t i = 0; i < shown; ++i) {
    const LiveEvent& event = model.events()[model.events().size() - 1 - i];  // newest on top
    lines.push_back(StyledLine{}
                        .add(" " + time_text(event.time, false).substr(0, 8) + "  ", Style::dim)
                        .add(fitted(event.code, code_width) + "  ", severity_style(event.severity))
                        .add(event.text)
                        .cut(columns));
  }
  if (shown == 0) lines.push_back(StyledLine{}.add(" none", Style::dim));
  lines.resize(rows + 1);
  return lines;
}

StyledLine key_line(std::size_t columns) {
  StyledLine line;
  const auto key = [&line, columns](std::string_view name, std::string_view what) {
    if (line.width() + name.size() + what.size() + 3 > columns) return;
    line.add(fmt::format(" {}", name), Style::chosen).add(fmt::format(" {} ", what), Style::bar);
  };
  key("q", "quit");
  key("?", "help");
  key("s", "sort");
  key("o", "order");
  key("/", "filter");
  key("p", "pause");
  key("r", "raw");
  key("<-->", "value");
  key("up/down", "slave");
  return line.cut(columns).pad_to(columns, Style::bar);
}

std::vector<StyledLine> too_small(ScreenSize size) {
  std::vector<StyledLine> lines{
      StyledLine{}.add(
          fmt::format("At least {} x {} characters are needed,", kLeastScreen.columns, kLeastScreen.rows)),
      StyledLine{}.add(fmt::format("this terminal has {} x {}.", size.columns, size.rows)),
      StyledLine{}.add("Make it larger, or press q.")};
  for (StyledLine& line : lines) line.cut(size.columns);
  lines.resize(std::min(lines.size(), size.rows));
  return lines;
}

void to_ascii(std::vector<StyledLine>& lines) {
  for (StyledLine& line : lines)
    for (Span& span : line.spans) span.text = ascii(span.text);
}

}  // namespace

std::string load_bar(std::uint32_t permille, std::size_t width, Symbols symbols) {
  const std::size_t full = width * std::min(permille, 1000u) / 1000;
  std::string out;
  for (std::size_t i = 0; i < width; ++i)
    out += symbols == Symbols::unicode ? (i < full ? "█" : "░") : (i < full ? "#" : ".");
  return out;
}

std::vector<StyledLine> header_lines(const LiveModel& model, const ViewState& state, ScreenSize size,
                                     Symbols symbols) {
  return {title_line(model, state, size.columns), timing_line(model, size.columns),
          load_line(model, size.columns, symbols), remark_line(model, state, size.columns)};
}

std::vector<StyledLine> live_lines(const LiveModel& model, const ViewState& state, ScreenSize size,
                                   Symbols symbols) {
  if (size.columns < kLeastScreen.columns || size.rows < kLeastScreen.rows) return too_small(size);
  std::vector<StyledLine> lines = state.help ? std::vector<StyledLine>{title_line(model, state, size.columns)}
                                             : header_lines(model, state, size, symbols);
  const auto append = [&lines](std::vector<StyledLine> more) {
    for (StyledLine& line : more) lines.push_back(std::move(line));
  };
  if (state.help) {
    append(help_lines());
    for (StyledLine& line : lines) line.cut(size.columns);
    lines.resize(size.rows - 1);
  } else {
    append(table_lines(model, state, size.columns, table_rows(size.rows), symbols));
    append(event_lines(model, size.columns, event_rows(size.rows)));
  }
  lines.push_back(key_line(size.columns));
  if (symbols == Symbols::ascii) to_ascii(lines);
  return lines;
}

ViewFacts view_facts(const LiveModel& model, const ViewState& state, ScreenSize size) {
  ViewFacts facts;
  for (const LiveSlave* slave : shown_slaves(model, state)) facts.slaves.push_back(slave->number);
  facts.values = shown_values(model);
  facts.page = size.rows < kLeastScreen.rows ? 1 : table_rows(size.rows);
  return facts;
}

std::vector<StyledLine> help_lines() {
  const auto key = [](std::string_view name, std::string_view what) {
    return StyledLine{}.add("   " + fitted(name, 16), Style::strong).add(std::string(what));
  };
  return {
      StyledLine{}.add(" Keys (any key closes this page)", Style::heading),
      key("q, Ctrl-C", "quit"),
      key("s", "sort by the next: number, name, state, age, chosen value"),
      key("v, o", "sort by the chosen value; turn the order around"),
      key("Left, Right", "choose a value"),
      key("/", "filter: numbers (1,3,5-9) or parts of names; Esc ends it"),
      key("p, Space", "pause: the screen stands still, the line goes on"),
      key("r", "numbers as on the bus, or in their units"),
      key("Up, Down", "select a slave; also PgUp, PgDn, Home, End; Esc ends it"),
      key("Ctrl-L", "draw the screen anew"),
      StyledLine{},
      StyledLine{}.add(" Trends go from the least to the greatest value they show, one point a look."),
      StyledLine{}.add(
          " wake-up: how late the realtime thread woke up; late: telegrams. An age over 1 s is marked."),
  };
}

}  // namespace cansync::cli
