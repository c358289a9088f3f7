#include <gtest/gtest.h>
#include <unistd.h>

#include "support/gateway_rig.h"

namespace cansyncd {
namespace {

using gateway::dds::text;

TEST(GatewayCommonState, GatewayStatusTellsWhichDaemonItIs) {
  Config config = gateway_config();
  config.dds.interface = "lo";
  config.access.read_only = true;
  GatewayRig rig(config);
  const auto status = rig.client.wait_for<gateway_GatewayStatus>([](const auto&) { return true; });
  ASSERT_TRUE(status);
  std::array<char, 256> host = {};
  ASSERT_EQ(gethostname(host.data(), host.size() - 1), 0);
  EXPECT_EQ(text(status->bus), "testbus");
  EXPECT_EQ(status->data_model, static_cast<unsigned>(gateway_DATA_MODEL));
  EXPECT_EQ(text(status->protocol), "cansync-master");
  EXPECT_NE(text(status->version), "");
  EXPECT_TRUE(std::equal(kTestDaemon.begin(), kTestDaemon.end(), status->daemon));
  EXPECT_EQ(text(status->host), std::string_view(host.data()).substr(0, sizeof status->host - 1));
  EXPECT_EQ(status->process, static_cast<std::uint32_t>(getpid()));
  EXPECT_EQ(text(status->dds_interface), "lo");
  EXPECT_TRUE(status->read_only);
  EXPECT_FALSE(status->secured);

  // It comes at once when the configuration changes it, and by itself every second.
  config.access.read_only = false;
  rig.gateway->reload(config);
  ASSERT_TRUE(rig.client.wait_for<gateway_GatewayStatus>([](const auto& s) { return !s.read_only; }));
  const std::size_t before = rig.client.all<gateway_GatewayStatus>().size();
  ASSERT_TRUE(eventually(rig.client.signal(),
                         [&] { return rig.client.all<gateway_GatewayStatus>().size() >= before + 2; }));
}

TEST(GatewayCommonState, WhatWaitsForARestartIsShownAndOneEventForEachChange) {
  GatewayRig rig(gateway_config());
  const PendingRestart library{"", "replaced on disk since the start: libddsc.so.0debian"};
  const PendingRestart both{"1.1-1", "cansyncd 1.1-1 is installed, 1.0-1 runs"};
  for (const PendingRestart& pending : {PendingRestart(), library, library, both}) {
    rig.gateway->set_pending_restart(pending);
    ASSERT_TRUE(rig.client.wait_for<gateway_GatewayStatus>(
        [&](const auto& s) { return text(s.restart_reason) == pending.reason; }));
  }
  EXPECT_EQ(text(rig.client.all<gateway_GatewayStatus>().back().installed_version), "1.1-1");
  std::vector<std::string> told;
  for (const gateway_Event& event : rig.client.events(2)) {
    if (text(event.code) == "restart_pending") told.emplace_back(text(event.text));
  }
  ASSERT_EQ(told.size(), 2u);
  EXPECT_EQ(told[0], library.reason + ": restart the daemon when the line may stop");
  EXPECT_EQ(told[1], both.reason + ": restart the daemon when the line may stop");
}

TEST(GatewayCommonState, RealtimeStatusTellsHowTheTimelineFollows) {
  Config config = gateway_config();
  config.sync.output = SyncOutput::gpio;
  config.sync.input = SyncInput::pps;
  GatewayRig rig(config);
  MasterSnapshot master;
  master.when = moment(7);
  master.sync = {sync_line::LockState::holdover,
                 std::chrono::nanoseconds(-250),
                 std::chrono::milliseconds(40),
                 11,
                 3,
                 0};
  rig.tell(master);
  const auto status = rig.client.wait_for<gateway_RealtimeStatus>(
      [](const auto& s) { return text(s.sync_state) == "holdover"; });
  ASSERT_TRUE(status);
  EXPECT_EQ(text(status->sync_output), "gpio");
  EXPECT_EQ(text(status->sync_input), "pps");
  EXPECT_EQ(status->sync_phase_error, -250);
  EXPECT_EQ(status->sync_holdover, 40'000'000u);
  EXPECT_EQ(status->sync_edges, 11u);
  EXPECT_EQ(status->sync_rejected_edges, 3u);
}

TEST(GatewayCommonState, RealtimeStatusTellsWhatTheThreadWasGranted) {
  rt::RealtimeSettings wanted;
  wanted.enforce = false;
  wanted.priority = 70;
  wanted.cpu = 2;
  rt::Grants granted;
  granted.memory_locked = true;
  granted.affinity = true;
  granted.cpu_held_awake = true;
  GatewayRig rig(gateway_config(), {}, wanted, granted);
  const auto status = rig.client.wait_for<gateway_RealtimeStatus>([](const auto&) { return true; });
  ASSERT_TRUE(status);
  EXPECT_FALSE(status->realtime_enforced);
  EXPECT_EQ(status->realtime_priority, 0) << "not granted";
  EXPECT_EQ(status->realtime_priority_wanted, 70);
  EXPECT_EQ(status->realtime_cpu, 2);
  EXPECT_EQ(status->realtime_cpu_wanted, 2);
  EXPECT_TRUE(status->memory_locked);
  EXPECT_TRUE(status->memory_lock_wanted);
  EXPECT_TRUE(status->cpu_held_awake);
}

TEST(GatewayCommonState, BusStatusTellsInterfaceControllerAndCounts) {
  GatewayRig rig;
  MasterSnapshot master;
  master.controller.state = can::ControllerState::error_passive;
  master.controller.link = can::LinkState::wrong_bit_rate;
  master.controller.delivery = can::Delivery::unacknowledged;
  master.controller.bits_per_second = 500'000;
  master.controller.transmit_errors = 130;
  master.controller.error_frames = 1;
  master.controller.acknowledge_errors = 2;
  master.controller.restarts = 3;
  master.controller.queue_full = 4;
  master.controller.overruns = 5;
  master.controller.dropped = 6;
  master.timestamps = can::TimestampSource::hardware;
  rig.tell(master);
  const auto comes = [&rig](std::string_view state) {
    return rig.client.wait_for<gateway_BusStatus>(
        [state](const auto& s) { return text(s.link_state) == state; });
  };
  const auto status = comes("wrong-bit-rate");
  ASSERT_TRUE(status) << "the interface comes before what becomes of the frames";
  EXPECT_EQ(text(status->bus_interface), "sim");
  EXPECT_EQ(status->sample_point_wanted, 600u) << "the PLC's preset";
  EXPECT_EQ(text(status->controller_state), "error-passive");
  EXPECT_EQ(text(status->timestamp_source), "hardware");
  EXPECT_EQ(status->interface_bit_rate, 500'000u);
  EXPECT_EQ(status->sample_point, 0u) << "not known";
  EXPECT_EQ(status->restart_time, -1) << "not known";
  EXPECT_EQ(status->transmit_errors, 130u);
  EXPECT_EQ(status->error_frames, 1u);
  EXPECT_EQ(status->acknowledge_errors, 2u);
  EXPECT_EQ(status->restarts, 3u);
  EXPECT_EQ(status->queue_full, 4u);
  EXPECT_EQ(status->overruns, 5u);
  EXPECT_EQ(status->dropped_frames, 6u);
  master.controller.link = can::LinkState::up;
  rig.tell(master);
  EXPECT_TRUE(comes("unacknowledged"));

  can::LinkFacts link;
  link.timing = can::LinkTiming{500'000, 875};
  link.restart_ms = 100;
  link.queue_length = 10;
  rig.exchange.link.write(link);
  rig.exchange.gateway_wake.signal();
  const auto known =
      rig.client.wait_for<gateway_BusStatus>([](const auto& s) { return s.restart_time == 100; });
  ASSERT_TRUE(known);
  EXPECT_EQ(known->sample_point, 875u);
  EXPECT_EQ(known->queue_length, 10u);
}

TEST(GatewayCommonState, AnotherAdapterIsToldWithBoth) {
  Config config = gateway_config();
  config.bus.adapter = "serial=A";
  GatewayRig rig(config);
  can::LinkFacts link;
  link.adapter.path = {'p', 'c', 'i'};
  link.adapter.serial = {'B'};
  rig.exchange.link.write(link);
  rig.report(LinkChanged{moment(3), can::LinkState::up, can::LinkState::wrong_adapter, 0, 0});
  const auto event =
      rig.client.wait_for<gateway_Event>([](const auto& e) { return text(e.code) == "wrong_adapter"; });
  ASSERT_TRUE(event);
  EXPECT_NE(
      std::string_view(event->text).find("the adapter path=pci,serial=B,channel=0, bus.adapter is serial=A"),
      std::string_view::npos)
      << event->text;
  const auto status =
      rig.client.wait_for<gateway_BusStatus>([](const auto& s) { return !text(s.adapter).empty(); });
  ASSERT_TRUE(status);
  EXPECT_EQ(text(status->adapter), "path=pci,serial=B,channel=0");
  EXPECT_EQ(text(status->adapter_wanted), "serial=A");
}

TEST(GatewayCommonState, TheLast100EventsOfALevelAreThereForOneWhoComesLate) {
  GatewayRig rig;
  using Code = cansync::MasterEvent::Code;
  for (int round = 0; round < 4; ++round) {
    for (std::uint8_t i = 0; i < cansync::kSlaves; ++i)
      rig.report(EventReport{moment(i), {Code::slave_lost, slave(i), 0}});
  }
  ASSERT_TRUE(rig.client.wait_for<gateway_Event>([](const auto& e) { return e.number == 128; }));

  TestClient late(rig.places().there);
  ASSERT_TRUE(late.wait_for<gateway_Event>([](const auto& e) { return e.number == 128; }));
  const auto& events = late.all<gateway_Event>();
  ASSERT_EQ(events.size(), 100u);
  for (std::size_t i = 0; i < events.size(); ++i) EXPECT_EQ(events[i].number, 29 + i);
  EXPECT_EQ(text(events[99].code), "slave_lost");
  EXPECT_EQ(events[99].severity, gateway_SEVERITY_ERROR);
  EXPECT_EQ(events[99].slave, 31);
  EXPECT_EQ(events[99].time, moment(31).wall_clock.count());
  // Slave 3 of the last round has a name.
  EXPECT_EQ(text(events[71].text).substr(0, 18), "slave 3 'rewinder'");
}

TEST(GatewayCommonState, SkippedSyncEdgesAreToldOnce) {
  GatewayRig rig;
  for (cansync::IntervalNumber n = 1; n <= 20; ++n) rig.report(SyncsMissed{moment(n), 3});
  rig.report(StateChanged{moment(21)});
  const auto told =
      rig.client.wait_for<gateway_Event>([](const auto& e) { return text(e.code) == "state_changed"; });
  ASSERT_TRUE(told);
  const auto events = rig.client.events(told->number);
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(text(events[0].code), "syncs_missed");
  EXPECT_EQ(events[0].interval, 1u);
}

}  // namespace
}  // namespace cansyncd
