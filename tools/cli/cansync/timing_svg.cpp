#include "cli/cansync/timing_svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>

namespace cansync::cli {
namespace {

// All lengths in px. Labels left of the axis, numbers right of it.
constexpr double kWidth = 1400;
constexpr double kAxisLeft = 170;
constexpr double kAxisRight = 920;
constexpr double kNumbers = 945;
constexpr double kLanesTop = 112;
constexpr double kLane = 52;
constexpr std::size_t kLanes = kSlotCount + 1;
constexpr double kLanesBottom = kLanesTop + kLane * static_cast<double>(kLanes);
constexpr double kHeight = kLanesBottom + 140;
/// Narrowest bar: a spread of nothing is still to be seen.
constexpr double kLeastBar = 3;

constexpr std::array<std::string_view, kSlotCount> kWords{"answer to a command", "reference values 0-3",
                                                          "actual values 0-3",   "reference values 4-7",
                                                          "actual values 4-7",   "command"};

constexpr std::string_view kStyle =
    "text{font-family:sans-serif;font-size:14px;fill:#000}.title{font-size:20px;font-weight:bold}.name{font-weight:bold}.small{font-size:12px;fill:#333}.number{font-family:monospace;font-size:13px;text-anchor:end}.tick{font-size:12px;text-anchor:middle}.grid{stroke:#ddd;stroke-width:1}.edge{stroke:#000;stroke-width:1.5;stroke-dasharray:6 "
    "3}.allowed{fill:#eee}.sent{fill:#333}.received{fill:#fff;stroke:#333;stroke-width:1.5}.mean{stroke:#888;stroke-width:2}.planned{fill:#fff;stroke:#000;stroke-width:1.2}.latest{stroke:#000;stroke-width:3}";

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (static_cast<unsigned char>(c) >= 0x20)
      out += c;
  }
  return out;
}

double in_microseconds(std::int64_t nanoseconds) {
  return static_cast<double>(nanoseconds) / 1000.0;
}

/// The drawing under construction.
class Drawing {
 public:
  template <class... Values>
  void add(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Values>(values)...);
    text_ += '\n';
  }
  void words(double x, double y, std::string_view kind, std::string_view text) {
    add(R"(<text x="{:.1f}" y="{:.1f}" class="{}">{}</text>)", x, y, kind, escaped(text));
  }
  void line(double x1, double y1, double x2, double y2, std::string_view kind) {
    add(R"(<line x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}" class="{}"/>)", x1, y1, x2, y2, kind);
  }
  void box(double x, double y, double width, double height, std::string_view kind) {
    add(R"(<rect x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}" class="{}"/>)", x, y, width, height,
        kind);
  }
  /// A triangle that points down to (x, y).
  void triangle(double x, double y) {
    add(R"(<path d="M{:.1f} {:.1f} l-5 -9 l10 0 z" class="planned"/>)", x, y);
  }
  std::string text() && { return std::move(text_); }

 private:
  std::string text_;
};

/// From microseconds after SYNC to the x of the drawing.
class Axis {
 public:
  explicit Axis(const TimingReport& report)
      : end_(in_microseconds(static_cast<std::int64_t>(report.interval_length))) {
    step_ = std::max(end_, 1.0) / 10.0;
    double least = 0;
    double most = end_;
    for (const SlotReport& slot : report.slots) {
      if (slot.count == 0) continue;
      least = std::min(least, in_microseconds(slot.earliest));
      most = std::max(most, in_microseconds(slot.latest));
    }
    // Whole steps, and no more than one interval to either side.
    from_ = std::max(std::floor(least / step_) * step_, -end_);
    to_ = std::min(std::ceil(most / step_ - 1e-9) * step_, 2 * std::max(end_, 1.0));
    to_ = std::max(to_, from_ + step_);
  }
  double x(double time) const {
    return kAxisLeft + (std::clamp(time, from_, to_) - from_) / (to_ - from_) * (kAxisRight - kAxisLeft);
  }
  double from() const { return from_; }
  double to() const { return to_; }
  double step() const { return step_; }
  double end() const { return end_; }

