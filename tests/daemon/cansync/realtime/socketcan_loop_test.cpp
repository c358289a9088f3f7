// The realtime loop on the SocketCAN bus, with a kernel that is made of a simulated line in virtual time.
#include <gtest/gtest.h>
#include <linux/can/error.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "cansync/telegram/telegram.h"
#include "socketcan_rig.h"

namespace cansyncd::test {
namespace {

TEST(SocketcanLoop, ReceivesExactlyWhatTheMasterNeeds) {
  cansync::MasterSettings settings;
  settings.startup.census = false;
  settings.slaves[2].configured = true;
  settings.slaves[31].configured = true;
  Config config = config_for(settings);
  EXPECT_EQ(bus_plan(config).filters.size(), 10u);
  config.sync.input = SyncInput::can;
  config.sync.can_identifier = 0x080;
  const auto passed = [&config] {
    const auto filters = bus_plan(config).filters;
    std::vector<std::uint32_t> all;
    for (std::uint32_t id = 0; id <= 0x7FF; ++id) {
      if (std::any_of(filters.begin(), filters.end(),
                      [id](const auto& filter) { return (id & filter.mask) == filter.identifier; }))
        all.push_back(id);
    }
    return all;
  };
  std::vector<std::uint32_t> expected = {0x010, 0x080};
  for (std::uint32_t id = 0x100; id < 0x200; ++id) expected.push_back(id);
  expected.insert(expected.end(), {0x302, 0x31F, 0x382, 0x39F});
  for (std::uint32_t id = 0x500; id < 0x580; ++id) expected.push_back(id);
  std::vector<std::uint32_t> counting = expected;
  expected.insert(expected.end(), {0x582, 0x59F});
  EXPECT_EQ(passed(), expected);
  config.master.startup.census = true;
  for (std::uint32_t id = 0x580; id < 0x600; ++id) counting.push_back(id);
  EXPECT_EQ(passed(), counting) << "every number that the census asks may answer";
}

TEST(SocketcanLoop, SystemCallsOfAnIntervalAreCounted) {
  constexpr std::uint64_t kFrom = 400;
  constexpr std::uint64_t kIntervals = 1000;
  Rig rig;
  unsigned wakes = 0;
  unsigned wakes_after = 0;
  unsigned readings = 0;
  // A gateway that takes every signal at once makes the thread signal as often as it can.
  rig.kernel.on_sleep = [&] {
    wakes += rig.exchange.gateway_wake.wait(std::chrono::milliseconds(0)) ? 1 : 0;
  };
  std::map<std::string, unsigned> before;
  std::map<std::string, unsigned> after;
  rig.on_edge = [&](std::uint64_t edge) {
    if (edge > 200) rig.give_references();
    // A command in every interval.
    if (edge > 200) {
      EXPECT_TRUE(rig.exchange.requests.try_push(cansync::ControlWordRequest{
          .id = edge, .slave = *cansync::SlaveNumber::from(edge % 4), .control_word = 7}));
      Terminal terminal;
      while (rig.exchange.terminals.try_pop(terminal)) {
      }
    }
    if (edge == kFrom) {
      before = rig.kernel.calls;
      rig.kernel.clock_readings = 0;
      wakes = 0;
    }
    if (edge == kFrom + kIntervals) {
      after = rig.kernel.calls;
      readings = rig.kernel.clock_readings;
      wakes_after = wakes;
    }
  };
  rig.run(kFrom + kIntervals);
  const auto calls = [&](const char* name) { return after[name] - before[name]; };
  EXPECT_EQ(calls("clock_nanosleep"), 4 * kIntervals);
  EXPECT_EQ(calls("recvmmsg"), 2 * kIntervals);
  EXPECT_EQ(calls("send"), 3 * kIntervals);
  EXPECT_GT(wakes_after, kIntervals);
  EXPECT_LE(wakes_after, 2 * kIntervals);  // with these 11, and one is left for a SYNC frame
  EXPECT_EQ(calls("bind"), 0u);
  EXPECT_EQ(calls("setsockopt"), 0u);
  EXPECT_EQ(readings, 14 * kIntervals) << "system calls, too, where the kernel has no other way";
  const MasterSnapshot snapshot = rig.snapshot();
  EXPECT_EQ(snapshot.counters.left_out, 0u);
  EXPECT_EQ(snapshot.missed_syncs, 0u);
}

TEST(SocketcanLoop, NothingIsLostByLookingTwiceAnInterval) {
  Rig rig;
  rig.on_edge = [&](std::uint64_t edge) {
    if (edge > 200) rig.give_references();
  };
  rig.run(1200);
  const MasterSnapshot snapshot = rig.snapshot();
  EXPECT_EQ(snapshot.responding.bits, 0xFu);
  EXPECT_EQ(snapshot.synchronized.bits, 0xFu);
  EXPECT_EQ(snapshot.counters.unexpected, 0u);
  EXPECT_EQ(snapshot.counters.second_master, 0u) << "the own echoes";
  EXPECT_EQ(snapshot.timestamps, can::TimestampSource::kernel);
  for (unsigned slave = 0; slave < 4; ++slave) {
    SlaveReport report;
    ASSERT_TRUE(rig.exchange.slave[slave].read(report));
    EXPECT_EQ(report.status.missed_actual, 0u) << "slave " << slave;
    EXPECT_EQ(report.status.unanswered, 0u) << "slave " << slave;
    EXPECT_GT(report.status.answers, 0u);
    ActualReport actual;
    ASSERT_TRUE(rig.exchange.actual[slave].read(actual));
    // Automatic polling: each of four slaves in every fourth interval.
    EXPECT_GE(actual.values.count[0], 240u);
    EXPECT_GE(actual.values.count[1], 240u);
  }
}

can_frame kernel_frame(canid_t id, std::uint8_t length) {
  can_frame frame{};
  frame.can_id = id;
  frame.len = length;
  return frame;
}

/// Runs a line with `frames` wrong frames more on the bus in each interval from number 300 to 1300, and
/// expects that it costs neither a look at the kernel nor a telegram. Returns how many of them were counted.
std::uint64_t flood(Rig& rig, unsigned frames) {
  std::map<std::string, unsigned> before;
  std::map<std::string, unsigned> after;
  std::uint64_t most = 0;
  std::uint64_t last = 0;
  const auto rejected = [&] {
    std::uint64_t sum = rig.latest.counters.unexpected;
    for (const std::uint64_t count : rig.latest.counters.rejected) sum += count;
    return sum;
  };
  rig.on_edge = [&](std::uint64_t edge) {
    if (edge > 200) rig.give_references();
    if (edge == 300) before = rig.kernel.calls;
    if (edge == 1300) after = rig.kernel.calls;
    if (edge < 300 || edge >= 1300) return;
    most = std::max(most, rejected() - last);
    last = rejected();
    rig.kernel.errors.clear();  // the kernel drops what its queue cannot hold
    constexpr std::array<canid_t, 4> kIdentifiers = {0x581, 0x59F, 0x301 | CAN_EFF_FLAG,
                                                     0x301 | CAN_RTR_FLAG};
    for (unsigned i = 0; i < frames; ++i)
      rig.kernel.errors.push_back(kernel_frame(kIdentifiers[i % kIdentifiers.size()], 1));
    if (edge == 700) {
      EXPECT_TRUE(rig.exchange.requests.try_push(cansync::ParameterRequest{
          .id = 7, .slave = *cansync::SlaveNumber::from(2), .number = *cansync::ParameterNumber::from(301)}));
    }
  };
  rig.run(1400);
  EXPECT_EQ(after["recvmmsg"] - before["recvmmsg"], 2000u) << "two looks an interval, as ever";
  EXPECT_EQ(after["clock_nanosleep"] - before["clock_nanosleep"], 4000u);
  EXPECT_LE(most, 2 * can::ReceiveBatch::kFrames) << "the work of an interval is bounded";
  EXPECT_EQ(rig.snapshot().counters.left_out, 0u);
  EXPECT_EQ(rig.snapshot().missed_syncs, 0u);
  return last;
}

TEST(SocketcanLoop, TwentyThousandWrongFramesASecondAreCountedByKindAndChangeNothing) {
  Rig rig;
  EXPECT_GT(flood(rig, 20), 19'000u);
  const cansync::MasterCounters counters = rig.snapshot().counters;
  const auto rejected = [&](cansync::DecodeError error) {
    return counters.rejected[static_cast<unsigned>(error)];
  };
  EXPECT_EQ(rejected(cansync::DecodeError::wrong_length), 10'000u);
  EXPECT_EQ(rejected(cansync::DecodeError::extended), 5'000u);
  EXPECT_EQ(rejected(cansync::DecodeError::remote), 5'000u);
  EXPECT_EQ(counters.unexpected, 0u);
  EXPECT_EQ(rig.snapshot().synchronized.bits, 0xFu);
  ASSERT_EQ(rig.terminals.count(7), 1u);
  EXPECT_EQ(std::get<ParameterDone>(rig.terminals.find(7)->second).result.outcome, cansync::Outcome::done);
}

TEST(SocketcanLoop, AFloodOverTheBitRateOfAnyBusIsBoundedWorkToo) {
  Rig rig;
  EXPECT_GT(flood(rig, 1000), 100'000u);
}

TEST(SocketcanLoop, AnInterfaceThatGoesAndReturnsIsReportedOnceEach) {
  Rig rig;
  rig.on_edge = [&](std::uint64_t edge) {
    if (edge > 200) rig.give_references();
    if (edge == 500) rig.link({});
    if (edge == 1500) {
      auto other = can::test::can0();
      other.index = 8;
      rig.link(other);
    }
  };
  rig.run(4000);
  const auto changes = rig.reported<LinkChanged>();
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_EQ(changes[0].to, can::LinkState::missing);
  EXPECT_EQ(changes[0].when.interval, 501u);
  EXPECT_EQ(changes[1].to, can::LinkState::up);
  EXPECT_GT(changes[1].left_out, 1000u);
  EXPECT_TRUE(rig.reported<SendingChanged>().empty()) << "the interface has told it already";
  EXPECT_EQ(rig.snapshot().state, cansync::State::active_master);
  EXPECT_EQ(rig.snapshot().responding.bits, 0xFu) << "the slaves are back without a restart";
  EXPECT_EQ(rig.snapshot().synchronized.bits, 0xFu);
}

TEST(SocketcanLoop, WithoutAnInterfaceAtTheStartItWaits) {
  Rig rig{can::LinkFacts{}};
  rig.on_edge = [&](std::uint64_t edge) {
    if (edge == 300) rig.link(can::test::can0());
  };
  rig.run(2500);
  const auto changes = rig.reported<LinkChanged>();
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_EQ(changes[0].to, can::LinkState::missing);
  EXPECT_EQ(changes[0].when.interval, 0u);
  EXPECT_EQ(changes[1].when.interval, 301u);
  EXPECT_EQ(rig.snapshot().state, cansync::State::active_master);
}

TEST(SocketcanLoop, AWrongBitRateStopsSendingAndSaysWhich) {
  Rig rig;
  rig.on_edge = [&](std::uint64_t edge) {
    if (edge == 300) rig.link(can::test::can0(500'000));
    if (edge == 301) rig.kernel.calls.clear();
  };
  rig.run(400);
  EXPECT_EQ(rig.kernel.calls["send"], 0u);
  const auto changes = rig.reported<LinkChanged>();
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].to, can::LinkState::wrong_bit_rate);
  EXPECT_EQ(changes[0].bits_per_second, 500'000u);
}

TEST(SocketcanLoop, FaultsOfTheBusAreToldOnTheEdgeAndCounted) {
  Rig rig;
  can_frame unacknowledged{};
  unacknowledged.can_id = CAN_ERR_FLAG | CAN_ERR_ACK;
  unacknowledged.len = 8;
  rig.on_edge = [&](std::uint64_t edge) {
    if (edge >= 300 && edge < 350) rig.kernel.errors.push_back(unacknowledged);
  };
  rig.run(4000);
  std::vector<BusFault> faults;
  for (const BusFault& fault : rig.reported<BusFault>()) {
    if (fault.kind == BusFaultKind::not_acknowledged) faults.push_back(fault);
  }
  ASSERT_EQ(faults.size(), 2u);
  EXPECT_FALSE(faults[0].over);
  EXPECT_EQ(faults[0].when.interval, 301u);
  EXPECT_TRUE(faults[1].over);
  EXPECT_EQ(faults[1].count, 50u);
  EXPECT_NEAR(static_cast<double>(faults[1].when.interval), 3351.0, 2.0);
  EXPECT_EQ(rig.snapshot().controller.acknowledge_errors, 50u);
}

TEST(SocketcanLoop, AResetIsAnsweredOnceWhenTheWatchHasDoneIt) {
  Rig rig;
  rig.links.facts.state = can::ControllerState::bus_off;
  const ModeRequest first{1, Mode::reset_can, false};
  const ModeRequest second{2, Mode::reset_can, false};
  const ModeRequest third{3, Mode::reset_can, false};
  rig.on_edge = [&](std::uint64_t edge) {
    if (edge == 300) {
      EXPECT_TRUE(rig.exchange.requests.try_push(first));
    }
    if (edge == 310) {
      EXPECT_TRUE(rig.exchange.requests.try_push(second));
    }
    if (edge == 320) {
      EXPECT_TRUE(rig.terminals.empty());
    }
    if (edge == 350) rig.watch.look();
    if (edge == 400) {
      rig.links.facts.state = can::ControllerState::bus_off;
      rig.links.restart_result = -EPERM;
      EXPECT_TRUE(rig.exchange.requests.try_push(third));
    }
    if (edge == 410) rig.watch.look();
  };
  rig.run(500);
  ASSERT_EQ(rig.terminals.size(), 3u);
  EXPECT_TRUE(std::holds_alternative<CommandDone>(rig.terminals.find(1)->second));
  EXPECT_EQ(std::get<Refused>(rig.terminals.find(2)->second).refusal, cansync::Refusal::queue_full);
  EXPECT_EQ(std::get<Refused>(rig.terminals.find(3)->second).refusal, cansync::Refusal::not_permitted);
}

TEST(SocketcanLoop, AResetThatNobodyDoesEnds) {
  Rig rig;
  const ModeRequest stuck{1, Mode::reset_can, false};
  const ModeRequest open{2, Mode::reset_can, false};
  rig.on_edge = [&](std::uint64_t edge) {
    if (edge == 300) {
      EXPECT_TRUE(rig.exchange.requests.try_push(stuck));
    }
    if (edge == 5900) {
      EXPECT_TRUE(rig.exchange.requests.try_push(open));
    }
  };
  rig.run(6000);
  ASSERT_EQ(rig.terminals.size(), 2u);
  EXPECT_EQ(std::get<Refused>(rig.terminals.find(1)->second).refusal, cansync::Refusal::bus_unavailable);
  EXPECT_EQ(std::get<CommandDone>(rig.terminals.find(2)->second).outcome, cansync::Outcome::master_stopped);
}

TEST(SocketcanLoop, AFullQueueLeavesTheTelegramOut) {
  Rig rig;
  rig.on_edge = [&](std::uint64_t edge) {
    if (edge > 200) rig.give_references();
    rig.kernel.send_error = edge >= 400 && edge < 410 ? -ENOBUFS : 0;
    if (edge == 400 || edge == 410) rig.kernel.calls.clear();
    if (edge == 409) {
      EXPECT_LE(rig.kernel.calls["send"], 27u) << "each telegram once";
    }
  };
  rig.run(600);
  const auto changes = rig.reported<SendingChanged>();
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_EQ(changes[0].result, can::SendResult::queue_full);
  EXPECT_EQ(changes[1].result, can::SendResult::queued);
  EXPECT_EQ(changes[1].failed, rig.snapshot().controller.queue_full);
  EXPECT_GE(rig.snapshot().controller.queue_full, 20u);
}

}  // namespace
}  // namespace cansyncd::test
