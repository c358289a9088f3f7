#include "master_rig.h"

namespace cansync::test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

MasterSettings listening_for(Duration listen, OnSecondMaster in_run = OnSecondMaster::report) {
  MasterSettings settings = settings_for(2);
  settings.startup.listen = listen;
  settings.startup.on_second_master = in_run;
  return settings;
}

/// A line on which intervals pass as the realtime loop makes them: with an edge only where the master may.
struct Line : MasterRig {
  using MasterRig::MasterRig;

  void initialise() {
    static_cast<void>(master.control(ControlCommand::handshake));
    static_cast<void>(master.control(ControlCommand::take_over_initialisation));
  }
  void pass() {
    sent.clear();
    if (is_synchronous(master.state()) && !master.silent()) return step();
    master.pass_interval(next_interval++);
    for (const Slot slot : {Slot::reference_one, Slot::reference_two, Slot::command})
      EXPECT_FALSE(master.take(slot));
  }
  void pass(unsigned intervals) {
    for (unsigned i = 0; i < intervals; ++i) pass();
  }
  Refusal start(bool force = false) {
    initialise();
    return master.control(ControlCommand::start_synchronous, force);
  }
  /// Passes intervals until the start is not refused; how many.
  unsigned pass_until_started(unsigned most = 10'000) {
    unsigned n = 0;
    while (start() != Refusal::none && n < most) {
      pass();
      ++n;
    }
    return n;
  }
  void run_up() {
    pass_until_started();
    for (unsigned n = 0; n < 200 && master.control(ControlCommand::enable_active) != Refusal::none; ++n)
      pass();
    ASSERT_EQ(master.state(), State::active_master);
  }
  void other_sends() { master.receive(encode(ReferenceTelegram{}), microseconds(400)); }
};

TEST(SoleMaster, ListensBeforeItsFirstFrame) {
  Line line(listening_for(seconds(1)));
  EXPECT_EQ(line.start(), Refusal::listening);
  EXPECT_EQ(line.master.access(), BusAccess::listening);
  EXPECT_EQ(line.pass_until_started(), 1001u) << "1 s, and the interval in which it began";
  EXPECT_EQ(line.master.access(), BusAccess::granted);
  line.pass();
  EXPECT_EQ(line.sent.size(), 1u) << "activation";
}

TEST(SoleMaster, WithoutListeningItStartsAtOnceAndReportsOthersAlone) {
  Line line(listening_for(Duration{0}, OnSecondMaster::stop));
  EXPECT_EQ(line.start(), Refusal::none);
  line.master.bus_away();
  line.pass(3);
  line.other_sends();
  EXPECT_EQ(line.master.state(), State::setting_up_master);
  EXPECT_TRUE(line.master.second_master());
}

TEST(SoleMaster, AnotherMasterThatIsThereKeepsItSilentUntilThatOneWasQuietForThreeSeconds) {
  Line line(listening_for(seconds(1)));
  for (unsigned i = 0; i < 5000; ++i) {
    line.pass();
    line.other_sends();
    EXPECT_NE(line.start(), Refusal::none);
  }
  EXPECT_EQ(line.master.access(), BusAccess::other_master);
  EXPECT_EQ(line.master.second_master_identifier(), encode(ReferenceTelegram{}).id);
  EXPECT_EQ(line.start(), Refusal::other_master);
  EXPECT_EQ(line.told.count(MasterEvent::Code::second_master), 1u);
  EXPECT_EQ(line.told.events.back().found, static_cast<std::uint32_t>(BusAccess::other_master));
  EXPECT_EQ(line.pass_until_started(), 3001u);
  EXPECT_EQ(line.told.count(MasterEvent::Code::second_master_gone), 1u);
  EXPECT_EQ(line.master.counters().telegrams_sent, 0u);
}

TEST(SoleMaster, ASyncOfAnotherMasterKeepsItSilent) {
  Line line(listening_for(milliseconds(10)));
  line.master.other_sync();
  line.pass(20);
  EXPECT_EQ(line.start(), Refusal::other_master);
  EXPECT_EQ(line.master.second_master_identifier(), 0u);
}

TEST(SoleMaster, WhatSlavesSendIsNoMaster) {
  Line line(listening_for(milliseconds(10)));
  ActualTelegram actual;
  actual.slave = slave(1);
  line.master.receive(encode(actual), microseconds(400));
  line.pass(20);
  EXPECT_EQ(line.start(), Refusal::none);
}