 private:
  double end_;
  double step_ = 1;
  double from_ = 0;
  double to_ = 1;
};

double lane_top(std::size_t lane) {
  return kLanesTop + kLane * static_cast<double>(lane);
}

void draw_spread(Drawing& drawing, const Axis& axis, double top, std::int64_t earliest, std::int64_t mean,
                 std::int64_t latest, bool from_master) {
  const double left = axis.x(in_microseconds(earliest));
  const double width = std::max(axis.x(in_microseconds(latest)) - left, kLeastBar);
  drawing.box(left, top + 16, width, 20, from_master ? "sent" : "received");
  const double middle = axis.x(in_microseconds(mean));
  drawing.line(middle, top + 12, middle, top + 40, "mean");
}

// Right edges of the columns of numbers.
constexpr std::array<double, 7> kColumns{kNumbers + 55,  kNumbers + 125, kNumbers + 195, kNumbers + 265,
                                         kNumbers + 335, kNumbers + 380, kNumbers + 435};

void draw_numbers(Drawing& drawing, double top, const std::array<std::string, 7>& numbers) {
  for (std::size_t i = 0; i < numbers.size(); ++i) drawing.words(kColumns[i], top + 31, "number", numbers[i]);
}

void draw_slot(Drawing& drawing, const Axis& axis, const TimingReport& report, std::size_t index) {
  const SlotReport& slot = report.slots[index];
  const double top = lane_top(index + 1);
  const std::int64_t before = index == 0 ? 0 : report.slots[index - 1].latest_start;
  const double window = axis.x(in_microseconds(before));
  const double latest = axis.x(in_microseconds(slot.latest_start));
  drawing.words(20, top + 23, "name", slot.name);
  drawing.words(20, top + 40, "small", kWords[index]);
  drawing.box(window, top + 6, std::max(latest - window, 0.0), kLane - 12, "allowed");
  drawing.line(latest, top + 6, latest, top + kLane - 6, "latest");
  if (slot.count > 0)
    draw_spread(drawing, axis, top, slot.earliest, slot.mean, slot.latest, slot.from_master);
  if (slot.planned) drawing.triangle(axis.x(in_microseconds(*slot.planned)), top + 15);
  const auto seen = [&slot](std::int64_t time) {
    return slot.count > 0 ? fmt::format("{:.1f}", in_microseconds(time)) : std::string("-");
  };
  draw_numbers(drawing, top,
               {fmt::format("{}", slot.count), seen(slot.earliest), seen(slot.mean), seen(slot.latest),
                fmt::format("{:.1f}", in_microseconds(slot.latest_start)), fmt::format("{}", slot.late),
                slot.left_out ? fmt::format("{}", *slot.left_out) : "-"});
}

void draw_sync(Drawing& drawing, const Axis& axis, const TimingReport& report) {
  const double top = lane_top(0);
  drawing.words(20, top + 23, "name", "SYNC");
  drawing.words(20, top + 40, "small", "wake-up after the edge");
  draw_spread(drawing, axis, top, report.lateness_minimum, report.lateness_mean, report.lateness_maximum,
              true);
  draw_numbers(
      drawing, top,
      {fmt::format("{}", report.intervals), fmt::format("{:.1f}", in_microseconds(report.lateness_minimum)),
       fmt::format("{:.1f}", in_microseconds(report.lateness_mean)),
       fmt::format("{:.1f}", in_microseconds(report.lateness_maximum)), "-", "-",
       fmt::format("{}", report.missed_syncs)});
}

