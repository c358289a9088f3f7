#include <algorithm>

#include "support/loop_rig.h"

namespace cansyncd::test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

/// 125 kbit/s: an interval takes 8 ms, so that seconds are few of them.
cansync::MasterSettings listening_for(can::Time listen) {
  cansync::MasterSettings settings = master_settings(2);
  settings.bit_rate = cansync::BitRate::kbit125;
  settings.send_margin = cansync::default_send_margin(settings.bit_rate);
  settings.startup.listen = listen;
  return settings;
}

can::Frame masters_frame() {
  return cansync::encode(cansync::ReferenceTelegram{});
}

/// The loop's edges and frames so far.
std::size_t deeds(const LoopRig& rig) {
  return rig.bus.sent.size() + rig.bus.edges.size();
}

TEST(SoleMasterLoop, MakesNoEdgeAndSendsNoFrameBeforeItHasListened) {
  LoopRig rig(virtual_time(), listening_for(seconds(1)));
  rig.run_until(200);
  ASSERT_FALSE(rig.bus.sent.empty());
  ASSERT_FALSE(rig.bus.edges.empty());
  EXPECT_GE(rig.bus.edges.front().second - rig.began(), seconds(1));
  EXPECT_GE(rig.bus.sent.front().at - rig.began(), seconds(1));
  EXPECT_LE(rig.bus.sent.front().at - rig.began(), seconds(1) + 3 * rig.interval);
}

TEST(SoleMasterLoop, ListensAgainAfterBusOff) {
  LoopRig rig(virtual_time(), listening_for(milliseconds(200)));
  std::size_t before = 0;
  can::Time back{};
  rig.at(100, can::Time{0}, [&] { rig.bus.controller.state = can::ControllerState::bus_off; });
  rig.at(102, can::Time{0}, [&] {
    rig.bus.controller.state = can::ControllerState::error_active;
    back = rig.bus.now();
    before = deeds(rig);
  });
  rig.at(125, can::Time{0}, [&] { EXPECT_EQ(deeds(rig), before) << "184 ms are not over"; });
  rig.run_until(200);
  EXPECT_GT(deeds(rig), before);
  const auto first = std::find_if(rig.bus.sent.begin(), rig.bus.sent.end(),
                                  [&](const ScriptedBus::Sent& sent) { return sent.at >= back; });
  ASSERT_NE(first, rig.bus.sent.end());
  EXPECT_GE(first->at - back, milliseconds(200));
}

TEST(SoleMasterLoop, ABusOffBetweenTwoLooksCounts) {
  LoopRig rig(virtual_time(), listening_for(milliseconds(200)));
  std::size_t before = 0;
  rig.at(100, can::Time{0}, [&] { ++rig.bus.controller.restarts; });
  rig.at(102, can::Time{0}, [&] { before = deeds(rig); });
  rig.at(125, can::Time{0}, [&] { EXPECT_EQ(deeds(rig), before); });
  rig.run_until(200);
  EXPECT_GT(deeds(rig), before);
}

TEST(SoleMasterLoop, WaitsForACommandAfterAnotherMasterWhenTheSettingsSaySo) {
  LoopSettings loop = virtual_time();
  loop.after_other_master = AfterOtherMaster::command;
  LoopRig rig(loop, listening_for(milliseconds(100)));
  rig.at(5, can::Time{0}, [&] { rig.bus.put(masters_frame(), rig.bus.now()); });
  rig.push_at(100, ModeRequest{.id = 1, .mode = Mode::set_up});
  rig.at(600, can::Time{0}, [&] {
    EXPECT_EQ(deeds(rig), 0u);
    const MasterSnapshot snapshot = rig.snapshot();
    EXPECT_FALSE(snapshot.second_master);
    EXPECT_TRUE(snapshot.waits_for_command);
  });
  rig.push_at(600, ModeRequest{.id = 2, .mode = Mode::set_up});
  rig.run_until(700);
  EXPECT_EQ(rig.answer_to<Refused>(1).refusal, cansync::Refusal::other_master);
  EXPECT_EQ(rig.answer_to<CommandDone>(2).outcome, cansync::Outcome::done);
  EXPECT_GT(deeds(rig), 0u);
}

