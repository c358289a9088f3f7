// Every cell of the table.
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <string>
#include <vector>

#include "columns.h"
#include "given_cells.h"
#include "rows.h"

namespace given {
namespace {

const Rows& rows() {
  static const Rows all = all_rows();
  return all;
}

class Given : public testing::TestWithParam<std::string> {};

TEST_P(Given, EachCellIsAsTheTableSays) {
  for (const Cell& cell : kCells) {
    if (cell.row != GetParam() || cell.bus.empty()) continue;
    SCOPED_TRACE(std::string(cell.column));
    const auto row = rows().make(GetParam());
    const Seen seen = let_happen(cell.column, *row);
    EXPECT_EQ(seen.bus, cell.bus);
    EXPECT_EQ(seen.giver, cell.giver);
    EXPECT_EQ(seen.others, cell.others);
  }
}

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const auto& [name, make] : rows().all()) all.push_back(name);
  return all;
}

INSTANTIATE_TEST_SUITE_P(Rows, Given, testing::ValuesIn(names()), [](const auto& one) {
  std::string name = one.param;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
});

/// The table names each row that the tests have, and no other.
TEST(GivenTable, HasTheRowsOfTheTests) {
  for (const Cell& cell : kCells) EXPECT_EQ(rows().all().count(std::string(cell.row)), 1u) << cell.row;
  for (const std::string& name : names()) {
    EXPECT_TRUE(std::any_of(std::begin(kCells), std::end(kCells), [&](const Cell& cell) {
      return cell.row == name;
    })) << name;
  }
}

}  // namespace
}  // namespace given