void draw_axis(Drawing& drawing, const Axis& axis) {
  const auto steps = std::lround((axis.to() - axis.from()) / axis.step());
  for (long step = 0; step <= steps; ++step) {
    const double time = axis.from() + static_cast<double>(step) * axis.step();
    const double x = axis.x(time);
    drawing.line(x, kLanesTop, x, kLanesBottom, "grid");
    drawing.words(x, kLanesBottom + 18, "tick", fmt::format("{:.0f}", time));
  }
  for (std::size_t lane = 0; lane <= kLanes; ++lane) {
    drawing.line(20, lane_top(lane), kWidth - 20, lane_top(lane), "grid");
  }
  for (const double edge : {0.0, axis.end()}) {
    drawing.line(axis.x(edge), kLanesTop - 8, axis.x(edge), kLanesBottom + 4, "edge");
    drawing.words(axis.x(edge), kLanesTop - 14, "tick", "SYNC");
  }
  drawing.words((kAxisLeft + kAxisRight) / 2 - 60, kLanesBottom + 38, "small", "time after SYNC in us");
}

void draw_headings(Drawing& drawing, const TimingReport& report, std::string_view date) {
  drawing.words(20, 34, "title",
                fmt::format("CANsync interval on bus {} at {} bit/s", report.bus, report.bit_rate));
  drawing.words(
      20, 58, "small",
      fmt::format("{}; starts of the last {}, counts {}; instants by {}; bus load {:.1f} %", date,
                  report.seconds ? fmt::format("{} s", *report.seconds) : "second",
                  report.seconds ? "of the same time" : "of late and left out since the daemon started",
                  report.timestamp_source.empty() ? "-" : report.timestamp_source, report.bus_load / 10.0));
  constexpr std::array<std::string_view, 7> kHeadings{"seen",    "earliest", "mean",    "latest",
                                                      "allowed", "late",     "left out"};
  for (std::size_t i = 0; i < kHeadings.size(); ++i)
    drawing.add(R"(<text x="{:.1f}" y="{:.1f}" class="small" text-anchor="end">{}</text>)", kColumns[i],
                kLanesTop - 14, kHeadings[i]);
}

void draw_legend(Drawing& drawing) {
  const double top = kLanesBottom + 62;
  const double second = top + 32;
  drawing.box(20, top, 40, 16, "allowed");
  drawing.line(60, top - 3, 60, top + 19, "latest");
  drawing.words(70, top + 13, "small", "slot, up to the latest start allowed by the specification");
  drawing.triangle(40, second + 13);
  drawing.words(70, second + 13, "small", "start the master plans");
  drawing.box(470, top, 40, 16, "sent");
  drawing.words(520, top + 13, "small", "sent by the master, from the earliest to the latest start");
  drawing.box(470, second, 40, 16, "received");
  drawing.words(520, second + 13, "small", "received from the slaves, likewise");
  drawing.line(960, top - 3, 960, top + 19, "mean");
  drawing.words(975, top + 13, "small", "mean start");
  drawing.words(945, second + 13, "small", "Times right of the diagram in us; SYNC: left out = edges missed");
}

}  // namespace

std::string timing_svg(const TimingReport& report, std::string_view date) {
  Drawing drawing;
  drawing.add(R"(<?xml version="1.0" encoding="UTF-8"?>)");
  drawing.add(
      R"(<svg xmlns="http://www.w3.org/2000/svg" width="{0:.0f}" height="{1:.0f}" viewBox="0 0 {0:.0f} {1:.0f}">)",
      kWidth, kHeight);
  drawing.add("<title>CANsync interval on bus {}</title>", escaped(report.bus));
  drawing.add("<style>{}</style>", kStyle);
  drawing.add(R"(<rect x="0" y="0" width="{:.0f}" height="{:.0f}" fill="#fff"/>)", kWidth, kHeight);
  const Axis axis(report);
  draw_headings(drawing, report, date);
  draw_axis(drawing, axis);
  draw_sync(drawing, axis, report);
  for (std::size_t i = 0; i < kSlotCount; ++i) draw_slot(drawing, axis, report, i);
  draw_legend(drawing);
  drawing.add("</svg>");
  return std::move(drawing).text();
}

}  // namespace cansync::cli
