#include <gtest/gtest.h>

#include <cerrno>

#include "daemon/cansync/requests/gateway_requests.h"
#include "daemon/cansync/texts/event_text.h"
#include "daemon/cansync/texts/refusal_text.h"
#include "daemon/desk/gateway_events.h"

namespace cansyncd {
namespace {

using cansync::Refusal;
using cansync::SlaveNumber;

Config line() {
  Config config;
  for (unsigned i = 0; i < 12; ++i) config.master.slaves[i].configured = true;
  config.slaves[1].name = "feeder";
  return config;
}

TEST(RefusalText, SlavesAreCalledByNumberAndName) {
  const Config config = line();
  EXPECT_EQ(slave_label(config, 1), "slave 1 'feeder'");
  EXPECT_EQ(slave_label(config, 2), "slave 2");
  EXPECT_EQ(slave_list(config, {0b110}), "slave 1 'feeder', slave 2");
  EXPECT_EQ(slave_list(config, {0}), "none");
  EXPECT_EQ(slave_list(config, {0xFFF}),
            "slave 0, slave 1 'feeder', slave 2, slave 3, slave 4, slave 5, slave 6, slave 7 and 4 more");
}

TEST(RefusalText, EachRefusalOfTheMasterSaysWhatIsAllowed) {
  const Config config = line();
  const RefusalContext context{cansync::State::setting_up_master, 5000, {0xFFE}, {0xFFC}};
  const auto text = [&](Refusal refusal, const Request& request) {
    return refusal_text(refusal, request, config, context);
  };
  EXPECT_EQ(
      text(Refusal::wrong_state, ModeRequest{1, Mode::run, false}),
      "state: the master is in setup (0x0043); run is entered from setup alone: give mode setup, then mode "
      "run");
  EXPECT_EQ(text(Refusal::slaves_missing, ModeRequest{1, Mode::run, false}),
            "slaves: not yet synchronized and released: slave 0, slave 1 'feeder'; wait for them, or give "
            "mode run with force");
  cansync::ReferenceUpdate update;
  EXPECT_EQ(
      text(Refusal::wrong_state, update),
      "state: the master is in setup (0x0043); reference values are taken in run (0x0080) alone: give mode "
      "run");
  const RefusalContext stopped{cansync::State::waiting_for_start, 5000, {0}, {0}};
  EXPECT_EQ(
      refusal_text(Refusal::wrong_state, update, config, stopped),
      "state: the master is in stop (0x0003); reference values are taken in run (0x0080) alone: give mode "
      "setup, then mode run");
  update.from_interval = 99;
  EXPECT_EQ(
      text(Refusal::interval_passed, update),
      "from_interval 99: allowed 0 (the next) or 5000..6000, which is the running interval and 1000 ahead");
  cansync::BroadcastRequest broadcast;
  broadcast.priority = 0;
  EXPECT_EQ(
      text(Refusal::queue_full, broadcast),
      "queue full: 8 broadcasts of priority 0 are open, at most 8 are allowed; try again when one has ended");
  cansync::TransferRequest transfer;
  transfer.slave = *SlaveNumber::from(1);
  transfer.block_size = 301;
  EXPECT_EQ(text(Refusal::block_size, transfer),
            "block_size 301: allowed 1..300 in whole start addresses (multiples of 1), 0 = 300");
  cansync::ParameterRequest read;
  read.slave = *SlaveNumber::from(20);
  EXPECT_EQ(text(Refusal::slave_not_configured, read).substr(0, 42),
            "slave 20: not configured; configured are s");
  EXPECT_NE(text(Refusal::queue_full, update), text(Refusal::queue_full, SetPolling{}));
}

TEST(RefusalText, AReferenceValueThatIsTooWideIsNamed) {
  RefusalContext context;
  context.reference_mapping[1].word[0] = {true, false, 5};
  cansync::ReferenceUpdate update;
  update.channel = cansync::Channel::two;
  update.value = {70'000, 70'000};
  update.valid_mask = 3;
  EXPECT_EQ(
      refusal_text(Refusal::value_too_wide, update, line(), context),
      "value[1] 70000: reference value 5 allows -32768..65535, because its low word alone is mapped; map its "
      "high word too, see `cansync map`");
  update.valid_mask = 1;
  EXPECT_EQ(refusal_text(Refusal::value_too_wide, update, line(), context).substr(0, 40),
            "value: one that keeps what it got under ");
}

TEST(EventText, ReportsBecomeEventsWithNames) {
  const Config config = line();
  const auto told = [&](const Report& report) { return *describe(report, config); };
  using Code = cansync::MasterEvent::Code;
  const auto lost = told(EventReport{{7, {}, {}}, {Code::slave_lost, SlaveNumber::from(1), 0}});
  EXPECT_EQ(lost.code, "slave_lost");
  EXPECT_EQ(lost.slave, 1);
  EXPECT_EQ(lost.severity, gateway_SEVERITY_ERROR);
  EXPECT_EQ(lost.text, "slave 1 'feeder' no longer responds; check its power and the bus cable");
  EXPECT_EQ(lost.when->interval, 7u);
  EXPECT_EQ(told(EventReport{{}, {Code::second_master, std::nullopt, 0x105}}).text,
            "another master sends on this bus (identifier 0x105); switch one of them off");
  EXPECT_EQ(
      told(EventReport{{},
                       {.code = Code::second_master,
                        .slave = std::nullopt,
                        .found = static_cast<std::uint32_t>(cansync::BusAccess::other_master)}})
          .text,
      "another master sends on this bus (a SYNC frame); the daemon sends nothing until that one has been "
      "quiet for 3 s; switch one of them off");
  EXPECT_EQ(told(EventReport{{}, {Code::references_stopped, std::nullopt, 2}}).text,
            "reference values of telegram 2 are no longer released");
  EXPECT_EQ(told(StateChanged{{},
                              cansync::State::waiting_for_start,
                              cansync::State::setting_up_master,
                              cansync::ControlCommand::start_synchronous})
                .code,
            "state_changed");
  EXPECT_EQ(told(SyncsMissed{{}, 12}).text.substr(0, 27), "12 SYNC edges were skipped:");
  const auto off =
      told(ControllerChanged{{}, can::ControllerState::error_passive, can::ControllerState::bus_off});
  EXPECT_EQ(off.severity, gateway_SEVERITY_ERROR);
  EXPECT_EQ(off.text, "CAN controller error-passive to bus-off");
  EXPECT_EQ(told(SendingChanged{{}, can::SendResult::bus_off, 0}).code, "sending_failed");
  EXPECT_EQ(told(SendingChanged{{}, can::SendResult::queued, 17}).text,
            "telegrams are sent again; 17 were left out");
  EXPECT_FALSE(describe(TransferProgress{1, 2}, config));
  EXPECT_FALSE(describe(ReferenceRefused{}, config));
}

TEST(EventTexts, OfSlavesThatComeAndGo) {
  using Code = cansync::MasterEvent::Code;
  Config config;
  config.slaves[2].name = "winder";
  const auto slave = cansync::SlaveNumber::from(2);
  const auto told = [&](const cansync::MasterEvent& event) {
    return *describe(EventReport{{}, event}, config);
  };
  const EventText lost = told({Code::slave_lost, slave, 3});
  EXPECT_EQ(lost.severity, gateway_SEVERITY_ERROR);
  EXPECT_EQ(lost.text,
            "slave 2 'winder' no longer responds, 3 of its jobs ended; check its power and the bus cable");
  EXPECT_EQ(told({Code::slave_lost, slave, 0}).text,
            "slave 2 'winder' no longer responds; check its power and the bus cable");
  EXPECT_EQ(told({Code::slave_returned, slave, 0}).text,
            "slave 2 'winder' responds again; it is held out until it is released");
  EXPECT_EQ(told({Code::slave_checked, slave, 4}).text,
            "slave 2 'winder' has the values of all its 4 return parameters");
  EXPECT_EQ(told({Code::slave_released, slave, 0}).text, "slave 2 'winder' is released");
  EXPECT_EQ(told({Code::slave_released, slave, 1}).text,
            "slave 2 'winder' is released by command, unchecked");
  cansync::MasterEvent failed{Code::slave_check_failed, slave, 1000, 5, 6};
  EXPECT_EQ(told(failed).severity, gateway_SEVERITY_ERROR);
  EXPECT_EQ(told(failed).text,
            "slave 2 'winder' stays held out: parameter 1000, expected 5 (0x5), found 6 (0x6); set it right, "
            "then: cansync release 2");
  failed.outcome = cansync::Outcome::slave_error;
  failed.found = 0xFFFC;
  EXPECT_NE(told(failed).text.find("expected 5 (0x5), slave error 0xFFFC;"), std::string::npos);
  failed.outcome = cansync::Outcome::timeout;
  EXPECT_NE(told(failed).text.find("expected 5 (0x5), timeout;"), std::string::npos);
  cansync::MasterEvent wrong{Code::wrong_drive, slave, 102, 1002, 1003};
  EXPECT_EQ(told(wrong).severity, gateway_SEVERITY_ERROR);
  EXPECT_EQ(told(wrong).parameter, 102);
  EXPECT_EQ(
      told(wrong).text,
      "slave 2 'winder' is not the drive expected and is held out: parameter 102, expected 1002 (0x3EA), "
      "found 1003 (0x3EB); connect the right drive, or correct its expect and reload, then: cansync release 2");
  EXPECT_EQ(told({Code::slave_identified, slave, 1}).text,
            "slave 2 'winder' is the drive expected: 1 parameter has its value");
  EXPECT_EQ(
      told({Code::duplicate_slave, slave}).text,
      "two drives answer as slave 2 'winder', which is held out; give each drive a number of its own, then: "
      "cansync release 2");
  EXPECT_EQ(
      told({Code::unknown_slave, SlaveNumber::from(9)}).text,
      "slave 9 answers and is not in the configuration; add it ([[slave]] with number = 9), or disconnect it: "
      "it receives the reference values of all");
  cansync::MasterEvent refused{Code::slave_status_refused,   slave, 301, 0, 0xFFFB,
                               cansync::Outcome::slave_error};
  EXPECT_EQ(told(refused).severity, gateway_SEVERITY_ERROR);
  EXPECT_EQ(
      told(refused).text,
      "slave 2 'winder' refuses its status word, parameter 301, with error 0xFFFB; set "
      "startup.status_parameter, or the slave's status_parameter, to the number in the drive's parameter "
      "list");
  refused.outcome = cansync::Outcome::timeout;
  EXPECT_NE(
      told(refused).text.find("does not give its status word, parameter 301: it answers busy for 5 s; set "),
      std::string::npos);
  refused.outcome = cansync::Outcome::no_answer;
  EXPECT_NE(told(refused).text.find(": it answers without a value for 5 s; set "), std::string::npos);
}

TEST(EventTexts, TheSyncLineIsToldWithItsRemedy) {
  using sync_line::LockState;
  Config config;
  config.sync.output = SyncOutput::gpio;
  config.sync.input = SyncInput::pps;
  const auto told = [&](const Report& report) { return *describe(report, config); };
  const auto change = [&](LockState from, LockState to, int milliseconds) {
    return told(SyncSourceChanged{{}, from, to, std::chrono::milliseconds(milliseconds)});
  };
  EXPECT_EQ(change(LockState::searching, LockState::locked, 0).text,
            "the timeline follows the external SYNC");
  const EventText missing = change(LockState::locked, LockState::holdover, 3);
  EXPECT_EQ(missing.code, "sync_holdover");
  EXPECT_EQ(missing.severity, gateway_SEVERITY_WARNING);
  EXPECT_EQ(
      missing.text,
      "edges of the external SYNC have been missing for 3.0 ms; the timeline holds over for up to 1000 ms");
  const EventText back = change(LockState::holdover, LockState::locked, 120);
  EXPECT_EQ(back.code, "sync_locked");
  EXPECT_EQ(back.text, "the timeline follows the external SYNC again; its edges were missing for 120.0 ms");
  EXPECT_EQ(change(LockState::holdover, LockState::lost, 1003).severity, gateway_SEVERITY_ERROR);
  EXPECT_EQ(change(LockState::holdover, LockState::lost, 1003).code, "sync_lost");
  EXPECT_EQ(change(LockState::locked, LockState::searching, 0).text,
            "the external SYNC has jumped; the timeline moves to its new phase");
  EXPECT_EQ(change(LockState::lost, LockState::searching, 0).severity, gateway_SEVERITY_INFO);
  EXPECT_EQ(
      told(SyncDeviceChanged{{}, false, ENODEV, 0}).text,
      "the SYNC input fails: /dev/pps0: No such device; plug the hardware in or load its driver, or name "
      "another device");
  EXPECT_EQ(told(SyncDeviceChanged{{}, true, 0, 7}).text,
            "the SYNC output works again; 7 edges could not be made since the start");
  EXPECT_EQ(told(SyncDeviceChanged{{}, true, EIO, 7}).code, "sync_output_failed");
}

TEST(FloodGuard, HoldsBackAndSumsUp) {
  FloodGuard guard;
  SteadyTime now{std::chrono::hours(1)};
  EventText event{gateway_SEVERITY_INFO, "references_stopped", -1, "", std::nullopt};
  for (unsigned i = 0; i < FloodGuard::kBurst; ++i) EXPECT_TRUE(guard.pass(event, now));
  for (int i = 0; i < 3; ++i) {
    event.text = "number " + std::to_string(i);
    EXPECT_FALSE(guard.pass(event, now));
  }
  // Others are not held back with it.
  EXPECT_TRUE(guard.pass({gateway_SEVERITY_INFO, "references_stopped", 3, "", std::nullopt}, now));
  EXPECT_TRUE(guard.pass({gateway_SEVERITY_INFO, "slave_lost", -1, "", std::nullopt}, now));
  EXPECT_FALSE(guard.due(now));
  ASSERT_TRUE(guard.next());
  now = *guard.next();
  const auto summary = guard.due(now);
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->text, "number 2 (the last of 3 within 1 s that were not told)");
  EXPECT_FALSE(guard.due(now));
  EXPECT_FALSE(guard.next());
  // The summary counts for the next second.
  for (unsigned i = 1; i < FloodGuard::kBurst; ++i) EXPECT_TRUE(guard.pass(event, now));
  EXPECT_FALSE(guard.pass(event, now));
}

/// How many events of a kind that comes `each` for `time` are told, sums included.
unsigned told_of(FloodGuard& guard, SteadyTime& now, std::chrono::milliseconds each,
                 std::chrono::hours time) {
  const EventText event{gateway_SEVERITY_ERROR, "slave_lost", 3, "", std::nullopt};
  unsigned told = 0;
  for (const SteadyTime end = now + time; now < end; now += each) {
    while (guard.due(now)) ++told;
    told += guard.pass(event, now) ? 1 : 0;
  }
  return told;
}

TEST(FloodGuard, ADayOfAKindThatRepeatsIsAFewHundredAndAFirstIsAlwaysTold) {
  FloodGuard guard;
  SteadyTime now{std::chrono::hours(1)};
  constexpr unsigned kMinutesOfADay = 24 * 60;
  EXPECT_NEAR(told_of(guard, now, std::chrono::milliseconds(1000), std::chrono::hours(24)),
              FloodGuard::kMost + kMinutesOfADay, 2);
  EXPECT_NEAR(told_of(guard, now, std::chrono::milliseconds(100), std::chrono::hours(24)), kMinutesOfADay, 2);
  ASSERT_TRUE(guard.next());
  EXPECT_LE(*guard.next() - now, FloodGuard::kRefill) << "what is held back is summed up";
  now = *guard.next();
  EXPECT_TRUE(guard.due(now));
  now += FloodGuard::kRefill;
  EXPECT_TRUE(guard.pass({gateway_SEVERITY_ERROR, "slave_lost", 3, "", std::nullopt}, now));
  now += FloodGuard::kMost * FloodGuard::kRefill;
  for (unsigned i = 0; i < FloodGuard::kMost; ++i, now += FloodGuard::kWindow)
    EXPECT_TRUE(guard.pass({gateway_SEVERITY_ERROR, "slave_lost", 3, "", std::nullopt}, now)) << i;
}

TEST(FloodGuard, TheLastThatIsToldOfASlaveIsTheLastThatHappened) {
  FloodGuard guard;
  SteadyTime now{std::chrono::hours(1)};
  std::string last;
  const auto happens = [&](bool lost, int slave) {
    EventText event{gateway_SEVERITY_ERROR, "slave_responds", slave, "", std::nullopt};
    if (lost) event.code = "slave_lost";
    if (!guard.pass(event, now)) return;
    while (const auto before = guard.held_of(slave, now)) last = before->code.word();
    last = event.code.word();
  };
  for (int second = 0; second < 3600; ++second, now += FloodGuard::kWindow) {
    while (const auto due = guard.due(now)) last = due->code.word();
    happens(true, 3);
    if (second % 3 != 0) happens(false, 3);  // so the two have other minutes
  }
  happens(true, 3);
  now += std::chrono::milliseconds(500);
  happens(false, 3);
  for (int i = 0; i < 3 && guard.next(); ++i) {
    now = *guard.next();
    while (const auto due = guard.due(now)) last = due->code.word();
  }
  EXPECT_EQ(last, "slave_responds");
  happens(true, 3);
  happens(true, 4);
  now += std::chrono::milliseconds(1);
  happens(false, 3);
  while (const auto left = guard.left(now)) last = left->code.word();
  EXPECT_EQ(last, "slave_responds") << "at the end all is told";
  EXPECT_FALSE(guard.next());
}

TEST(FaultRow, TellsTheFirstAndCountsTheOthers) {
  FaultRow row(std::chrono::seconds(10));
  SteadyTime now{std::chrono::hours(1)};
  EXPECT_FALSE(row.next());
  EXPECT_TRUE(row.add(2, now));
  now += std::chrono::seconds(9);
  EXPECT_EQ(row.take_over(now), 0u);
  EXPECT_FALSE(row.add(3, now));
  now += std::chrono::seconds(9);
  EXPECT_EQ(row.take_over(now), 0u);
  now += std::chrono::seconds(1);
  EXPECT_EQ(row.next(), now);
  EXPECT_EQ(row.take_over(now), 5u);
  EXPECT_EQ(row.take_over(now), 0u);
  EXPECT_FALSE(row.next());
  EXPECT_TRUE(row.add(1, now));
}

TEST(FaultRow, IsNotProlongedByLooksThatFindNothing) {
  FaultRow row(std::chrono::seconds(2));
  SteadyTime now{std::chrono::hours(1)};
  EXPECT_FALSE(row.add(0, now));
  EXPECT_TRUE(row.add(1, now));
  for (int look = 0; look < 2; ++look) {
    now += std::chrono::seconds(1);
    EXPECT_FALSE(row.add(0, now));
  }
  EXPECT_EQ(row.take_over(now), 1u);
  EXPECT_TRUE(row.add(1, now)) << "the next row is told again";
}

TEST(GatewayRequests, OnlyWhatChangesSomethingIsWorthALine) {
  const Config config = line();
  cansync::ParameterRequest parameter;
  parameter.slave = *SlaveNumber::from(1);
  parameter.number = *cansync::ParameterNumber::from(120);
  parameter.value = 500;
  EXPECT_FALSE(describe(parameter, config));
  parameter.write = true;
  EXPECT_EQ(describe(parameter, config), "write slave 1 'feeder' sub-slave 0 parameter 120 = 500 (0x1F4)");
  cansync::TransferRequest transfer;
  EXPECT_FALSE(describe(transfer, config));
  EXPECT_FALSE(describe(cansync::ReferenceUpdate{}, config));
  EXPECT_EQ(describe(ModeRequest{1, Mode::run, true}, config), "mode run with force");
  EXPECT_EQ(describe(cansync::ControlWordRequest{1, *SlaveNumber::from(2), 0xF}, config),
            "control word 0x000F to slave 2");
  SetReferenceMapping mapping;
  mapping.mapping[0].word[0] = {true, false, 3};
  EXPECT_EQ(describe(mapping, config), "mapping of the reference values 0D 00 00 00 00 00 00 00");
}

TEST(GatewayRequests, UnknownCommandsAreNoRequests) {
  cansync_Command command = {};
  command.kind = cansync_COMMAND_MODE;
  command.mode = static_cast<cansync_Mode>(7);
  EXPECT_FALSE(to_request(command, 1));
  command.kind = cansync_COMMAND_REFERENCE_MAPPING;
  command.mapping[3] = 0x80;
  EXPECT_FALSE(to_request(command, 1));
}

TEST(GatewayRequests, ChangesAreWhatDiffers) {
  const Config before = line();
  EXPECT_TRUE(changes(before, before).empty());
  Config after = before;
  after.master.process.reference_mapping[1].word[0] = {true, true, 7};
  after.master.command_channel.transfer = {cansync::Cursor::Kind::nobody, {}};
  after.master.slaves[30].actual_mapping[0].word[0] = {};  // not configured
  const auto requests = changes(before, after);
  ASSERT_EQ(requests.size(), 2u);
  EXPECT_EQ(std::get<SetReferenceMapping>(requests[0]).mapping, after.master.process.reference_mapping);
  const auto& cursors = std::get<SetCursors>(requests[1]);
  EXPECT_FALSE(cursors.control_word || cursors.parameter);
  EXPECT_EQ(cursors.transfer, after.master.command_channel.transfer);
}

}  // namespace
}  // namespace cansyncd
