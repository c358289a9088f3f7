// The bus budget against figures worked out by hand.
#include "cansync/config/bus_budget.h"

#include <gtest/gtest.h>

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "cansync/config/bus_budget_text.h"

namespace {

using namespace cansyncd;
using std::chrono::microseconds;
using std::chrono::milliseconds;

cansync::MasterSettings line(cansync::BitRate rate, unsigned slaves) {
  cansync::MasterSettings settings;
  settings.bit_rate = rate;
  settings.send_margin = cansync::default_send_margin(rate);
  settings.process.maximum_slave = *cansync::SlaveNumber::from(slaves - 1);
  for (unsigned i = 0; i < slaves; ++i) settings.slaves[i].configured = true;
  return settings;
}

BusBudget budget_of(const cansync::MasterSettings& settings,
                    std::optional<std::uint8_t> sync = std::nullopt) {
  return bus_budget({settings, sync});
}

struct Row {
  std::string name;
  unsigned bits;
  int planned, latest, end;  // us
  friend bool operator==(const Row&, const Row&) = default;
};
void PrintTo(const Row& row, std::ostream* out) {
  *out << row.name << " " << row.bits << " " << row.planned << " " << row.latest << " " << row.end;
}

std::vector<Row> rows(const BusBudget& budget) {
  const auto us = [](cansync::Duration d) {
    return static_cast<int>(std::chrono::duration_cast<microseconds>(d).count());
  };
  std::vector<Row> out;
  for (const auto& slot : budget.slots) {
    out.push_back({std::string(slot.name), slot.bits, us(slot.planned), us(slot.latest), us(slot.end)});
  }
  return out;
}

/// The only problem found.
cansync::SettingProblem problem_of(const BudgetInput& input) {
  const auto problems = check_budget(input);
  EXPECT_EQ(problems.size(), 1U);
  return problems.empty() ? cansync::SettingProblem{} : problems.front();
}

TEST(BusBudget, OneMegabitFullTelegrams) {
  const BusBudget budget = budget_of(line(cansync::BitRate::mbit1, 32));
  // 8 bytes: 98 bits that may be stuffed, 24 stuff bits, 13 more.
  EXPECT_EQ(rows(budget), (std::vector<Row>{{"RC", 135, 210, 210, 345},
                                            {"WRC1", 135, 300, 350, 485},
                                            {"RDC1", 135, 520, 520, 655},
                                            {"WRC2", 135, 600, 650, 785},
                                            {"RDC2", 135, 820, 820, 955},
                                            {"CC", 135, 900, 950, 1085}}));
  EXPECT_EQ(budget.capacity_bits, 1000U);
  // Four telegrams of 111 bits, and 32 reads of 79 + 95 bits in 1000 intervals: 449.568 bits.
  EXPECT_EQ(budget.idle, 450U);
  EXPECT_EQ(budget.typical, 444U + 174U);
  EXPECT_EQ(budget.worst, 6U * 135U);
  EXPECT_EQ(budget.polling_round[0], 32U);
  EXPECT_EQ(budget.parameter_round, 1U);
  EXPECT_EQ(budget.parameter_least, microseconds(174));
  // 218 blocks of 300 bytes with 1 + 50 telegrams each, and one of 136 bytes with 1 + 23.
  EXPECT_EQ(budget.transfer_intervals, 218U * 51U + 24U);
  EXPECT_EQ(budget.transfer_least, milliseconds(11142));
  EXPECT_EQ(budget.sync_delay, microseconds(0));
}

TEST(BusBudget, TheSlowestBitRate) {
  const BusBudget budget = budget_of(line(cansync::BitRate::kbit125, 4));
  EXPECT_EQ(rows(budget), (std::vector<Row>{{"RC", 135, 1920, 1920, 3000},
                                            {"WRC1", 135, 2620, 3020, 4100},
                                            {"RDC1", 135, 4310, 4310, 5390},
                                            {"WRC2", 135, 4950, 5350, 6430},
                                            {"RDC2", 135, 6640, 6640, 7720},
                                            {"CC", 135, 7280, 7680, 8760}}));
  EXPECT_EQ(budget.capacity_bits, 1000U);
  EXPECT_EQ(budget.idle, 450U);  // four reads in 125 intervals are as many as 32 in 1000
  EXPECT_EQ(budget.parameter_least, microseconds(174 * 8));
  EXPECT_EQ(budget.transfer_least, milliseconds(11142 * 8));
}

TEST(BusBudget, TelegramsAsLongAsTheyAreMapped) {
  auto settings = line(cansync::BitRate::mbit1, 2);
  settings.process.full_length = false;
  settings.process.reference_mapping[0] = {};
  settings.process.reference_mapping[0].word[0] = {true, 0, false};
  settings.process.polling[1].kind = cansync::Cursor::Kind::nobody;
  settings.startup.status_period = {};
  const BusBudget budget = budget_of(settings);
  // 2 bytes: 50 bits that may be stuffed, 12 stuff bits, 13 more.
  EXPECT_EQ(rows(budget), (std::vector<Row>{{"RC", 135, 210, 210, 345},
                                            {"WRC1", 75, 300, 350, 425},
                                            {"RDC1", 135, 520, 520, 655},
                                            {"WRC2", 135, 600, 650, 785},
                                            {"CC", 135, 900, 950, 1085}}));
  EXPECT_EQ(budget.idle, 63U + 111U + 111U);
  EXPECT_EQ(budget.worst, 4U * 135U + 75U);
  EXPECT_EQ(budget.polling_round[1], 0U);
}

TEST(BusBudget, ScanningCursorsAndTheLongestBlocks) {
  auto settings = line(cansync::BitRate::mbit1, 32);
  settings.command_channel.serving = cansync::Serving::scan;
  for (auto& slave : settings.slaves) slave.block_limit = 4092;
  BusBudget budget = budget_of(settings);
  EXPECT_EQ(budget.parameter_round, 32U);
  // 16 blocks of 1 + 682 telegrams and one of 64 bytes with 1 + 11, each once in 32 intervals.
  EXPECT_EQ(budget.transfer_intervals, (16U * 683U + 12U) * 32U);
  settings.command_channel.transfer = {cansync::Cursor::Kind::fixed, *cansync::SlaveNumber::from(3)};
  budget = budget_of(settings);
  EXPECT_EQ(budget.transfer_intervals, 16U * 683U + 12U);
}

TEST(BusBudget, ASoftwareSyncFrameTakesItsShare) {
  const BusBudget budget = budget_of(line(cansync::BitRate::mbit1, 32), 0);
  EXPECT_EQ(rows(budget).front(), (Row{"SYNC", 55, 0, 0, 55}));
  EXPECT_EQ(budget.worst, 865U);
  EXPECT_EQ(budget.typical, 47U + 618U);
  EXPECT_EQ(budget.sync_delay, microseconds(85));
  EXPECT_EQ(budget_of(line(cansync::BitRate::kbit500, 32), 0).sync_delay, microseconds(160));
}

TEST(BusBudget, TheTableNamesEveryTelegramAndFigure) {
  EXPECT_EQ(budget_text(budget_of(line(cansync::BitRate::mbit1, 4), 0)),
            "bus budget at 1000000 bit/s: intervals of 1000 us, 1000 bits each\n"
            "telegram  bytes  bits at most  planned us  latest start us  latest end us\n"
            "SYNC          0            55           0                0             55\n"
            "RC            8           135         210              210            345\n"
            "WRC1          8           135         300              350            485\n"
            "RDC1          8           135         520              520            655\n"
            "WRC2          8           135         600              650            785\n"
            "RDC2          8           135         820              820            955\n"
            "CC            8           135         900              950           1085\n"
            "bus load: idle 49.2 %, typical 66.5 %, worst 86.5 %\n"
            "RDC1: every slave asked once in 4 intervals, 4.000 ms\n"
            "RDC2: every slave asked once in 4 intervals, 4.000 ms\n"
            "parameter read: at least 174 us on the bus, at most one in 1 interval per slave\n"
            "transfer of 65536 bytes: at least 11.142 s, 11142 intervals (blocks of 300 bytes)\n"
            "SYNC frame: up to 85 us late behind the longest command\n");
}

/// A slave is asked by one channel half a round after the other one.
TEST(BusBudget, CursorsSetApart) {
  auto settings = line(cansync::BitRate::mbit1, 32);
  EXPECT_EQ(budget_of(settings).polling_apart, 0U);
  EXPECT_EQ(budget_text(budget_of(settings)).find("RDC1 or RDC2"), std::string::npos);
  settings.process.polling_apart = true;
  EXPECT_EQ(budget_of(settings).polling_round[0], 32U);
  EXPECT_NE(budget_text(budget_of(settings))
                .find("RDC2: every slave asked once in 32 intervals, 32.000 ms\n"
                      "RDC1 or RDC2: every slave asked once in 16 intervals, 16.000 ms\n"),
            std::string::npos);
  settings.process.maximum_slave = *cansync::SlaveNumber::from(4);  // 0 to 4: three intervals, then two
  EXPECT_EQ(budget_of(settings).polling_apart, 3U);
  settings.process.maximum_slave = *cansync::SlaveNumber::from(0);
  EXPECT_EQ(budget_of(settings).polling_apart, 1U);
  settings.process.polling[1].kind = cansync::Cursor::Kind::nobody;
  EXPECT_EQ(budget_of(settings).polling_apart, 0U);
}

TEST(BusBudget, RefusesAMarginThatCanTakeASlavesPlace) {
  struct Limit {
    cansync::BitRate rate;
    int most;  // us
  };
  for (const Limit& limit : {Limit{cansync::BitRate::mbit1, 130}, Limit{cansync::BitRate::kbit500, 260},
                             Limit{cansync::BitRate::kbit250, 520}, Limit{cansync::BitRate::kbit125, 1040}}) {
    auto settings = line(limit.rate, 2);
    settings.send_margin = microseconds(limit.most);
    EXPECT_TRUE(check_budget({settings, std::nullopt}).empty()) << limit.most;
    settings.send_margin += microseconds(1);
    const auto problem = problem_of({settings, std::nullopt});
    EXPECT_EQ(problem.field, "send_margin");
    EXPECT_EQ(problem.allowed, "0 us .. " + std::to_string(limit.most) + " us");
  }
  auto settings = line(cansync::BitRate::mbit1, 2);
  settings.send_margin = microseconds(150);
  EXPECT_EQ(problem_of({settings, std::nullopt}).found,
            "150 us, so that WRC1 would be sent 200 us after SYNC, while RC may still start until 210 us");
  settings.send_margin = microseconds(131);
  EXPECT_EQ(problem_of({settings, std::nullopt}).found,
            "131 us, so that WRC2 would be sent 519 us after SYNC, while RDC1 may still start until 520 us");
}

TEST(BusBudget, RefusesASyncFrameThatLeavesNoRoomForTheResponse) {
  const auto settings = line(cansync::BitRate::mbit1, 2);
  EXPECT_TRUE(check_budget({settings, 7}).empty());  // 85 + 125 bits end at 210 us, where RC may start
  const auto problem = problem_of({settings, 8});
  EXPECT_EQ(problem.field, "sync");
  EXPECT_EQ(
      problem.found,
      "a SYNC frame of 8 bytes, up to 135 bits: behind the longest command of the interval before it ends "
      "220 us after SYNC, while RC must start by 210 us");
  EXPECT_EQ(problem.allowed, "a SYNC frame of at most 125 bits");
}

TEST(BusBudget, RefusesMonitoringTimesThatTheCursorsCannotKeep) {
  auto settings = line(cansync::BitRate::kbit125, 32);
  settings.command_channel.serving = cansync::Serving::scan;
  settings.command_channel.parameter_monitoring =
      milliseconds(264);  // 32 intervals for the turn, 1 for the answer
  settings.command_channel.transfer_monitoring = milliseconds((51 * 32 + 1) * 8);
  EXPECT_TRUE(check_budget({settings, std::nullopt}).empty());

  settings.command_channel.parameter_monitoring = milliseconds(263);
  const auto parameter = problem_of({settings, std::nullopt});
  EXPECT_EQ(parameter.field, "command_channel.parameter_monitoring");
  EXPECT_EQ(parameter.found,
            "263 ms, while the parameter cursor needs 32 intervals of 8000 us to come round and one for the "
            "answer");
  EXPECT_EQ(parameter.allowed, "at least 264 ms, or serving \"work_conserving\"");

  settings.command_channel.parameter_monitoring = milliseconds(264);
  settings.slaves[7].block_limit = 306;
  const auto transfer = problem_of({settings, std::nullopt});
  EXPECT_EQ(transfer.field, "command_channel.transfer_monitoring");
  EXPECT_EQ(transfer.found,
            "13064 ms, while a block of 306 bytes takes 52 telegrams, one in 32 intervals of 8000 us");
  EXPECT_EQ(transfer.allowed, "at least 13320 ms, or smaller blocks");
}

TEST(BusBudget, RefusesMoreStatusWordsThanThereAreCommands) {
  auto settings = line(cansync::BitRate::mbit1, 32);
  settings.startup.status_period = milliseconds(32);
  EXPECT_TRUE(check_budget({settings, std::nullopt}).empty());
  settings.startup.status_period = milliseconds(31);
  const auto problem = problem_of({settings, std::nullopt});
  EXPECT_EQ(problem.field, "startup.status_period");
  EXPECT_EQ(problem.found, "31 ms, while 32 status words take 32 intervals of 1000 us, one command in each");
  EXPECT_EQ(problem.allowed, "0 (never), or at least 32 ms");
}

}  // namespace
