#include <gtest/gtest.h>

#include <set>
#include <string>

#include "cli/doctor/doctor_input.h"

namespace cansync::cli {
namespace {

TEST(Doctor, AllWell) {
  const auto findings = diagnose(healthy());
  std::set<std::string> topics;
  for (const Finding& finding : findings) {
    EXPECT_EQ(finding.level, Level::ok) << finding.topic << ": " << finding.found;
    EXPECT_EQ(finding.remedy, "") << finding.topic;
    EXPECT_TRUE(topics.insert(finding.topic).second) << finding.topic << " twice";
  }
  EXPECT_EQ(topics.size(), 34u);
  EXPECT_EQ(exit_code(findings, true), ExitCode::done);
}

TEST(Doctor, SetUpThatWaitsForASlaveSaysForWhich) {
  DoctorInput in = healthy();
  in.status->master->option_status = 0x0043;
  in.status->master->slaves_released = 0;
  put(first_slave(in).state, "absent");
  const auto findings = diagnose(in);
  EXPECT_EQ(find(findings, "operating state")->level, Level::error);
  EXPECT_NE(find(findings, "operating state")->remedy.find("mode run, with --force"), std::string::npos);
  EXPECT_NE(find(findings, "slave")->found.find("has never answered"), std::string::npos);
  EXPECT_EQ(exit_code(findings, true), ExitCode::faults);
}

TEST(Doctor, WithDdsSecurityAnotherInterfaceIsNoFault) {
  DoctorInput in = apart();
  put(in.status->gateway.dds_interface, "eth0");
  in.status->gateway.secured = true;
  const auto findings = diagnose(in);
  EXPECT_EQ(exit_code(findings, true), ExitCode::done);
  EXPECT_NE(find(findings, "DDS")->found.find("eth0, DDS Security on"), std::string::npos);
}

TEST(Doctor, DdsSecurityDoesNotKeepProgramsOfThisComputerFromTheBus) {
  DoctorInput in = healthy();
  in.status->gateway.secured = true;
  auto findings = diagnose(in);
  ASSERT_NE(find(findings, "bus access"), nullptr);
  EXPECT_EQ(find(findings, "bus access")->level, Level::warning);
  EXPECT_NE(find(findings, "bus access")->remedy.find("cansync-apart@.service"), std::string::npos);
  in = apart();
  in.status->gateway.secured = true;
  findings = diagnose(in);
  EXPECT_EQ(find(findings, "bus access")->level, Level::ok);
  in.interface_name = "sim";
  EXPECT_EQ(find(diagnose(in), "bus access"), nullptr);
}

TEST(Doctor, OfADaemonOfAnotherComputerTheInterfaceIsNotLookedAt) {
  DoctorInput in = apart();
  put(in.status->gateway.host, "plc2");
  in.status->gateway.secured = true;
  const auto findings = diagnose(in);
  EXPECT_NE(find(findings, "interface")->found.find("computer plc2"), std::string::npos);
  EXPECT_EQ(find(findings, "bus access"), nullptr);
}

TEST(Doctor, ABusWithoutSyncHasNoFindingOnIt) {
  DoctorInput in = healthy();
  in.status->master.reset();
  in.status->has_sync = false;
  const auto findings = diagnose(in);
  EXPECT_EQ(find(findings, "SYNC"), nullptr);
  EXPECT_NE(find(findings, "DDS")->found.find("can send frames"), std::string::npos);
}

TEST(Doctor, AnIdentityThatEndsSoonIsAWarningAndAnEndedOneAnError) {
  constexpr std::int64_t kDay = 86400;
  DoctorInput in = healthy();
  in.status->gateway.secured = true;
  in.data_model = in.status->gateway.data_model = 8;
  const auto level = [&in](std::int64_t left) {
    in.status->gateway.identity_time_left = left;
    return find(diagnose(in), "identity")->level;
  };
  EXPECT_EQ(level(31 * kDay), Level::ok);
  EXPECT_EQ(level(29 * kDay), Level::warning);
  const auto findings = diagnose(in);
  EXPECT_EQ(find(findings, "identity")->found,
            "the daemon's identity of DDS Security ends in 29 days; then no client reaches it");
  EXPECT_NE(find(findings, "identity")->remedy.find("cansync-security renew"), std::string::npos);
  EXPECT_EQ(level(0), Level::error);
  in.status->gateway.data_model = 7;
  EXPECT_EQ(find(diagnose(in), "identity"), nullptr) << "one that does not tell it";
  in.status->gateway.data_model = 8;
  in.status->gateway.secured = false;
  EXPECT_EQ(find(diagnose(in), "identity"), nullptr);
}

TEST(Doctor, ASlaveOfWhichNothingIsToldYetIsNoneThatAnswers) {
  DoctorInput in = healthy();
  in.status->master->slaves_configured = 0b11;
  const auto without = diagnose(in);
  const Finding* found = find(without, "slaves");
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(found->level, Level::warning);
  EXPECT_EQ(found->found, "the daemon has told of 1 of the 2 configured slaves");
  client::SlaveStatus second = first_slave(in);
  second.slave = 1;
  in.status->slaves.push_back(second);
  const auto again = diagnose(in);
  ASSERT_NE(find(again, "slaves"), nullptr);
  EXPECT_EQ(find(again, "slaves")->level, Level::ok) << "as `doctor` called again finds it";
}

TEST(Doctor, ASlaveThatRefusesItsStatusWordIsAnErrorWithTheSettingThatMendsIt) {
  DoctorInput in = healthy();
  client::SlaveStatus slave = {};
  in.status->slaves.push_back(slave);
  EXPECT_EQ(find(diagnose(in), "status word"), nullptr);
  slave.slave = 3;
  put(slave.name, "feeder");
  slave.status_parameter = 301;
  slave.status_error = 0xFFFB;
  in.status->slaves.push_back(slave);
  const auto findings = diagnose(in);
  const Finding* found = find(findings, "status word");
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(found->level, Level::error);
  EXPECT_EQ(found->found,
            "slave 3 'feeder' refuses its status word, parameter 301, with error 0xFFFB: whether it is "
            "synchronized cannot be known");
  EXPECT_NE(found->remedy.find("startup.status_parameter"), std::string::npos);
}

TEST(Doctor, ASlaveThatAnswersWithoutItsStatusWordIsToldLikeOneThatRefusesIt) {
  DoctorInput in = healthy();
  client::SlaveStatus slave = {};
  slave.slave = 3;
  put(slave.name, "feeder");
  slave.status_parameter = 301;
  slave.responds = true;
  in.status->slaves.push_back(slave);
  const auto findings = diagnose(in);
  const Finding* found = find(findings, "status word");
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(found->found,
            "slave 3 'feeder' answers, but has not given its status word, parameter 301: whether it is "
            "synchronized cannot be known");
  EXPECT_NE(found->remedy.find("startup.status_parameter"), std::string::npos);
  in.status->slaves.back().status_known = true;
  EXPECT_EQ(find(diagnose(in), "status word"), nullptr);
}

TEST(Doctor, CommandsOfRemediesReachTheBusThatWasLookedAt) {
  const std::vector<Finding> findings = {
      {Level::error, "slave", "", "correct it, then: cansync release 3; `cansync events` says why", 8, "",
       "correct it, then: cansync release {slaves}; `cansync events` says why"},
      {Level::warning, "sleep", "", "cansync setup --appliance"}};
  const auto shown = with_options(findings, "--bus can1");
  EXPECT_EQ(shown[0].remedy,
            "correct it, then: cansync --bus can1 release 3; `cansync --bus can1 events` says why");
  EXPECT_EQ(shown[0].remedy_form,
            "correct it, then: cansync --bus can1 release {slaves}; `cansync --bus can1 events` says why");
  EXPECT_EQ(shown[1].remedy, "cansync setup --appliance") << "it looks at no bus";
  EXPECT_EQ(with_options(findings, "")[0].remedy, findings[0].remedy);
}

TEST(Doctor, UnitsHaveTheNameOfTheirFile) {
  DoctorInput in = healthy();
  in.bus = "winder";
  in.unit = "can0";
  put(in.status->gateway.restart_reason, "replaced on disk");
  in.reload_refused = "nothing is changed";
  in.status->realtime.realtime_priority = 0;
  for (const Finding& finding : diagnose(in)) {
    EXPECT_EQ(finding.remedy.find("cansyncd@winder"), std::string::npos) << finding.remedy;
    EXPECT_EQ(finding.remedy.find("winder.toml"), std::string::npos) << finding.remedy;
  }
  in.status.reset();
  in.no_daemon = "no daemon found";
  EXPECT_NE(diagnose(in)[0].remedy.find("systemctl start cansyncd@can0 "), std::string::npos);
}

TEST(Doctor, AReadOnlyDaemonIsMadeToTakeTheCommandFirst) {
  DoctorInput in = healthy();
  in.status->gateway.read_only = true;
  in.status->master->option_status = 0x0043;
  const auto findings = diagnose(in);
  EXPECT_EQ(find(findings, "operating state")->remedy,
            "set access.read_only = false and systemctl reload cansyncd@can0, then: cansync mode run");
}

TEST(Doctor, OutOfBusOffEachProtocolHasItsOwnCommand) {
  DoctorInput in = healthy();
  put(in.status->bus.controller_state, "bus-off");
  const auto remedy = [&in](const char* command) {
    in.status->reset_command = command;
    return find(diagnose(in), "controller")->remedy;
  };
  const std::string as_root = "ip link set can0 down && ip link set can0 up";
  EXPECT_EQ(remedy("cansync mode reset-can"), "cansync mode reset-can; or as root: " + as_root);
  EXPECT_EQ(remedy("cansync can reset-controller"), "cansync can reset-controller; or as root: " + as_root);
  EXPECT_EQ(remedy(""), as_root) << "of a slave or of J1939";
}

TEST(Doctor, WhereTheModeAloneDoesNotBringSetUpTheRemedyNamesWhatDoes) {
  DoctorInput in = healthy();
  in.status->master->option_status = 0x0003;
  const auto remedy = [&in](const char* state) {
    put(in.status->master->state, state);
    return find(diagnose(in), "operating state")->remedy;
  };
  const std::string modes = "cansync mode setup, then cansync mode run";
  EXPECT_EQ(remedy("stop"), modes);
  EXPECT_EQ(remedy("listening for another master"),
            "wait until it has listened; when the state stays: " + modes);
  EXPECT_EQ(remedy("waiting for the SYNC of the upper bus"),
            "start the upper bus first; when the state stays: " + modes);
  in.status->master->second_master = true;
  EXPECT_EQ(remedy("silent: another master on the bus"),
            "switch the other master off and wait 3 s; when the state stays: " + modes);
  put(in.status->bus.link_state, "down");
  EXPECT_EQ(remedy("stop"), "fix the interface first, see above; when the state stays: " + modes);
}

TEST(Doctor, WithoutADaemonSaysWhatItCouldNotSee) {
  DoctorInput in = healthy();
  in.status.reset();
  in.no_daemon = "no daemon found";
  const auto findings = diagnose(in);
  EXPECT_EQ(findings[0].topic, "daemon");
  EXPECT_EQ(findings[0].level, Level::error);
  EXPECT_NE(findings[0].remedy.find("systemctl start cansyncd@can0"), std::string::npos);
  EXPECT_NE(findings[1].found.find("realtime rights"), std::string::npos);
  const auto has = [&findings](const char* topic) {
    return std::any_of(findings.begin(), findings.end(),
                       [topic](const Finding& f) { return f.topic == topic; });
  };
  EXPECT_TRUE(has("interface") && has("txqueuelen") && has("kernel") && has("idle states"));
  EXPECT_FALSE(has("priority") || has("DDS"));
  EXPECT_EQ(exit_code(findings, false), ExitCode::not_reachable);
}

}  // namespace
}  // namespace cansync::cli
