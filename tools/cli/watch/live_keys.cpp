#include <algorithm>
#include <array>

#include "cli/watch/live_view.h"

namespace cansync::cli {
namespace {

constexpr std::size_t kLongestFilter = 64;  // bytes
constexpr std::array<SortBy, 5> kSortOrder{SortBy::number, SortBy::name, SortBy::state, SortBy::age,
                                           SortBy::value};

void drop_last_character(std::string& text) {
  while (!text.empty() && (static_cast<unsigned char>(text.back()) & 0xC0u) == 0x80u) text.pop_back();
  if (!text.empty()) text.pop_back();
}

void type(ViewState& state, Key key) {
  switch (key.kind) {
    case Key::Kind::character:
      if (static_cast<unsigned char>(key.character) >= 0x20 && state.filter.size() < kLongestFilter)
        state.filter += key.character;
      break;
    case Key::Kind::backspace:
      drop_last_character(state.filter);
      break;
    case Key::Kind::enter:
      state.typing_filter = false;
      break;
    case Key::Kind::escape:
      state.typing_filter = false;
      state.filter.clear();
      break;
    default:
      break;
  }
}

/// Selects the slave `by` rows further down, within the table.
void move(ViewState& state, const ViewFacts& facts, std::ptrdiff_t by) {
  if (facts.slaves.empty()) return;
  const auto found =
      std::find(facts.slaves.begin(), facts.slaves.end(), static_cast<unsigned>(state.selected));
  const bool known = state.selected >= 0 && found != facts.slaves.end();
  const auto last = static_cast<std::ptrdiff_t>(facts.slaves.size()) - 1;
  // From nothing one step down is the first row.
  const std::ptrdiff_t row = known ? found - facts.slaves.begin() + by : by - 1;
  state.selected =
      static_cast<int>(facts.slaves[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(row, 0, last))]);
}

/// Chooses the value one column further to the right or left, around the ends.
void choose_value(ViewState& state, const ViewFacts& facts, std::ptrdiff_t by) {
  if (facts.values.empty()) return;
  const auto count = static_cast<std::ptrdiff_t>(facts.values.size());
  const auto found = std::find(facts.values.begin(), facts.values.end(), state.value);
  const std::ptrdiff_t at = found == facts.values.end() ? 0 : found - facts.values.begin();
  state.value = facts.values[static_cast<std::size_t>((at + by + count) % count)];
}

void next_sort(ViewState& state) {
  const auto at = std::find(kSortOrder.begin(), kSortOrder.end(), state.sort);
  state.sort = at + 1 == kSortOrder.end() ? kSortOrder.front() : *(at + 1);
}

void letter(ViewState& state, char character) {
  switch (character) {
    case 'q':
      state.quit = true;
      break;
    case 's':
      next_sort(state);
      break;
    case 'v':
      state.sort = SortBy::value;
      break;
    case 'o':
      state.descending = !state.descending;
      break;
    case '/':
      state.typing_filter = true;
      break;
    case 'p':
    case ' ':
      state.paused = !state.paused;
      break;
    case 'r':
      state.raw = !state.raw;
      break;
    case '?':
    case 'h':
      state.help = true;
      break;
    case 'L' - '@':  // Ctrl-L
      state.redraw = true;
      break;
    default:
      break;
  }
}

void command(ViewState& state, Key key, const ViewFacts& facts) {
  const auto page = static_cast<std::ptrdiff_t>(std::max<std::size_t>(facts.page, 2) - 1);
  const auto all = static_cast<std::ptrdiff_t>(facts.slaves.size());
  switch (key.kind) {
    case Key::Kind::character:
      return letter(state, key.character);
    case Key::Kind::up:
      return move(state, facts, -1);
    case Key::Kind::down:
      return move(state, facts, 1);
    case Key::Kind::page_up:
      return move(state, facts, -page);
    case Key::Kind::page_down:
      return move(state, facts, page);
    case Key::Kind::home:
      return move(state, facts, -all);
    case Key::Kind::end:
      return move(state, facts, all);
    case Key::Kind::left:
      return choose_value(state, facts, -1);
    case Key::Kind::right:
      return choose_value(state, facts, 1);
    case Key::Kind::escape:
      if (state.filter.empty()) state.selected = -1;
      state.filter.clear();
      break;
    default:
      break;
  }
}

}  // namespace

ViewState after_key(ViewState state, Key key, const ViewFacts& facts) {
  if (state.help) {
    state.help = false;
    state.quit = key.kind == Key::Kind::character && key.character == 'q';
  } else if (state.typing_filter) {
    type(state, key);
  } else {
    command(state, key, facts);
  }
  return state;
}

}  // namespace cansync::cli
