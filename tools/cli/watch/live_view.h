#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "cli/watch/live_model.h"

/// How a person looks at the live view, and what keys change about it. Pure functions; any thread.
namespace cansync::cli {

/// What the table is sorted by.
enum class SortBy : unsigned char { number, name, state, age, value };

struct ViewState {
  SortBy sort = SortBy::number;
  bool descending = false;
  std::string filter;          ///< see `shown_slaves`
  bool typing_filter = false;  ///< keys go into the filter
  bool paused = false;
  bool raw = false;
  bool help = false;
  bool redraw = false;  ///< the screen is to be drawn anew, whatever it showed
  bool quit = false;
  unsigned value = 0;  ///< the chosen value or, from 8, parameter, that may be sorted by
  int selected = -1;   ///< number of the selected slave; -1: none
};

/// One key of the keyboard.
struct Key {
  enum class Kind : unsigned char {
    character,
    up,
    down,
    left,
    right,
    page_up,
    page_down,
    home,
    end,
    enter,
    escape,
    backspace,
  };
  Kind kind = Kind::character;
  char character = '\0';  ///< one byte of UTF-8
};

/// What the table shows now, as far as keys need it.
struct ViewFacts {
  std::vector<unsigned> slaves;  ///< numbers, from the top
  std::vector<unsigned> values;  ///< those that have a column
  std::size_t page = 1;          ///< rows that fit
};

/// The state after a key. Keys that mean nothing change nothing.
ViewState after_key(ViewState state, Key key, const ViewFacts& facts);

/// The slaves that pass the filter, in the order of the table. The filter is a list with commas: a number or
/// a range of numbers (5-9) is a slave's number, anything else a part of its name, in any case; empty: all.
std::vector<const LiveSlave*> shown_slaves(const LiveModel& model, const ViewState& state);

/// The parameters, then the values that any slave has mapped, rising.
std::vector<unsigned> shown_values(const LiveModel& model);

/// "number", "name", ... or the heading of the chosen value.
std::string sort_text(const LiveModel& model, const ViewState& state);

/// Name and unit of a value's column; both empty when the slaves do not agree.
struct ValueHeading {
  std::string name;
  std::string unit;
  bool agreed = false;  ///< else every cell has its own unit
};
ValueHeading value_heading(const LiveModel& model, unsigned value);

}  // namespace cansync::cli
