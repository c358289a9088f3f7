#include "cli/text/table.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace cansync::cli {
namespace {

TEST(Table, AlignsColumns) {
  Table table({{"NAME"}, {"VALUE", Table::Align::right}});
  table.add({"a", "10"});
  table.add({"longer", "1234567"});
  EXPECT_EQ(table.heading(), "NAME      VALUE");
  EXPECT_EQ(table.lines(), (std::vector<std::string>{"a            10", "longer  1234567"}));
}

/// Columns of every kind, and two rows.
Table ranked() {
  constexpr auto right = Table::Align::right;
  Table table({{"NO", right},
               {"NAME"},
               {"ZERO", right, "", 0, 1, true},
               {"LAST", right, "", 0, 3},
               {"COUNT", right, "", 0, 1, true},
               {"NEXT", right, "", 0, 2}});
  table.add({"0", "one", "0", "7", "0", "1"});
  table.add({"1", "other", "0", "8", "2", "3"});
  return table;
}

TEST(Table, KeepsTheColumnsThatMatterMostWhereRoomIsShort) {
  EXPECT_EQ(ranked().fitted_to(0).heading(), "NO  NAME   ZERO  LAST  COUNT  NEXT") << "everything";
  EXPECT_EQ(ranked().fitted_to(80).heading(), "NO  NAME   LAST  COUNT  NEXT") << "but counts that are all 0";
  EXPECT_EQ(ranked().fitted_to(22).heading(), "NO  NAME   COUNT  NEXT") << "the greatest place goes first";
  EXPECT_EQ(ranked().fitted_to(21).heading(), "NO  NAME   COUNT");
  EXPECT_EQ(ranked().fitted_to(5).heading(), "NO  NAME") << "place 0 stays";
  EXPECT_EQ(ranked().fitted_to(22).lines(),
            (std::vector<std::string>{" 0  one        0     1", " 1  other      2     3"}));
  EXPECT_EQ(ranked().columns() - ranked().fitted_to(22).columns(), 2u);
}

TEST(Table, FoldsWhatIsLongWithinTheLastColumn) {
  Table table({{"NAME"}, {"TEXT"}});
  table.add({"a", "several words that go on and on"});
  EXPECT_EQ(table.lines(20),
            (std::vector<std::string>{"a     several words\n      that go on and\n      on"}));
  EXPECT_EQ(table.lines(), (std::vector<std::string>{"a     several words that go on and on"}));
  EXPECT_EQ(folded("averyverylongword b", 2, 6), "averyverylongword\n  b") << "a word is not cut";
  EXPECT_EQ(folded("", 2, 6), "");
}

TEST(Table, CountsCharactersNotBytes) {
  Table table({{"T", Table::Align::right}, {"X"}});
  table.add({"20 °C", "x"});
  table.add({"20 mm", "x"});
  EXPECT_EQ(table.lines(), (std::vector<std::string>{"20 °C  x", "20 mm  x"}));
}

TEST(Table, KeepsItsWidthWhenRowsAreDropped) {
  Table table({{"A"}, {"B"}});
  table.add({"wide cell", "x"});
  table.clear();
  table.add({"a", "x"});
  EXPECT_EQ(table.lines(), std::vector<std::string>{"a          x"});
}

TEST(Table, RefusesMoreCellsThanColumns) {
  Table table({{"A"}});
  EXPECT_THROW(table.add({"1", "2"}), std::logic_error);
}

Table jobs(const std::string& what) {
  Table table({{"JOB", Table::Align::right}, {"WHAT"}, {"WHOSE"}});
  table.add({"7", what, "'press' (cansync, process 4711)"});
  return table;
}

TEST(Table, GivesTheLastCellLinesOfItsOwnWhereFewCharactersAreLeft) {
  EXPECT_EQ(jobs("upload 64 bytes from winder").lines(54),
            (std::vector<std::string>{"  7  upload 64 bytes from winder\n"
                                      "    'press' (cansync, process 4711)"}));
  EXPECT_EQ(jobs("upload 64 bytes from winder").lines(30),
            (std::vector<std::string>{"  7  upload 64 bytes from winder\n"
                                      "    'press' (cansync, process\n"
                                      "    4711)"}));
}

TEST(Table, LeavesAShortLastCellInItsLine) {
  Table table({{"WHAT"}, {"WHOSE"}});
  table.add({"upload 64 bytes from winder", "press"});
  EXPECT_EQ(table.lines(34), (std::vector<std::string>{"upload 64 bytes from winder  press"}));
  EXPECT_EQ(table.lines(33), (std::vector<std::string>{"upload 64 bytes from winder\n    press"}));
}

}  // namespace
}  // namespace cansync::cli
