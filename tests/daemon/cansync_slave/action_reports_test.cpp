// How actions of the master come from the realtime thread to the gateway.
#include "daemon/cansync_slave/gateway/action_reports.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "slave_rig.h"

namespace cansyncd {
namespace {

using namespace test;

class ActionReportsTest : public testing::Test {
 protected:
  static ActionReport action(std::uint64_t number, SlaveAction kind = SlaveAction::control_word) {
    ActionReport report;
    report.kind = kind;
    report.number = number;
    return report;
  }
  /// Numbers that the gateway tells now.
  std::vector<std::uint64_t> told() {
    std::vector<std::uint64_t> numbers;
    reports_.take([&](const ActionReport& report) { numbers.push_back(report.number); });
    return numbers;
  }
  using Numbers = std::vector<std::uint64_t>;

  SlaveExchange exchange_{16};
  ActionReports reports_{exchange_};
};

TEST_F(ActionReportsTest, EachIsToldOnceInItsOrder) {
  EXPECT_TRUE(told().empty());
  for (const std::uint64_t number : {1u, 2u}) ASSERT_TRUE(exchange_.actions.try_push(action(number)));
  EXPECT_EQ(told(), (Numbers{1, 2}));
  EXPECT_TRUE(told().empty());
}

TEST_F(ActionReportsTest, AControlWordWithoutRoomIsToldBetweenThoseBeforeAndAfterIt) {
  ASSERT_TRUE(exchange_.actions.try_push(action(1)));
  exchange_.lost_control_word.write(action(4));
  EXPECT_EQ(told(), (Numbers{1, 4}));
  ASSERT_TRUE(exchange_.actions.try_push(action(5)));
  exchange_.lost_control_word.write(action(7));
  ASSERT_TRUE(exchange_.actions.try_push(action(8)));
  EXPECT_EQ(told(), (Numbers{5, 7, 8}));
  EXPECT_TRUE(told().empty());
}

TEST_F(ActionReportsTest, OfControlWordsWithoutRoomTheNewestIsTold) {
  exchange_.lost_control_word.write(action(3));
  exchange_.lost_control_word.write(action(4));
  EXPECT_EQ(told(), Numbers{4});
}

/// The gateway stands still; the realtime thread goes on.
class StalledGateway : public testing::Test {
 protected:
  void control_word_at(can::Time when, std::uint16_t word) {
    rig.at(when, [this, word] {
      cansync::ControlWordRequest request;
      request.id = word;
      request.slave = *cansync::SlaveNumber::from(kNumber);
      request.control_word = word;
      ASSERT_EQ(rig.master->master().submit(request), cansync::Refusal::none);
    });
  }
  std::vector<ActionReport> told() {
    std::vector<ActionReport> found;
    reports.take([&](const ActionReport& report) { found.push_back(report); });
    return found;
  }

  SlaveRig rig;
  ActionReports reports{rig.exchange};
};

TEST_F(StalledGateway, ProcessDataTakesNoRoomFromAControlWord) {
  const can::Time interval = rig.times.interval;
  std::vector<ActionReport> found;
  rig.at(1500 * interval, [&] {
    (void)told();
    while (rig.exchange.reports.try_push(ReferencesReport{})) {
    }
  });
  control_word_at(1510 * interval, 9);
  rig.at(1550 * interval, [&] { found = told(); });
  rig.run_until(1560 * interval);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].kind, SlaveAction::control_word);
  EXPECT_EQ(found[0].action.data_word, 9);
  EXPECT_EQ(found[0].number, rig.snapshot.actions);
}

TEST_F(StalledGateway, TheNewestControlWordArrivesAndItsNumberSaysThatOthersDidNot) {
  const can::Time interval = rig.times.interval;
  std::vector<ActionReport> found;
  std::uint64_t last = 0;
  rig.at(1500 * interval, [&] {
    for (const ActionReport& report : told()) last = report.number;
    while (rig.exchange.actions.try_push({})) {
    }
  });
  control_word_at(1510 * interval, 8);
  control_word_at(1520 * interval, 9);
  rig.at(1550 * interval, [&] { found = told(); });
  rig.run_until(1560 * interval);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].action.data_word, 9);
  EXPECT_EQ(found[0].number, last + 2);
  EXPECT_EQ(rig.snapshot.lost_reports, 2u);
}

}  // namespace
}  // namespace cansyncd
