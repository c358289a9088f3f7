// Every (role, state, command) against the table in docs/cansync-protocol.md, which is read here line by
// line.

#include "cansync/settings/mode.h"

#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace cansync {
namespace {

constexpr std::array kStates = {State::start_up,          State::waiting_for_initialisation,
                                State::waiting_for_start, State::setting_up_master,
                                State::setting_up_slave,  State::active_master,
                                State::active_slave};
constexpr std::array kCommands = {ControlCommand::cold_restart,
                                  ControlCommand::handshake,
                                  ControlCommand::take_over_initialisation,
                                  ControlCommand::start_synchronous,
                                  ControlCommand::enable_active,
                                  ControlCommand::reset_can};

// Following state by (state, command); 0 = not allowed. All by register value.
using Table = std::map<std::pair<unsigned, unsigned>, unsigned>;

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> found;
  std::istringstream stream(line);
  std::string cell;
  while (std::getline(stream, cell, '|')) {
    const auto first = cell.find_first_not_of(" `");
    const auto last = cell.find_last_not_of(" `");
    found.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
  }
  if (!found.empty()) found.erase(found.begin());  // before the first bar
  return found;
}

// A cell's register value, or 0 for "no".
unsigned value_of(const std::string& cell) {
  const auto start = cell.find("0x");
  return start == std::string::npos ? 0 : static_cast<unsigned>(std::stoul(cell.substr(start), nullptr, 16));
}

// Rows are states, columns commands; the table follows the marker of its role and ends with an empty line.
Table read_table(const std::string& marker) {
  std::ifstream file(CANSYNC_PROTOCOL_DOC);
  EXPECT_TRUE(file) << CANSYNC_PROTOCOL_DOC;
  std::string line;
  while (std::getline(file, line) && line != marker) {
  }
  EXPECT_TRUE(file) << marker << " is missing";
  Table table;
  std::vector<std::string> header;
  while (std::getline(file, line) && !line.empty()) {
    const auto row = cells(line);
    if (row.empty() || row[0].starts_with("--")) continue;
    if (header.empty()) {
      header = row;
      continue;
    }
    EXPECT_EQ(row.size(), header.size()) << line;
    for (std::size_t i = 1; i < row.size() && i < header.size(); ++i) {
      table[{value_of(row[0]), value_of(header[i])}] = value_of(row[i]);
    }
  }
  return table;
}

void expect_table(Role role, const std::string& marker, const std::array<State, 5>& own) {
  const Table table = read_table(marker);
  EXPECT_EQ(table.size(), own.size() * kCommands.size());
  for (const State state : kStates) {
    const bool mine = std::find(own.begin(), own.end(), state) != own.end();
    for (const ControlCommand command : kCommands) {
      const auto following = next(role, state, command);
      unsigned expected = 0;  // a state of the other role goes nowhere
      if (mine) {
        const auto entry = table.find({static_cast<unsigned>(state), static_cast<unsigned>(command)});
        ASSERT_NE(entry, table.end()) << name(state) << ", " << name(command);
        expected = entry->second;
      }
      EXPECT_EQ(following ? static_cast<unsigned>(*following) : 0u, expected)
          << name(state) << ", " << name(command);
    }
  }
}

TEST(Mode, MasterFollowsTheDocumentedTable) {
  expect_table(Role::master, "<!-- transitions of a master -->",
               {State::start_up, State::waiting_for_initialisation, State::waiting_for_start,
                State::setting_up_master, State::active_master});
}

TEST(Mode, SlaveFollowsTheDocumentedTable) {
  expect_table(Role::slave, "<!-- transitions of a slave -->",
               {State::start_up, State::waiting_for_initialisation, State::waiting_for_start,
                State::setting_up_slave, State::active_slave});
}

TEST(Mode, TheWayUpAndBack) {
  struct Step {
    ControlCommand command;
    unsigned master;
    unsigned slave;
  };
  const std::array<Step, 7> steps = {{{ControlCommand::handshake, 0x0002, 0x0002},
                                      {ControlCommand::take_over_initialisation, 0x0003, 0x0003},
                                      {ControlCommand::start_synchronous, 0x0043, 0x0013},
                                      {ControlCommand::enable_active, 0x0080, 0x0020},
                                      {ControlCommand::reset_can, 0x0080, 0x0020},
                                      {ControlCommand::start_synchronous, 0x0043, 0x0013},
                                      {ControlCommand::cold_restart, 0x0001, 0x0001}}};
  State master = State::start_up;
  State slave = State::start_up;
  for (const Step& step : steps) {
    const auto next_master = next(Role::master, master, step.command);
    const auto next_slave = next(Role::slave, slave, step.command);
    ASSERT_TRUE(next_master) << name(step.command);
    ASSERT_TRUE(next_slave) << name(step.command);
    master = *next_master;
    slave = *next_slave;
    EXPECT_EQ(static_cast<unsigned>(master), step.master) << name(step.command);
    EXPECT_EQ(static_cast<unsigned>(slave), step.slave) << name(step.command);
  }
}

TEST(Mode, ReservedCommandsAreNotAllowed) {
  for (const State state : kStates) {
    for (const unsigned value : {0x0012u, 0x0013u, 0x0003u, 0xFFFFu}) {
      EXPECT_FALSE(next(Role::master, state, static_cast<ControlCommand>(value))) << value;
      EXPECT_FALSE(next(Role::slave, state, static_cast<ControlCommand>(value))) << value;
    }
  }
}

TEST(Mode, SynchronousAndActive) {
  for (const State state : kStates) {
    const auto value = static_cast<unsigned>(state);
    EXPECT_EQ(is_synchronous(state), value > 3);
    EXPECT_EQ(is_active(state), value == 0x80 || value == 0x20);
  }
}

}  // namespace
}  // namespace cansync
