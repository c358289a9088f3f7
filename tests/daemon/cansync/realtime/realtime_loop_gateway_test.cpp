// What the gateway asks of the realtime loop, and what it is told.
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>

#include "can/frame_length.h"
#include "support/loop_rig.h"

namespace {

using namespace cansyncd;
using namespace cansyncd::test;
using cansync::Channel;
using cansync::Outcome;
using cansync::Refusal;
using cansync::State;
using std::chrono::microseconds;
using std::chrono::milliseconds;

// --- modes and the gateway

TEST(RealtimeLoop, ReachesActiveOperationByItselfOnceSlavesAreSynchronized) {
  LoopRig rig;
  rig.slaves_synchronized = false;
  rig.at(100, microseconds(0), [&] {
    EXPECT_EQ(rig.snapshot().state, State::setting_up_master) << "the enable rule holds";
    rig.slaves_synchronized = true;
  });
  rig.at(200, microseconds(0), [&] {
    const auto snapshot = rig.snapshot();
    EXPECT_EQ(snapshot.state, State::active_master);
    EXPECT_EQ(snapshot.responding.bits, 0b111U);
    EXPECT_EQ(snapshot.synchronized.bits, 0b111U);
  });
  rig.run_until(201);
  const auto changes = rig.reported<StateChanged>();
  ASSERT_GE(changes.size(), 4U);
  EXPECT_EQ(changes[3].to, State::active_master);
  EXPECT_GT(changes[3].when.interval, 99U);
}

TEST(RealtimeLoop, WithoutATargetNothingIsOnTheBus) {
  LoopRig rig(virtual_time(StartTarget::none));
  rig.push_at(50, read_request(1, 0, 1000));
  rig.push_at(60, ModeRequest{2, Mode::run, true});
  rig.at(99, microseconds(0), [&] { EXPECT_EQ(rig.snapshot().state, State::waiting_for_start); });
  rig.run_until(100);
  EXPECT_TRUE(rig.bus.edges.empty());
  EXPECT_TRUE(rig.bus.sent.empty());
  EXPECT_EQ(rig.answer_to<Refused>(1).refusal, Refusal::wrong_state);
  EXPECT_EQ(rig.answer_to<Refused>(2).refusal, Refusal::wrong_state) << "set-up comes first";
}

TEST(RealtimeLoop, NoTelegramBeforeTheFirstEdge) {
  LoopRig rig(virtual_time(StartTarget::none));
  rig.push_at(50, ModeRequest{1, Mode::set_up, false});
  rig.run_until(100);
  ASSERT_FALSE(rig.bus.edges.empty());
  ASSERT_FALSE(rig.bus.sent.empty());
  EXPECT_GT(rig.bus.sent.front().at, rig.bus.edges.front().second);
  EXPECT_EQ(rig.answer_to<CommandDone>(1).outcome, Outcome::done);
}

TEST(RealtimeLoop, OperatorsLeadTheLineThroughAllModes) {
  LoopRig rig(virtual_time(StartTarget::setup));
  rig.slaves_synchronized = false;
  const auto expect_state = [&rig](unsigned n, State state) {
    rig.at(n, microseconds(0), [&rig, n, state] { EXPECT_EQ(rig.snapshot().state, state) << "at " << n; });
  };
  rig.push_at(50, ModeRequest{1, Mode::run, false});
  expect_state(59, State::setting_up_master);
  rig.push_at(60, ModeRequest{2, Mode::run, true});
  expect_state(69, State::active_master);
  rig.push_at(70, ModeRequest{3, Mode::set_up, false});
  expect_state(79, State::setting_up_master);
  rig.push_at(80, ModeRequest{4, Mode::stop, false});
  expect_state(89, State::waiting_for_start);
  rig.push_at(90, ModeRequest{5, Mode::reset_can, false});
  rig.push_at(100, ModeRequest{6, Mode::restart, false});
  expect_state(109, State::setting_up_master);
  rig.run_until(110);
  EXPECT_EQ(rig.answer_to<Refused>(1).refusal, Refusal::slaves_missing);
  for (cansync::JobId id = 2; id <= 6; ++id) EXPECT_EQ(rig.answer_to<CommandDone>(id).outcome, Outcome::done);
  EXPECT_EQ(rig.bus.resets, 1U);
  for (const auto& [due, produced] : rig.bus.edges) {
    const auto n = (due - rig.first_sync()) / rig.interval;
    EXPECT_TRUE(n <= 80 || n > 100) << "SYNC " << n << " while stopped";
  }
}

TEST(RealtimeLoop, ABusThatCannotBeResetRefuses) {
  LoopRig rig;
  rig.bus.reset_answer = can::ResetResult::unavailable;
  rig.push_at(50, ModeRequest{1, Mode::reset_can, false});
  rig.at(60, microseconds(0),
         [&rig] { rig.bus.reset_answer = can::ResetResult::done; });  // the interface is up
  rig.push_at(61, ModeRequest{2, Mode::reset_can, false});
  rig.run_until(70);
  EXPECT_EQ(rig.answer_to<Refused>(1).refusal, Refusal::bus_unavailable);
  EXPECT_EQ(rig.answer_to<CommandDone>(2).outcome, Outcome::done);
}

TEST(RealtimeLoop, ActualValuesReachTheGatewayWithTheirTimes) {
  LoopSettings settings = virtual_time();
  settings.epoch = std::chrono::seconds(1'700'000'000);
  LoopRig rig(settings);
  rig.push_at(60, references(Channel::one));
  rig.run_until(100);
  for (unsigned n = 0; n < 3; ++n) {
    ActualReport report;
    ASSERT_TRUE(rig.exchange.actual[n].read(report)) << n;
    EXPECT_EQ(report.values.value[0], n);
    EXPECT_GT(report.values.count[0], 0U);
    EXPECT_EQ(report.when.interval, report.values.interval[0]);
    EXPECT_EQ(report.when.wall_clock, report.when.bus + settings.epoch);
    const auto after_sync = (report.when.bus - rig.first_sync()) % rig.interval;
    EXPECT_GT(after_sync, microseconds(300) + microseconds(111)) << "end of the answer to WRC1";
  }
  ActualReport nothing;
  EXPECT_FALSE(rig.exchange.actual[3].read(nothing));
}

TEST(RealtimeLoop, ReportsIntervalsWhenSwitchedOn) {
  LoopSettings settings = virtual_time();
  settings.report_intervals = true;
  LoopRig rig(settings);
  unsigned seen = 0;
  rig.bus.on_sleep = [&, play = rig.bus.on_sleep](can::Time now) {
    IntervalReport report;
    if (rig.exchange.interval.read(report)) {
      ++seen;
      EXPECT_EQ(now, report.sync.bus) << "told right after the edge";
      EXPECT_EQ(report.sync.bus, rig.first_sync() + static_cast<int>(report.sync.interval) * rig.interval);
      EXPECT_EQ(report.time_left, microseconds(300));
      EXPECT_TRUE(rig.exchange.gateway_wake.wait(milliseconds(0)));
    }
    play(now);
  };
  rig.run_until(100);
  EXPECT_EQ(seen, rig.bus.edges.size());
}

TEST(RealtimeLoop, SettingsTakeEffectAndAreAllOrNothing) {
  LoopRig rig;
  const cansync::Cursor fixed{cansync::Cursor::Kind::fixed, slave(2)};
  const cansync::Cursor stranger{cansync::Cursor::Kind::fixed, slave(9)};
  rig.push_at(60, references(Channel::one));
  rig.push_at(70, SetPolling{1, {fixed, std::nullopt}, slave(1)});
  rig.push_at(80, SetPolling{2, {cansync::Cursor{}, stranger}, slave(2)});
  rig.push_at(81, SetCursors{3, std::nullopt, fixed, std::nullopt});
  cansync::ProcessMapping mapping = {};
  mapping[0].word[0] = {true, false, 3};
  rig.push_at(82, SetReferenceMapping{4, mapping});
  rig.push_at(83, SetActualMapping{5, slave(1), mapping});
  rig.run_until(100);
  EXPECT_EQ(rig.answer_to<CommandDone>(1).outcome, Outcome::done);
  EXPECT_EQ(rig.answer_to<Refused>(2).refusal, Refusal::slave_not_configured);
  for (cansync::JobId id = 3; id <= 5; ++id) EXPECT_EQ(rig.answer_to<CommandDone>(id).outcome, Outcome::done);
  SettingsSnapshot settings;
  ASSERT_TRUE(rig.exchange.settings.read(settings));
  EXPECT_EQ(settings.polling[0], fixed) << "the refused request left the first channel as it was";
  EXPECT_EQ(settings.maximum_slave, slave(1));
  EXPECT_EQ(settings.parameter, fixed);
  EXPECT_EQ(settings.reference_mapping, mapping);
  EXPECT_EQ(settings.actual_mapping[1], mapping);
  EXPECT_NE(settings.actual_mapping[0], mapping);
  for (const auto& sent : rig.bus.sent) {
    const auto n = (sent.at - rig.first_sync()) / rig.interval;
    if ((sent.frame.id & 0x780U) == cansync::identifier::reference_one && n > 70) {
      EXPECT_EQ(sent.frame.id, cansync::identifier::reference_one + 2);
    }
  }
}

TEST(RealtimeLoop, ControllerChangesAreReportedOnceAndShowInTheStatusWord) {
  LoopRig rig;
  rig.at(100, microseconds(0), [&] { rig.bus.controller.state = can::ControllerState::bus_off; });
  rig.at(120, microseconds(0), [&] {
    EXPECT_NE(rig.snapshot().cansync_status & 0x80U, 0U);
    rig.bus.controller.state = can::ControllerState::error_active;
  });
  rig.run_until(140);
  const auto changes = rig.reported<ControllerChanged>();
  ASSERT_EQ(changes.size(), 2U);
  EXPECT_EQ(changes[0].to, can::ControllerState::bus_off);
  EXPECT_EQ(changes[1].to, can::ControllerState::error_active);
  EXPECT_EQ(rig.snapshot().cansync_status & 0x80U, 0U);
}

TEST(RealtimeLoop, OffTheBusForASecondNothingIsKnownOfAnySlave) {
  LoopRig rig;
  const auto bus_off = [&](bool off) {
    rig.bus.controller.state = off ? can::ControllerState::bus_off : can::ControllerState::error_active;
    rig.bus.send_result = off ? can::SendResult::bus_off : can::SendResult::queued;
  };
  rig.at(100, microseconds(0), [&] { bus_off(true); });
  rig.at(1090, microseconds(0), [&] {
    EXPECT_EQ(rig.snapshot().responding.bits, 0b111U) << "a short interruption changes nothing";
  });
  rig.at(1110, microseconds(0), [&] {
    EXPECT_EQ(rig.snapshot().responding.bits, 0U);
    bus_off(false);
  });
  rig.run_until(1300);
  EXPECT_EQ(rig.snapshot().responding.bits, 0b111U) << "asked anew";
}

TEST(RealtimeLoop, TimingIsPublishedOnceASecond) {
  LoopRig rig;
  rig.push_at(60, references(Channel::one, 1000));
  rig.bus.lateness = [](can::Time) { return microseconds(5); };
  unsigned published = 0;
  TimingSnapshot timing;
  rig.bus.on_sleep = [&, play = rig.bus.on_sleep](can::Time now) {
    if (rig.exchange.timing.read(timing)) ++published;
    play(now);
  };
  rig.run_until(3100);
  EXPECT_EQ(published, 3U);
  EXPECT_EQ(timing.lateness_minimum, microseconds(5));
  EXPECT_EQ(timing.lateness_maximum, microseconds(5));
  EXPECT_GE(timing.histogram[3], 2900U) << "5 us lie in the bucket under 8 us";
  EXPECT_GE(timing.intervals, 2900U);
}

TEST(RealtimeLoop, BusLoadIsTheShareOfBits) {
  LoopRig rig;
  rig.push_at(60, references(Channel::one, 1000));
  std::uint64_t bits = 0;
  rig.run_until(1002);
  TimingSnapshot timing;
  ASSERT_TRUE(rig.exchange.timing.read(timing));
  // Everything sent in the first second and answered: what the bus itself saw.
  for (const auto& sent : rig.bus.sent) {
    if (sent.at >= rig.first_sync() + std::chrono::seconds(1)) continue;
    bits += can::frame_bits(sent.frame);
    if (const auto reply = rig.bus.answer(sent.frame)) bits += can::frame_bits(*reply);
  }
  EXPECT_NEAR(timing.bus_load, static_cast<double>(bits) / 1000.0, 2.0);
  EXPECT_GT(timing.bus_load, 150U);
}

// --- answers are never lost

/// Settings under which slaves that never answer keep their jobs.
cansync::MasterSettings patient_settings() {
  cansync::MasterSettings settings = master_settings(3);
  settings.startup.lost_after = 255;
  return settings;
}

TEST(RealtimeLoop, StopAnswersEveryOpenJobAndEveryWaitingRequest) {
  LoopRig rig(virtual_time(), patient_settings());
  rig.bus.answer = [](const can::Frame&) { return std::nullopt; };
  std::array<std::uint8_t, 100> memory = {};
  rig.push_at(50, read_request(1, 0, 1000));
  cansync::TransferRequest transfer;
  transfer.id = 2;
  transfer.slave = slave(1);
  transfer.address = 0x1000;
  transfer.data = memory;
  rig.push_at(50, transfer);
  // These wait when the stop comes: the loop never takes them.
  rig.at(60, microseconds(0), [&] { rig.loop.request_stop(); });
  rig.push_at(60, read_request(3, 0, 1001));
  rig.push_at(60, ModeRequest{4, Mode::run, false});
  transfer.id = 5;
  rig.push_at(60, transfer);
  rig.push_at(60, cansync::ReferenceUpdate{});
  rig.run_until(60);
  EXPECT_EQ(rig.answer_to<ParameterDone>(1).result.outcome, Outcome::master_stopped);
  EXPECT_EQ(rig.answer_to<TransferDone>(2).result.outcome, Outcome::master_stopped);
  EXPECT_EQ(rig.answer_to<ParameterDone>(3).result.outcome, Outcome::master_stopped);
  EXPECT_EQ(rig.answer_to<CommandDone>(4).outcome, Outcome::master_stopped);
  EXPECT_EQ(rig.answer_to<TransferDone>(5).result.outcome, Outcome::master_stopped);
  EXPECT_EQ(rig.terminals.size(), 5U);
  EXPECT_EQ(rig.snapshot().state, State::start_up);
  EXPECT_TRUE(rig.exchange.gateway_wake.wait(milliseconds(0)));
}

TEST(RealtimeLoop, CancelledJobsAnswerOnceAndUnknownOnesNotAtAll) {
  LoopRig rig(virtual_time(), patient_settings());
  rig.bus.answer = [](const can::Frame&) { return std::nullopt; };
  rig.push_at(50, read_request(1, 0, 1000));
  rig.push_at(55, Cancel{1});
  rig.push_at(56, Cancel{1});
  rig.push_at(57, Cancel{77});
  rig.run_until(100);
  EXPECT_EQ(rig.answer_to<ParameterDone>(1).result.outcome, Outcome::cancelled);
  EXPECT_EQ(rig.terminals.size(), 1U);
}

TEST(RealtimeLoop, AHangingGatewayLosesNoAnswer) {
  ExchangeSizes sizes;
  sizes.requests = 16;
  sizes.terminals = 8;
  LoopRig rig(virtual_time(), master_settings(3), sizes);
  rig.gateway_reads = false;
  cansync::JobId accepted = 0;
  unsigned full = 0;
  for (unsigned n = 50; n < 150; ++n) {
    rig.at(n, microseconds(0), [&] {
      if (rig.exchange.requests.try_push(read_request(accepted + 1, 0, 1000))) {
        ++accepted;
      } else {
        ++full;
      }
    });
  }
  rig.at(200, microseconds(0), [&] {
    EXPECT_EQ(rig.exchange.terminals.size(), 8U) << "full, and nothing more is taken";
    EXPECT_EQ(rig.exchange.requests.size(), 16U);
    rig.gateway_reads = true;
  });
  rig.run_until(300);
  EXPECT_EQ(accepted, 24U) << "what both rings hold";
  EXPECT_EQ(full, 76U) << "the gateway is told at once";
  EXPECT_EQ(rig.terminals.size(), 24U);
  for (cansync::JobId id = 1; id <= accepted; ++id) {
    EXPECT_EQ(rig.answer_to<ParameterDone>(id).result.outcome, Outcome::done) << id;
  }
  EXPECT_EQ(rig.snapshot().lost_reports, 0U);
}

TEST(RealtimeLoop, ReportsThatFindNoRoomAreCounted) {
  ExchangeSizes sizes;
  sizes.reports = 2;
  LoopRig rig(virtual_time(), master_settings(3), sizes);
  rig.gateway_reads = false;
  rig.run_until(100);
  EXPECT_EQ(rig.reports.size(), 2U);
  EXPECT_GT(rig.snapshot().lost_reports, 3U);
}

}  // namespace
