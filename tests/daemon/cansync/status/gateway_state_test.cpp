#include <gtest/gtest.h>

#include "support/gateway_rig.h"

namespace cansyncd {
namespace {

using gateway::dds::text;

TEST(GatewayState, ActualValuesAreScaledAndNamed) {
  GatewayRig rig;
  MasterSnapshot master;
  master.when = moment(105);
  rig.tell(master);
  ActualReport report;
  report.when = moment(103);
  report.values.value = {static_cast<std::uint32_t>(-20), 7, 0, 0, 0, 0, 0, 0};
  report.values.arrived = {true, false};
  report.values.interval = {103, 0};
  report.values.count = {1, 0};
  rig.exchange.actual[1].write(report);
  rig.exchange.gateway_wake.signal();

  const auto sample = rig.client.wait_for<cansync_ActualValues>([](const auto& s) { return s.slave == 1; });
  ASSERT_TRUE(sample);
  EXPECT_EQ(text(sample->slave_name), "feeder");
  EXPECT_EQ(sample->raw[0], static_cast<std::uint32_t>(-20));
  EXPECT_DOUBLE_EQ(sample->scaled[0], 0.0);  // -20 * 0.5 + 10
  EXPECT_DOUBLE_EQ(sample->scaled[1], 7.0);
  EXPECT_EQ(sample->arrived, 1);
  EXPECT_EQ(sample->ever, 1);
  EXPECT_EQ(sample->interval[0], 103u);
  EXPECT_EQ(sample->age[0], 2u);
  EXPECT_EQ(sample->receive_time, moment(103).wall_clock.count());
}

TEST(GatewayState, TelegramsThatCameBetweenTwoLooksAreToldTogether) {
  GatewayRig rig;
  ActualReport report;
  report.values.count = {1, 0};
  report.values.arrived = {true, false};
  report.values.interval = {10, 0};
  rig.exchange.actual[2].write(report);
  report.values.count = {1, 1};
  report.values.arrived = {false, true};
  report.values.interval = {10, 11};
  rig.exchange.actual[2].write(report);
  rig.exchange.gateway_wake.signal();
  const auto both = rig.client.wait_for<cansync_ActualValues>([](const auto& s) { return s.ever == 3; });
  ASSERT_TRUE(both);
  EXPECT_TRUE(both->arrived == 3 || rig.client.all<cansync_ActualValues>().size() == 2);
}

TEST(GatewayState, MasterStatusComesEverySecond) {
  GatewayRig rig;
  MasterSnapshot master;
  master.when = moment(42);
  master.state = cansync::State::active_master;
  master.cansync_status = 0x0C;
  master.controller.transmit_errors = 3;
  master.configured = {0xF};
  master.responding = {0x7};
  master.synchronized = {0x3};
  master.open_parameter_jobs = 5;
  master.missed_syncs = 2;
  master.sync.output_failures = 4;
  rig.tell(master);
  const auto status =
      rig.client.wait_for<cansync_MasterStatus>([](const auto& s) { return s.option_status == 0x0080; });
  ASSERT_TRUE(status);
  EXPECT_EQ(status->cansync_status, 0x0C);
  EXPECT_EQ(status->interval_length, 1'000'000u);
  EXPECT_EQ(status->interval, 42u);
  EXPECT_EQ(status->slaves_configured, 0xFu);
  EXPECT_EQ(status->slaves_responding, 0x7u);
  EXPECT_EQ(status->slaves_synchronized, 0x3u);
  EXPECT_EQ(status->open_parameter_jobs, 5u);
  EXPECT_EQ(text(status->reference_value[2].name), "draw");
  EXPECT_EQ(text(status->serving), "work_conserving");
  EXPECT_TRUE(std::equal(kTestDaemon.begin(), kTestDaemon.end(), status->daemon));
  const auto bus =
      rig.client.wait_for<gateway_BusStatus>([](const auto& s) { return s.transmit_errors == 3; });
  ASSERT_TRUE(bus);
  EXPECT_EQ(bus->bit_rate, 1'000'000u);
  EXPECT_EQ(text(bus->controller_state), "error-active");
  const auto realtime =
      rig.client.wait_for<gateway_RealtimeStatus>([](const auto& s) { return s.missed_syncs == 2; });
  ASSERT_TRUE(realtime);
  EXPECT_EQ(text(realtime->sync_output), "none");
  EXPECT_EQ(text(realtime->sync_input), "none");
  EXPECT_EQ(text(realtime->sync_state), "") << "nothing is followed";
  EXPECT_EQ(realtime->sync_output_failures, 4u);

  // Nothing changes and nothing wakes the gateway: the next two come by themselves, a second apart.
  const std::size_t before = rig.client.all<cansync_MasterStatus>().size();
  const auto start = std::chrono::steady_clock::now();
  ASSERT_TRUE(eventually(rig.client.signal(),
                         [&] { return rig.client.all<cansync_MasterStatus>().size() >= before + 2; }));
  EXPECT_GE(std::chrono::steady_clock::now() - start, std::chrono::milliseconds(900));
}

TEST(GatewayState, MasterStatusComesAtOnceWhenSettingsChange) {
  GatewayRig rig;
  SettingsSnapshot settings;
  settings.polling[0] = {cansync::Cursor::Kind::fixed, slave(2)};
  settings.maximum_slave = slave(3);
  settings.reference_mapping[0].word[1] = {true, true, 3};
  settings.actual_mapping[1][1].word[0] = {true, false, 5};
  rig.exchange.settings.write(settings);
  rig.exchange.gateway_wake.signal();
  const auto status =
      rig.client.wait_for<cansync_MasterStatus>([](const auto& s) { return s.polling_one == 2; });
  ASSERT_TRUE(status);
  EXPECT_EQ(status->maximum_slave, 3);
  EXPECT_EQ(status->reference_mapping[1], 0x0F);
  EXPECT_TRUE(rig.client.wait_for<cansync_SlaveStatus>(
      [](const auto& s) { return s.slave == 1 && s.actual_mapping[4] == 0x15; }));
}

TEST(GatewayState, AMappingOfASlaveIsToldBeforeTheReplyToWhoHasChangedIt) {
  GatewayRig rig;
  SettingsSnapshot settings;
  for (std::uint8_t value = 1; value <= 3; ++value) {  // each sooner than the slave's status is due again
    auto command = TestClient::request<cansync_Command>(value);
    command.kind = cansync_COMMAND_ACTUAL_MAPPING;
    command.slave = 1;
    command.mapping[0] = static_cast<std::uint8_t>(value << 2 | 1);  // the low word of that value
    rig.client.write(command);
    const auto request = rig.expect_request<SetActualMapping>();
    settings.actual_mapping[1] = request.mapping;
    rig.exchange.settings.write(settings);
    rig.answer(CommandDone{request.id, cansync::Outcome::done});
    ASSERT_TRUE(rig.client.reply<cansync_CommandReply>(value));
    const auto& told = rig.client.all<cansync_SlaveStatus>();
    const auto newest = std::find_if(told.rbegin(), told.rend(), [](const auto& s) { return s.slave == 1; });
    ASSERT_NE(newest, told.rend());
    EXPECT_EQ(newest->actual_mapping[0], command.mapping[0]);
  }
}

/// When the newest sample that `fits` was written, of those that come; nothing: none did.
template <class T>
std::optional<dds_time_t> written(gateway::dds::Reader<T>& reader, gateway::dds::DataSignal& signal,
                                  const std::function<bool(const T&)>& fits) {
  std::optional<dds_time_t> time;
  (void)eventually(signal, [&] {
    (void)reader.take_batch([&](const T& sample, const dds_sample_info_t& info) {
      if (info.valid_data && fits(sample)) time = info.source_timestamp;
    });
    return time.has_value();
  });
  return time;
}

TEST(GatewayState, WhatAValueIsAfterAReloadIsToldBeforeTheFirstValueThatIsSo) {
  const TwoPlaces places;
  const gateway::dds::Participant daemon(places.here);
  const gateway::dds::Participant client(places.there);
  gateway::dds::DataSignal signal;
  gateway::dds::Reader<cansync_SlaveStatus> statuses(client, &signal);
  gateway::dds::Reader<cansync_ActualValues> values(client, &signal);
  Config config = gateway_config();
  StatePublisher publisher(daemon, config, kTestDaemon);
  Exchange exchange{ExchangeSizes()};
  const SteadyTime start = SteadyTime() + std::chrono::hours(1);
  (void)publisher.step(exchange, start);
  ASSERT_TRUE(eventually(signal, [&] { return values.matched() == 1 && statuses.matched() == 1; }));

  config.slaves[1].actual[0].factor = 2.0;
  publisher.set_names(config);
  ActualReport report;
  report.values.value[0] = 7;
  report.values.count = {1, 0};
  exchange.actual[1].write(report);
  (void)publisher.step(exchange, start + StatePublisher::kSlavePeriod / 10);
  const auto value = written<cansync_ActualValues>(values, signal,
                                                   [](const auto& s) { return s.scaled[0] == 7 * 2.0 + 10; });
  const auto status = written<cansync_SlaveStatus>(
      statuses, signal, [](const auto& s) { return s.slave == 1 && s.actual_value[0].factor == 2.0; });
  ASSERT_TRUE(value && status);
  EXPECT_LT(*status, *value);
}

TEST(GatewayState, TheWidthOfAValueFollowsTheMappingInForce) {
  GatewayRig rig;
  const auto first = rig.client.wait_for<cansync_SlaveStatus>([](const auto& s) { return s.slave == 1; });
  ASSERT_TRUE(first);
  EXPECT_EQ(first->actual_value[0].width, 32);
  EXPECT_TRUE(first->actual_value[0].is_signed);
  SettingsSnapshot settings;
  settings.reference_mapping[0].word[0] = {true, false, 1};
  settings.actual_mapping[1][0].word = {{{true, false, 0}, {true, true, 2}}};
  rig.exchange.settings.write(settings);
  rig.exchange.gateway_wake.signal();
  const auto word = rig.client.wait_for<cansync_SlaveStatus>(
      [](const auto& s) { return s.slave == 1 && s.actual_value[0].width == 16; });
  ASSERT_TRUE(word);
  EXPECT_EQ(word->actual_value[2].width, 32) << "a high word alone";
  EXPECT_EQ(word->actual_value[3].width, 32) << "not mapped";
  EXPECT_TRUE(rig.client.wait_for<cansync_MasterStatus>(
      [](const auto& s) { return s.reference_value[0].width == 32 && s.reference_value[1].width == 16; }));
}

TEST(GatewayState, SlaveStatusTellsTheNewestInTheEnd) {
  GatewayRig rig;
  // Every configured slave is told from the start, with its names.
  const auto first = rig.client.wait_for<cansync_SlaveStatus>([](const auto& s) { return s.slave == 1; });
  ASSERT_TRUE(first);
  EXPECT_EQ(text(first->name), "feeder");
  EXPECT_FALSE(first->responds);
  EXPECT_EQ(text(first->actual_value[0].unit_symbol), "1/min");
  EXPECT_DOUBLE_EQ(first->actual_value[0].factor, 0.5);

  constexpr std::uint64_t kChanges = 2000;
  const auto start = std::chrono::steady_clock::now();
  for (std::uint64_t i = 1; i <= kChanges; ++i) {
    SlaveReport report;
    report.status.configured = true;
    report.status.responds = true;
    report.status.answers = i;
    rig.exchange.slave[1].write(report);
    rig.exchange.gateway_wake.signal();
  }
  ASSERT_TRUE(rig.client.wait_for<cansync_SlaveStatus>(
      [](const auto& s) { return s.slave == 1 && s.answers == kChanges; }));
  const auto periods = (std::chrono::steady_clock::now() - start) / StatePublisher::kSlavePeriod;
  const auto& all = rig.client.all<cansync_SlaveStatus>();
  EXPECT_LE(
      std::count_if(all.begin(), all.end(), [](const auto& s) { return s.slave == 1 && s.answers > 0; }),
      periods + 2);
}

TEST(GatewayState, TimingIsPublished) {
  GatewayRig rig;
  TimingSnapshot timing;
  timing.intervals = 1000;
  timing.lateness_maximum = std::chrono::microseconds(37);
  timing.histogram[5] = 12;
  timing.left_out = {1, 2, 3};
  timing.bus_load = 456;
  timing.slots[static_cast<unsigned>(TelegramClass::actual_one)] = {
      7, std::chrono::microseconds(400), std::chrono::microseconds(410), std::chrono::microseconds(430), 9};
  timing.planned = {std::chrono::microseconds(300), std::chrono::microseconds(600),
                    std::chrono::microseconds(900)};
  MasterSnapshot master;
  master.timestamps = can::TimestampSource::kernel;
  rig.tell(master);
  const auto publish = [&] {
    rig.exchange.timing.write(timing);
    rig.exchange.gateway_wake.signal();
  };
  const auto sample =
      rig.client.ask_for<cansync_Timing>(publish, [](const auto& s) { return s.intervals == 1000; });
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->lateness_maximum, 37'000);
  EXPECT_EQ(sample->lateness_histogram[5], 12u);
  EXPECT_EQ(sample->left_out[2], 3u);
  const auto& seen = sample->slot[2];
  EXPECT_EQ(seen.count, 7u);
  EXPECT_EQ(seen.earliest, 400'000);
  EXPECT_EQ(seen.mean, 410'000);
  EXPECT_EQ(seen.latest, 430'000);
  EXPECT_EQ(seen.late, 9u);
  const std::array<std::int64_t, 6> latest{210'000, 350'000, 520'000, 650'000, 820'000, 950'000};
  const std::array<std::int64_t, 6> planned{-1, 300'000, -1, 600'000, -1, 900'000};
  for (std::size_t i = 0; i < latest.size(); ++i) {
    EXPECT_EQ(sample->slot[i].latest_start, latest[i]) << i;
    EXPECT_EQ(sample->slot[i].planned_start, planned[i]) << i;
  }
  EXPECT_EQ(text(sample->timestamp_source), "kernel");
  EXPECT_EQ(sample->bus_load, 456u);
}

TEST(GatewayState, IntervalIsPublishedOnlyWhenSwitchedOn) {
  for (const bool on : {true, false}) {
    Config config = gateway_config();
    config.dds.interval_topic = on;
    GatewayRig rig(config);
    TimingSnapshot timing;
    timing.intervals = 1;
    const auto publish = [&] {
      rig.exchange.interval.write({moment(9), std::chrono::microseconds(300)});
      rig.exchange.timing.write(timing);
      rig.exchange.gateway_wake.signal();
    };
    if (on) {
      const auto sample =
          rig.client.ask_for<cansync_Interval>(publish, [](const auto& s) { return s.number == 9; });
      ASSERT_TRUE(sample);
      EXPECT_EQ(sample->sync_time, moment(9).wall_clock.count());
      EXPECT_EQ(sample->time_left, 300'000);
      continue;
    }
    // Both readers are there, and what came of Timing proves that the gateway took the interval.
    ASSERT_TRUE(rig.client.ask_for<cansync_Timing>(publish, [](const auto& s) { return s.intervals == 1; }));
    EXPECT_TRUE(rig.client.all<cansync_Interval>().empty());
  }
}

TEST(GatewayState, ReloadPublishesNamesAndChangesTheLine) {
  GatewayRig rig;
  Config config = gateway_config();
  config.slaves[1].name = "infeed";
  config.slaves[1].actual[0].factor = 2.0;
  config.master.process.polling[1] = {cansync::Cursor::Kind::fixed, slave(1)};
  config.master.slaves[2].actual_mapping[0].word[0] = {true, false, 3};
  config.master.slaves[9].configured = true;  // needs a restart; ignored
  rig.gateway->reload(config);

  const auto mapping = rig.expect_request<SetActualMapping>();
  EXPECT_EQ(mapping.slave, slave(2));
  const auto polling = rig.expect_request<SetPolling>();
  EXPECT_FALSE(polling.polling[0]);
  EXPECT_EQ(polling.polling[1], config.master.process.polling[1]);
  const auto named = rig.client.wait_for<cansync_SlaveStatus>(
      [](const auto& s) { return s.slave == 1 && text(s.name) == "infeed"; });
  ASSERT_TRUE(named);
  EXPECT_DOUBLE_EQ(named->actual_value[0].factor, 2.0);
  ASSERT_TRUE(rig.client.wait_for<gateway_Event>(
      [](const auto& e) { return text(e.code) == "configuration_reloaded"; }));
  EXPECT_EQ(rig.exchange.requests.size(), 0u);

  // The line may refuse; nobody waits for a reply, so it is an event.
  rig.answer(Refused{mapping.id, cansync::Refusal::mapping});
  rig.answer(CommandDone{polling.id, cansync::Outcome::done});
  const auto refused = rig.client.wait_for<gateway_Event>(
      [](const auto& e) { return text(e.code) == "configuration_refused"; });
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->severity, gateway_SEVERITY_ERROR);
  // Read again without a change: nothing is to be done on the line.
  rig.gateway->reload(config);
  ASSERT_TRUE(eventually(rig.client.signal(), [&] {
    const auto& events = rig.client.all<gateway_Event>();
    return std::count_if(events.begin(), events.end(),
                         [](const auto& e) { return text(e.code) == "configuration_reloaded"; }) == 2;
  }));
  EXPECT_EQ(rig.exchange.requests.size(), 0u);
  // The remedy: the setting is corrected in the file, and the file read again.
  config.master.slaves[2].actual_mapping[0].word[0] = {true, false, 1};
  rig.gateway->reload(config);
  const auto corrected = rig.expect_request<SetActualMapping>();
  EXPECT_EQ(corrected.slave, slave(2));
  EXPECT_EQ(corrected.mapping, config.master.slaves[2].actual_mapping);
  rig.answer(CommandDone{corrected.id, cansync::Outcome::done});
}

}  // namespace
}  // namespace cansyncd
