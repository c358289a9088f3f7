// Parameters and transfers of a real master to the slave's core, as slave_acceptance_test.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "slave_line_rig.h"

namespace sim::test {
namespace {

using cansync::BlockEnd;
using cansync::Outcome;
using cansync::ParameterError;
using cansync::ParameterFormat;
using cansync::TransferError;

// --- parameters

/// An application that answers `intervals` after it was asked, reads with `value`.
std::function<void(SlaveNode&)> answers_after(unsigned intervals, std::uint32_t value,
                                              ParameterError error = ParameterError::none) {
  return [=, waited = 0u](SlaveNode& node) mutable {
    if (!node.parameter) {
      waited = 0;
      return;
    }
    if (waited++ < intervals) return;
    EXPECT_TRUE(node.service.jobs().answer(node.parameter->id,
                                           {false, error, node.parameter->number.value() == 500, value}));
    node.parameter.reset();
    waited = 0;
  };
}

TEST_P(SlaveAcceptance, S22EveryParameterCodeReachesTheMaster) {
  SlaveLine line(GetParam());
  with_parameters(line);
  line.start();
  const auto error_of = [&](unsigned number, std::optional<std::uint32_t> written = std::nullopt,
                            ParameterFormat format = ParameterFormat::word) {
    auto request = line.request(number);
    request.write = written.has_value();
    request.value = written.value_or(0);
    if (written) request.format = format;
    const auto result = line.end_of(request);
    EXPECT_EQ(result.outcome, result.error == ParameterError::none ? Outcome::done : Outcome::slave_error);
    return static_cast<unsigned>(result.error);
  };
  EXPECT_EQ(error_of(400), 0u);
  EXPECT_EQ(error_of(401), 0u);
  EXPECT_EQ(error_of(400, 100), 0u);
  EXPECT_EQ(error_of(400, 0xFFFA), 0xFFFEu) << "-6";
  EXPECT_EQ(error_of(400, 101), 0xFFFDu);
  EXPECT_EQ(error_of(401, 1, ParameterFormat::doubleword), 0xFFFCu);
  EXPECT_EQ(error_of(399), 0xFFFBu);
  EXPECT_EQ(error_of(402), 0xFFFAu);
  EXPECT_EQ(error_of(400, 1, ParameterFormat::doubleword), 0xFFF9u);
  EXPECT_EQ(error_of(500), 0xFFFAu) << "nobody answers for it";
  line.slave().service.set_application(true);
  line.slave().application = answers_after(0, 0, ParameterError::unspecified);
  EXPECT_EQ(error_of(500), 0xFFFFu);
  line.slave().application = answers_after(2, 0, static_cast<ParameterError>(0x0321));
  EXPECT_EQ(error_of(500), 0x0321u);
}

TEST_P(SlaveAcceptance, S20BusyForNoneOneAndManyIntervals) {
  SlaveLine line(GetParam());
  with_parameters(line);
  line.start();
  line.slave().service.set_application(true);
  for (const unsigned intervals : {0u, 1u, 2u, 100u}) {
    line.slave().application = answers_after(intervals, 0x80000000u + intervals);
    const auto result = line.end_of(line.request(500));
    EXPECT_EQ(result.outcome, Outcome::done);
    EXPECT_EQ(result.value, 0x80000000u + intervals);
    EXPECT_GE(result.busy_replies, 1u);
    EXPECT_GE(result.busy_replies + 2, intervals);
  }
  auto write = line.request(500);
  write.write = true;
  write.format = ParameterFormat::doubleword;
  write.value = 5;
  EXPECT_EQ(line.end_of(write).outcome, Outcome::done);
  EXPECT_EQ(line.slave().jobs_answered, 5u);
  EXPECT_EQ(line.slave().jobs_dropped, 0u);
}

TEST_P(SlaveAcceptance, S21AnotherNumberWhileBusyAndAnAnswerThatCameTooLate) {
  SlaveLine line(GetParam());
  with_parameters(line);
  line.start();
  line.slave().service.set_application(true);
  const auto first = line.request(500);
  ASSERT_EQ(line.master().submit(first), cansync::Refusal::none);
  ASSERT_TRUE(line.run_until([&] { return line.slave().parameter.has_value(); }));
  const std::uint64_t old = line.slave().parameter->id;
  line.master().cancel(first.id);
  EXPECT_EQ(line.end_of(line.request(400)).value, 7u);
  EXPECT_EQ(line.slave().jobs_dropped, 1u);
  EXPECT_FALSE(line.slave().service.jobs().answer(old, {}));
  line.slave().application = answers_after(1, 3);
  EXPECT_EQ(line.end_of(line.request(4095)).value, 3u);
  EXPECT_EQ(line.ends.parameters[first.id].outcome, Outcome::cancelled);
}

TEST_P(SlaveAcceptance, S20TheApplicationDiesWhileBusy) {
  SlaveLine line(GetParam());
  with_parameters(line);
  line.start();
  line.slave().service.set_application(true);
  const auto request = line.request(500);
  ASSERT_EQ(line.master().submit(request), cansync::Refusal::none);
  ASSERT_TRUE(line.run_until([&] { return line.slave().parameter.has_value(); }));
  line.run(10);
  line.slave().service.set_application(false);
  ASSERT_TRUE(line.run_until([&] { return line.ends.parameters.contains(request.id); }, 10));
  EXPECT_EQ(line.ends.parameters[request.id].error, ParameterError::not_available_now);
  EXPECT_FALSE(line.slave().service.jobs().open());
}

TEST_P(SlaveAcceptance, S28ResponsesKeepTheirTimesWhateverTheLoad) {
  SlaveLine line(GetParam());
  with_parameters(line);
  line.start();
  line.slave().service.set_application(true);
  line.slave().application = answers_after(3, 1);
  const std::size_t before = line.judge.responses.size();
  for (int i = 0; i < 50; ++i) {
    line.master().submit(line.request(i % 2 == 0 ? 400 : 500));
  }
  line.run(400);
  EXPECT_GT(line.judge.responses.size(), before + 100);
  EXPECT_EQ(line.slave().slave.response_counters().late, 0u);
  EXPECT_EQ(line.ends.parameters.size(), 50u);
}

// --- transfers

TEST_P(SlaveAcceptance, S23TransfersOfEveryLengthThroughTheAreaAndTelegramByTelegram) {
  for (const bool area : {true, false}) {
    SlaveLine line(GetParam());
    line.under_test.service.area.area = area;
    line.start();
    line.slave().service.set_application(true);
    unsigned blocks = 0;
    for (const std::size_t size : {1u, 6u, 7u, 299u, 300u, 301u, 4092u}) {
      std::vector<std::uint8_t> memory;
      line.slave().application = moves_blocks(memory);
      auto data = bytes_of(size);
      const auto down = line.end_of(line.transfer(true, data));
      EXPECT_EQ(down.outcome, Outcome::done) << size;
      EXPECT_EQ(memory, data);
      std::vector<std::uint8_t> back(size);
      const auto up = line.end_of(line.transfer(false, back));
      EXPECT_EQ(up.outcome, Outcome::done) << size;
      EXPECT_EQ(back, data);
      blocks += 2;
      EXPECT_EQ(line.slave().ends[BlockEnd::done], blocks);
    }
    EXPECT_EQ(line.slave().ends.size(), 1u) << "nothing ended otherwise";
  }
}

TEST_P(SlaveAcceptance, S23ASlowApplicationIsWaitedFor) {
  SlaveLine line(GetParam());
  line.start();
  line.slave().service.set_application(true);
  std::vector<std::uint8_t> memory;
  line.slave().application = moves_blocks(memory, 7);
  for (const std::size_t size : {300u, 313u}) {
    auto data = bytes_of(size);
    EXPECT_EQ(line.end_of(line.transfer(true, data)).outcome, Outcome::done);
    EXPECT_EQ(memory, data);
    memory.clear();
  }
}

TEST_P(SlaveAcceptance, S26ErrorsAtTheBeginningInTheMiddleAndAtTheEnd) {
  SlaveLine line(GetParam());
  line.master_settings.master.command_channel.block_retries = 0;
  line.master_settings.master.command_channel.telegram_repeats = 0;
  line.start();
  auto data = bytes_of(60);
  EXPECT_EQ(line.end_of(line.transfer(true, data)).error, TransferError::not_possible) << "no application";
  line.slave().service.set_application(true);
  for (const unsigned at : {0u, 12u, 60u}) {
    line.slave().application = [at](SlaveNode& node) {
      if (!node.block) return;
      const std::uint64_t id = node.block->id;
      if (at == 0 || (node.slave.transfer_open() && node.service.area().counter() >= at)) {
        node.service.area().refuse(id, TransferError::address_not_allowed);
      } else {
        node.service.area().allow(id);
      }
    };
    const auto result = line.end_of(line.transfer(true, data));
    EXPECT_EQ(result.outcome, Outcome::slave_error) << at;
    EXPECT_EQ(result.error, TransferError::address_not_allowed) << at;
  }
  EXPECT_EQ(line.slave().ends[BlockEnd::refused], 3u);
  EXPECT_EQ(line.slave().ends[BlockEnd::done], 0u);
}

TEST_P(SlaveAcceptance, S25ACancelAtEachPointLeavesTheSlaveReady) {
  SlaveLine line(GetParam());
  line.start();
  line.slave().service.set_application(true);
  auto data = bytes_of(60);
  unsigned cancelled = 0;
  for (unsigned after = 1; after <= 14; ++after) {
    std::vector<std::uint8_t> memory;
    line.slave().application = moves_blocks(memory, 1);
    const auto request = line.transfer(true, data);
    ASSERT_EQ(line.master().submit(request), cansync::Refusal::none);
    line.run(after);
    line.master().cancel(request.id);
    ASSERT_TRUE(line.run_until([&] { return line.ends.transfers.contains(request.id); }));
    const Outcome outcome = line.ends.transfers[request.id].outcome;
    EXPECT_TRUE(outcome == Outcome::cancelled || outcome == Outcome::no_answer || outcome == Outcome::done)
        << after;
    cancelled += outcome == Outcome::done ? 0 : 1;
    line.run(5);
    if (outcome == Outcome::cancelled) {
      EXPECT_TRUE(memory.empty()) << after;
    }
    EXPECT_FALSE(line.slave().slave.transfer_open()) << after;
    EXPECT_EQ(line.slave().service.area().open().id, 0u) << after;
  }
  EXPECT_GT(cancelled, 10u);
  std::vector<std::uint8_t> memory;
  line.slave().application = moves_blocks(memory);
  EXPECT_EQ(line.end_of(line.transfer(true, data)).outcome, Outcome::done);
  EXPECT_EQ(memory, data);
}

TEST_P(SlaveAcceptance, S25LostAnswersDoNotMoveAByteTwice) {
  for (const bool area : {true, false}) {
    SlaveLine line(GetParam());
    line.under_test.service.area.area = area;
    line.master_settings.master.command_channel.telegram_repeats = 5;
    line.master_settings.master.command_channel.block_retries = 5;
    // A slave that missed a few answers in a row is not lost for that.
    line.master_settings.master.startup.lost_after = 20;
    line.start();
    line.slave().service.set_application(true);
    Fault lost = fault_soon(line, FaultKind::lost, 0, 100'000);
    lost.identifier = cansync::identifier::response;
    lost.mask = cansync::identifier::channel_bits;
    lost.probability = 0.2;
    line.line().faults().add(lost);
    for (int round = 0; round < 10; ++round) {
      std::vector<std::uint8_t> memory;
      line.slave().application = moves_blocks(memory);
      auto data = bytes_of(60 + static_cast<std::size_t>(round));
      EXPECT_EQ(line.end_of(line.transfer(true, data)).outcome, Outcome::done);
      EXPECT_EQ(memory, data);
    }
  }
}

TEST(SlaveMonitoring, S23AnApplicationThatNeverAnswersEndsAfter30Seconds) {
  SlaveLine line(BitRate::mbit1);
  line.master_settings.master.command_channel.transfer_monitoring = std::chrono::seconds(40);
  line.master_settings.master.command_channel.block_retries = 0;
  line.start();
  line.slave().service.set_application(true);
  auto data = bytes_of(60);
  const can::Time from = line.line().now();
  const auto result = line.end_of(line.transfer(true, data));
  EXPECT_EQ(result.error, TransferError::cancelled_by_slave);
  EXPECT_GE(line.line().now() - from, std::chrono::seconds(30));
  EXPECT_LE(line.line().now() - from, std::chrono::milliseconds(30'050));
  EXPECT_EQ(line.slave().ends[BlockEnd::timed_out], 1u);
}

}  // namespace
}  // namespace sim::test
