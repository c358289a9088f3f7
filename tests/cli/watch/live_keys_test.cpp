#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "live_rig.h"

namespace cansync::cli {
namespace {

using Kind = Key::Kind;

/// Presses keys one after another.
class LiveKeys : public testing::Test {
 protected:
  void press(Kind kind) { state = after_key(state, {kind}, view_facts(rig.model, state, {80, 24})); }
  void type(const std::string& text) {
    for (const char c : text)
      state = after_key(state, {Kind::character, c}, view_facts(rig.model, state, {80, 24}));
  }
  std::vector<unsigned> order() const { return view_facts(rig.model, state, {80, 24}).slaves; }

  LiveRig rig{{"unwinder", "Dancer", "infeed", "dryer"}};
  ViewState state;
};

TEST_F(LiveKeys, SortGoesThroughEveryOrder) {
  rig.rows[0].values->receive_time -= 5'000'000'000;
  rig.rows[3].values.reset();
  put(rig.rows[2].status.state, "lost");
  for (WatchRow& row : rig.rows)
    if (row.values) row.values->scaled[0] = -row.status.slave;
  rig.rows[3].shown = 0;
  rig.model.look(rig.facts, rig.status, rig.rows, kNoon);
  EXPECT_EQ(order(), (std::vector<unsigned>{0, 1, 2, 3}));
  type("s");
  EXPECT_EQ(order(), (std::vector<unsigned>{1, 3, 2, 0})) << "by name";
  type("s");
  EXPECT_EQ(order(), (std::vector<unsigned>{2, 0, 1, 3})) << "by state";
  type("s");
  EXPECT_EQ(order(), (std::vector<unsigned>{1, 2, 0, 3})) << "by age, without one last";
  type("o");
  EXPECT_EQ(order(), (std::vector<unsigned>{0, 1, 2, 3})) << "the oldest first, without one still last";
  type("os");
  EXPECT_EQ(order(), (std::vector<unsigned>{2, 1, 0, 3})) << "by the chosen value";
  EXPECT_EQ(sort_text(rig.model, state), "position");
  type("s");
  EXPECT_EQ(state.sort, SortBy::number);
  type("v");
  EXPECT_EQ(state.sort, SortBy::value);
}

TEST_F(LiveKeys, FilterTakesNumbersRangesAndPartsOfNames) {
  rig.look(0);
  type("/1,3");
  EXPECT_EQ(order(), (std::vector<unsigned>{1, 3}));
  press(Kind::escape);
  EXPECT_EQ(order().size(), 4u);
  EXPECT_FALSE(state.typing_filter);
  type("/2-");
  EXPECT_EQ(order(), (std::vector<unsigned>{2})) << "half typed";
  type("9");
  EXPECT_EQ(order(), (std::vector<unsigned>{2, 3}));
  press(Kind::backspace);
  press(Kind::backspace);
  press(Kind::backspace);
  type("d, UNW");
  EXPECT_EQ(order(), (std::vector<unsigned>{0, 1, 2, 3}));
  press(Kind::enter);
  EXPECT_FALSE(state.typing_filter);
  type("q");
  EXPECT_TRUE(state.quit) << "after Enter keys are commands again";
}

TEST_F(LiveKeys, WhileTypingLettersAreText) {
  rig.look(0);
  type("/q?p°");
  EXPECT_EQ(state.filter, "q?p°");
  EXPECT_FALSE(state.quit || state.help || state.paused);
  press(Kind::backspace);
  EXPECT_EQ(state.filter, "q?p") << "a whole character goes";
  type(std::string(500, 'x'));
  EXPECT_EQ(state.filter.size(), 64u);
  EXPECT_TRUE(order().empty());
  press(Kind::down);
  EXPECT_EQ(state.selected, -1);
}

TEST_F(LiveKeys, SelectionMovesWithinTheTable) {
  rig.look(0);
  press(Kind::down);
  EXPECT_EQ(state.selected, 0) << "the first key selects the first";
  press(Kind::up);
  EXPECT_EQ(state.selected, 0);
  press(Kind::page_down);
  EXPECT_EQ(state.selected, 3);
  press(Kind::home);
  EXPECT_EQ(state.selected, 0);
  press(Kind::end);
  EXPECT_EQ(state.selected, 3);
  press(Kind::page_up);
  EXPECT_EQ(state.selected, 0);
  press(Kind::down);
  type("o");
  press(Kind::down);
  EXPECT_EQ(state.selected, 0) << "from slave 1 downwards when the order is turned around";
  press(Kind::escape);
  EXPECT_EQ(state.selected, -1);
}

TEST_F(LiveKeys, ValuesAreChosenAround) {
  rig.look(0);
  press(Kind::right);
  EXPECT_EQ(state.value, 1u);
  press(Kind::right);
  EXPECT_EQ(state.value, 0u);
  press(Kind::left);
  EXPECT_EQ(state.value, 1u);
}

TEST_F(LiveKeys, SwitchesTurnOnAndOff) {
  rig.look(0);
  type("pr");
  EXPECT_TRUE(state.paused && state.raw);
  type(" r");
  EXPECT_FALSE(state.paused || state.raw);
  type("?");
  EXPECT_TRUE(state.help);
  type("s");
  EXPECT_FALSE(state.help);
  EXPECT_EQ(state.sort, SortBy::number) << "the key that closes the help does nothing else";
  type("?q");
  EXPECT_TRUE(state.quit);
}

TEST_F(LiveKeys, NoKeyHurtsAnEmptyLine) {
  for (int kind = 0; kind <= static_cast<int>(Kind::backspace); ++kind) press(static_cast<Kind>(kind));
  EXPECT_EQ(state.selected, -1);
  EXPECT_EQ(state.value, 0u);
}

}  // namespace
}  // namespace cansync::cli