TEST(SoleMaster, OneThatComesInSetUpEndsIt) {
  Line line(listening_for(milliseconds(10)));
  line.pass_until_started();
  line.pass();
  line.other_sends();
  EXPECT_EQ(line.master.state(), State::start_up);
  EXPECT_EQ(line.start(), Refusal::other_master);
  EXPECT_EQ(line.pass_until_started(), 3001u);
}

TEST(SoleMaster, InRunOneIsReportedAndTheLineGoesOn) {
  Line line(listening_for(milliseconds(10)));
  line.run_up();
  line.other_sends();
  EXPECT_EQ(line.master.state(), State::active_master);
  EXPECT_FALSE(line.master.silent());
  EXPECT_EQ(line.told.events.back().found, static_cast<std::uint32_t>(BusAccess::granted));
  EXPECT_EQ(line.master.control(ControlCommand::start_synchronous), Refusal::other_master)
      << "set-up does not accept it";
  EXPECT_EQ(line.master.control(ControlCommand::start_synchronous, true), Refusal::none);
  line.pass();
  EXPECT_EQ(line.master.state(), State::setting_up_master);
}

TEST(SoleMaster, InRunOneStopsTheLineWhenTheSettingsSaySo) {
  Line line(listening_for(milliseconds(10), OnSecondMaster::stop));
  line.run_up();
  ASSERT_EQ(line.master.submit(ParameterRequest{.id = 7, .slave = slave(0), .number = parameter(5)}),
            Refusal::none);
  line.other_sends();
  EXPECT_EQ(line.master.state(), State::start_up);
  EXPECT_EQ(line.told.parameters.at(7).outcome, Outcome::master_stopped);
  EXPECT_EQ(line.pass_until_started(), 3001u);
}

TEST(SoleMaster, ByForceItStartsBesideAnotherAndDoesNotStopForThatOne) {
  Line line(listening_for(seconds(1)));
  line.pass(10);
  line.other_sends();
  EXPECT_EQ(line.start(true), Refusal::none);
  line.pass();
  EXPECT_EQ(line.sent.size(), 1u);
  line.other_sends();
  EXPECT_EQ(line.master.state(), State::setting_up_master);
  line.pass(3002);  // it goes, and what comes then is another one
  EXPECT_FALSE(line.master.second_master());
  line.other_sends();
  EXPECT_EQ(line.master.state(), State::start_up);
}

TEST(SoleMaster, ByForceItDoesNotListenButAnotherThatComesLaterEndsSetUp) {
  Line line(listening_for(milliseconds(20)));
  EXPECT_EQ(line.start(true), Refusal::none);
  line.pass(30);
  EXPECT_EQ(line.master.state(), State::setting_up_master);
  line.other_sends();
  EXPECT_EQ(line.master.state(), State::start_up);
}

TEST(SoleMaster, ListeningCountsWhileTheBusIsThere) {
  Line line(listening_for(milliseconds(20)));
  line.master.bus_away();
  line.pass(1000);
  EXPECT_EQ(line.master.access(), BusAccess::away);
  EXPECT_EQ(line.start(), Refusal::listening);
  line.master.bus_returned();
  EXPECT_EQ(line.pass_until_started(), 21u);
}

TEST(SoleMaster, AfterTheBusWasAwayInRunItListensAndGoesOn) {
  Line line(listening_for(milliseconds(20)));
  line.run_up();
  line.master.bus_away();
  EXPECT_TRUE(line.master.silent());
  line.pass(100);
  line.master.bus_returned();
  unsigned silent = 0;
  while (line.master.silent() && silent < 100) {
    line.pass();
    ++silent;
  }
  EXPECT_EQ(silent, 21u);
  EXPECT_EQ(line.master.state(), State::active_master);
}

TEST(SoleMaster, AnotherThatIsThereWhenTheBusReturnsEndsRun) {
  Line line(listening_for(milliseconds(20)));
  line.run_up();
  line.master.bus_away();
  line.pass(100);
  line.master.bus_returned();
  line.pass(3);
  line.other_sends();
  EXPECT_EQ(line.master.state(), State::start_up);
  EXPECT_EQ(line.told.count(MasterEvent::Code::second_master), 1u);
}

}  // namespace
}  // namespace cansync::test
