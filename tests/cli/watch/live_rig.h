#pragma once

#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "cli/watch/live_layout.h"

namespace cansync::cli {

/// Puts a text into a member of the IDL's structs.
template <std::size_t N>
void put(char (&to)[N], const std::string& text) {
  std::snprintf(to, N, "%s", text.c_str());
}

inline constexpr std::int64_t kNoon = std::int64_t{12 * 3600} * 1'000'000'000;  // 1970-01-01 12:00:00 UTC

/// A line of slaves with a position (value 0, mm) and a torque (value 1, %) for tests of the live view.
class LiveRig {
 public:
  explicit LiveRig(const std::vector<std::string>& names) {
    status.slaves_configured = (1u << names.size()) - 1;
    status.slaves_synchronized = status.slaves_configured;
    status.slaves_released = status.slaves_configured;
    put(status.state, "active");
    for (std::size_t i = 0; i < names.size(); ++i)
      rows.push_back(row(static_cast<std::uint8_t>(i), names[i]));
  }

  /// One look: every slave's position is `position` + its number.
  void look(double position) {
    for (WatchRow& row : rows) {
      row.values->scaled[0] = position + row.status.slave;
      row.values->raw[0] =
          static_cast<std::uint32_t>(static_cast<std::int64_t>(row.values->scaled[0] * 1000));
    }
    now += 500'000'000;
    model.look(facts, status, rows, now);
  }

  /// The screen's lines as text, without spaces at their ends.
  std::vector<std::string> screen(const ViewState& state, ScreenSize size,
                                  Symbols symbols = Symbols::unicode) const {
    std::vector<std::string> out;
    for (const StyledLine& line : live_lines(model, state, size, symbols)) {
      std::string text = line.text();
      text.erase(text.find_last_not_of(' ') + 1);
      out.push_back(text);
    }
    return out;
  }

  LineFacts facts = {"press", 1'000'000, 1'000'000};
  client::MasterStatus status = {};
  std::vector<WatchRow> rows;
  LiveModel model;
  std::int64_t now = kNoon;

 private:
  static WatchRow row(std::uint8_t number, const std::string& name) {
    WatchRow row;
    row.status.slave = number;
    put(row.status.name, name);
    put(row.status.state, "released");
    row.status.responds = true;
    row.status.status_known = true;
    row.status.status_word = 0x8007;
    row.status.answers = 10u + number;
    // Register bytes: low and high word of values 0 and 1.
    const std::uint8_t mapping[] = {0x01, 0x03, 0x05, 0x07};
    for (std::size_t i = 0; i < 4; ++i) row.status.actual_mapping[i] = mapping[i];
    put(row.status.actual_value[0].name, "position");
    put(row.status.actual_value[0].unit_symbol, "mm");
    put(row.status.actual_value[1].name, "torque");
    put(row.status.actual_value[1].unit_symbol, "%");
    row.values = client::ActualValues{};
    row.values->receive_time = kNoon;
    row.values->scaled[1] = 2.5;
    row.values->raw[1] = 25;
    row.shown = 0x03;
    return row;
  }
};

}  // namespace cansync::cli