TEST(SoleMasterLoop, ByForceItBeginsBesideAnotherMaster) {
  LoopRig rig(virtual_time(StartTarget::none), listening_for(milliseconds(100)));
  rig.at(5, can::Time{0}, [&] { rig.bus.put(masters_frame(), rig.bus.now()); });
  rig.push_at(50, ModeRequest{.id = 1, .mode = Mode::set_up, .force = true});
  rig.run_until(60);
  EXPECT_GT(deeds(rig), 0u);
}

TEST(SoleMasterLoop, TellsSinceWhenAnotherMasterSends) {
  LoopRig rig(virtual_time(), listening_for(milliseconds(100)));
  for (unsigned n = 5; n < 20; ++n)
    rig.at(n, can::Time{0}, [&] { rig.bus.put(masters_frame(), rig.bus.now()); });
  can::Time began{};
  rig.at(6, can::Time{0}, [&] { began = rig.snapshot().second_master_since; });
  rig.run_until(20);
  const MasterSnapshot snapshot = rig.snapshot();
  EXPECT_EQ(snapshot.access, cansync::BusAccess::other_master);
  EXPECT_EQ(snapshot.second_master_identifier, masters_frame().id);
  EXPECT_NE(began, can::Time{0});
  EXPECT_EQ(snapshot.second_master_since, began) << "its first frame, not its newest";
}

TEST(SoleMasterLoop, InRunItStopsWithTheIntervalWhenTheSettingsSaySo) {
  cansync::MasterSettings settings = listening_for(milliseconds(100));
  settings.startup.on_second_master = cansync::OnSecondMaster::stop;
  LoopSettings loop = virtual_time();
  loop.look_at_every_slot = false;
  LoopRig rig(loop, settings);
  rig.bus.wakes_on_frame = false;
  can::Time came{};
  rig.at(100, microseconds(100), [&] {
    ASSERT_EQ(rig.snapshot().state, cansync::State::active_master);
    came = rig.bus.now();
    rig.bus.put(masters_frame(), came);
  });
  rig.run_until(200);
  ASSERT_NE(came, can::Time{0});
  for (const ScriptedBus::Sent& sent : rig.bus.sent) EXPECT_LT(sent.at, came + rig.interval);
  for (const auto& edge : rig.bus.edges) EXPECT_LT(edge.second, came + rig.interval);
}

TEST(SoleMasterLoop, LooksOnceMoreBeforeItsFirstEdge) {
  LoopSettings loop = virtual_time();
  loop.look_at_every_slot = false;
  const auto run = [&](std::optional<can::Time> other_sends) {
    LoopRig rig(loop, listening_for(milliseconds(100)));
    rig.bus.wakes_on_frame = false;
    if (other_sends) rig.bus.put(masters_frame(), *other_sends);
    rig.run_until(100);
    return rig.bus.edges;
  };
  const auto alone = run(std::nullopt);
  ASSERT_FALSE(alone.empty());
  EXPECT_TRUE(run(alone.front().second - microseconds(100)).empty());
}

TEST(SoleMasterLoop, LooksBeforeTheFirstEdgeAfterAStandstillOfItsThread) {
  cansync::MasterSettings settings = listening_for(milliseconds(100));
  settings.startup.on_second_master = cansync::OnSecondMaster::stop;
  LoopSettings loop = virtual_time();
  loop.look_at_every_slot = false;
  LoopRig rig(loop, settings);
  rig.bus.wakes_on_frame = false;
  can::Time came{};
  rig.at(99, can::Time{0}, [&] {
    ASSERT_EQ(rig.snapshot().state, cansync::State::active_master);
    came = rig.bus.now() + 3 * rig.interval;
    rig.bus.put(masters_frame(), came);
  });
  rig.bus.lateness = [&](can::Time deadline) {
    return deadline == rig.first_sync() + 100 * rig.interval ? 21 * rig.interval / 4 : can::Time{0};
  };
  rig.run_until(200);
  ASSERT_NE(came, can::Time{0});
  EXPECT_LT(rig.bus.edges.back().second, came);
}

}  // namespace
}  // namespace cansyncd::test
