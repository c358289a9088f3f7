#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "cli/doctor/doctor_facts.h"
#include "cli/doctor/doctor_findings.h"

namespace cansync::cli {
namespace {

template <std::size_t N>
void put(char (&out)[N], const char* text) {
  std::snprintf(out, N, "%s", text);
}

/// An interface that is up, of drivers of this kind.
can::LinkFacts can_link(std::string_view kind) {
  can::LinkFacts link;
  link.present = link.is_can = link.up = true;
  link.index = 3;
  link.queue_length = 10;
  std::copy(kind.begin(), kind.end(), link.driver_kind.begin());
  return link;
}

/// Everything well: a real bus with all rights.
DoctorInput healthy() {
  DoctorInput in;
  in.bus = in.unit = "can0";
  in.cli_version = "1.2.3";
  in.data_model = 4;
  in.participants = 2;
  in.machine = {"6.1.0-rt", "PREEMPT_RT", "2-3", {{"C6", 133}}};
  in.host = {true, {}, true, "", {{"performance", 4}}, true, "30s", {77}};
  in.interface_name = "can0";
  in.link = can_link("can");
  in.link.timing = can::LinkTiming{500'000, 600};
  in.link.state = can::ControllerState::error_active;
  in.link.restart_ms = 100;
  in.link.one_shot = true;
  in.link.echoes = true;
  in.link.has_counters = true;
  DaemonStatus status = {{}, {}, {}, client::MasterStatus{}};
  put(status.gateway.bus, "can0");
  status.reset_command = "cansync mode reset-can";
  status.gateway.process = 77;
  put(status.master->state, "active");
  status.master->option_status = 0x0080;
  status.master->slaves_configured = status.master->slaves_released = 1;
  status.master->interval = 5000;
  status.master->interval_length = 2'000'000;  // ns
  for (auto& release : status.master->reference_release) {
    put(release.state, "released");
    put(release.writer, "'plc' (plc, process 12 on host cab)");
  }
  put(status.gateway.version, "1.2.3");
  put(status.bus.controller_state, "error-active");
  put(status.bus.bus_interface, "can0");
  put(status.gateway.dds_interface, "lo");
  put(status.bus.link_state, "up");
  put(status.bus.timestamp_source, "hardware");
  put(status.realtime.sync_output, "gpio");
  put(status.realtime.sync_input, "pps");
  put(status.realtime.sync_state, "locked");
  client::SlaveStatus slave{};
  put(slave.name, "winder");
  put(slave.state, "released");
  slave.responds = slave.status_known = slave.synchronized = true;
  slave.last_seen = 4990;
  status.slaves = {slave};
  status.gateway.data_model = 4;
  status.bus.bit_rate = 500'000;
  status.bus.sample_point_wanted = 600;
  status.realtime.realtime_priority = status.realtime.realtime_priority_wanted = 60;
  status.realtime.realtime_cpu = status.realtime.realtime_cpu_wanted = 2;
  status.realtime.memory_locked = status.realtime.memory_lock_wanted = status.realtime.cpu_held_awake = true;
  in.status = status;
  return in;
}

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

/// One thing that is not well.
struct Fault {
  const char* topic;
  Level level;
  void (*spoil)(DoctorInput&);
  const char* found;   ///< part of what is said
  const char* remedy;  ///< part of the command
};

class OneFault : public testing::TestWithParam<Fault> {};

TEST_P(OneFault, IsFoundAloneWithItsRemedy) {
  DoctorInput in = healthy();
  GetParam().spoil(in);
  const auto findings = diagnose(in);
  const auto bad = [](const Finding& finding) { return finding.level != Level::ok; };
  ASSERT_EQ(std::count_if(findings.begin(), findings.end(), bad), 1);
  const Finding& finding = *std::find_if(findings.begin(), findings.end(), bad);
  EXPECT_EQ(finding.topic, GetParam().topic);
  EXPECT_EQ(finding.level, GetParam().level);
  EXPECT_NE(finding.found.find(GetParam().found), std::string::npos) << finding.found;
  EXPECT_NE(finding.remedy.find(GetParam().remedy), std::string::npos) << finding.remedy;
  EXPECT_EQ(exit_code(findings, true),
            GetParam().level == Level::error ? ExitCode::faults : ExitCode::failed);
}

/// A computer that carries out the commands of a remedy: `ip link set` as the kernel takes it, settings of the
/// configuration followed by a restart, and the master's modes. Others are left to a person.
class Computer {
 public:
  explicit Computer(DoctorInput& facts) : facts_(facts) {}

  /// Does `remedy` consist of commands that this computer knows?
  static bool knows(std::string_view remedy) {
    const bool sets = remedy.starts_with("set ") && remedy.find(" = ") != remedy.npos;
    return sets || remedy.find("ip link set") != remedy.npos || remedy.starts_with("cansync mode");
  }

  /// Carries it out. False: a command was refused.
  bool carry_out(std::string remedy) {
    for (const char* behind : {"   (", ", or use", "; or as root"})
      remedy = remedy.substr(0, remedy.find(behind));
    if (const auto at = remedy.find(": ip link"); at != remedy.npos) remedy = remedy.substr(at + 2);
    for (const char* between : {" && ", ", then "}) {
      for (std::size_t at = 0; (at = remedy.find(between)) != remedy.npos;)
        remedy.replace(at, std::string_view(between).size(), "\n");
    }
    std::istringstream commands(remedy);
    for (std::string command; std::getline(commands, command);) {
      if (!one(command)) return false;
    }
    return true;
  }

 private:
  bool one(const std::string& command) {
    std::istringstream words(command);
    std::string first;
    std::string second;
    words >> first >> second;
    if (first == "ip") return link(words);
    if (first == "cansync") return mode(words);
    return first == "set" && set(second, command.substr(command.find('=') + 2));
  }

  bool link(std::istringstream& words) {
    std::string word;
    words >> word >> word;  // set INTERFACE
    if (word != facts_.interface_name) return false;
    while (words >> word) {
      if (word == "down" || word == "up") {
        facts_.link.up = word == "up";
        facts_.link.state = can::ControllerState::error_active;
        put(facts_.status->bus.controller_state, "error-active");
        put(facts_.status->bus.link_state, "up");
      } else if (word == "txqueuelen") {
        words >> facts_.link.queue_length;
      } else if (word == "type") {
        words >> word;                     // can
        if (facts_.link.up) return false;  // "Device or resource busy"
      } else if (!setting(word, words)) {
        return false;
      }
    }
    return true;
  }

  bool setting(const std::string& name, std::istringstream& words) {
    std::string value;
    words >> value;
    if (name == "bitrate") {
      facts_.link.timing = can::LinkTiming{static_cast<std::uint32_t>(std::stoul(value)), 0};
    } else if (name == "sample-point") {
      facts_.link.timing->sample_point = static_cast<std::uint16_t>(std::stod(value) * 1000 + 0.5);
    } else if (name == "restart-ms") {
      facts_.link.restart_ms = static_cast<std::uint32_t>(std::stoul(value));
    } else if (name == "one-shot") {
      facts_.link.one_shot = value == "on";
    } else if (name == "listen-only") {
      facts_.link.listen_only = value == "on";
    } else {
      return false;
    }
    return true;
  }

  bool mode(std::istringstream& words) {
    std::string mode;
    words >> mode;
    client::MasterStatus& master = *facts_.status->master;
    if (mode == "setup") {
      master.option_status = 0x0043;
      facts_.status->slaves.front().synchronized = true;
    } else if (mode == "run" && master.option_status == 0x0043) {
      master.option_status = 0x0080;
    } else if (mode == "reset-can") {
      put(facts_.status->bus.controller_state, "error-active");
    } else {
      return false;
    }
    return true;
  }

  bool set(const std::string& option, const std::string& value) {
    client::RealtimeStatus& realtime = facts_.status->realtime;
    if (option == "realtime.priority")
      realtime.realtime_priority = realtime.realtime_priority_wanted = std::stoi(value);
    else if (option == "realtime.lock_memory")
      realtime.memory_locked = realtime.memory_lock_wanted = value == "true";
    else if (option == "realtime.cpu")
      realtime.realtime_cpu = realtime.realtime_cpu_wanted = std::stoi(value);
    else if (option == "dds.interface")
      put(facts_.status->gateway.dds_interface, value == "\"lo\"" ? "lo" : "eth0");
    else
      return false;
    return true;
  }

  DoctorInput& facts_;
};

TEST_P(OneFault, IsGoneWhenTheCommandsOfItsRemedyAreCarriedOut) {
  DoctorInput in = healthy();
  GetParam().spoil(in);
  const auto bad = [](const Finding& finding) { return finding.level != Level::ok; };
  const auto findings = diagnose(in);
  const Finding& finding = *std::find_if(findings.begin(), findings.end(), bad);
  if (!Computer::knows(finding.remedy)) return;  // tests/remedies/remedies.md says what shows it
  ASSERT_TRUE(Computer(in).carry_out(finding.remedy)) << finding.remedy;
  for (const Finding& left : diagnose(in))
    EXPECT_EQ(left.level, Level::ok) << left.topic << ": " << left.found;
}

using In = DoctorInput;
INSTANTIATE_TEST_SUITE_P(
    All, OneFault,
    testing::Values(
        Fault{"version", Level::warning, [](In& in) { put(in.status->gateway.version, "1.2.2"); },
              "cansyncd 1.2.2, but cansync 1.2.3", "systemctl restart"},
        Fault{"restart", Level::warning,
              [](In& in) {
                put(in.status->gateway.version, "1.2.2");
                put(in.status->gateway.installed_version, "1.2.3-1");
                put(in.status->gateway.restart_reason, "cansyncd 1.2.3-1 is installed, 1.2.2-1 runs");
              },
              "cansyncd 1.2.3-1 is installed, 1.2.2-1 runs",
              "when the line may stop: systemctl restart cansyncd@can0"},
        Fault{"restart", Level::warning,
              [](In& in) {
                put(in.status->gateway.restart_reason,
                    "replaced on disk since the start: libddsc.so.0debian");
              },
              "libddsc.so.0debian", "when the line may stop: systemctl restart cansyncd@can0"},
        Fault{"sleep", Level::warning,
              [](In& in) {
                in.host.sleeps = {"suspend", "hibernate"};
              },
              "this computer may sleep (suspend, hibernate)", "cansync setup --appliance"},
        Fault{"inhibitors", Level::warning, [](In& in) { in.host.keep_awake = {78}; },
              "the line is in run, and the daemon does not keep this computer from sleeping",
              "apt install polkitd"},
        Fault{"automatic reboot", Level::warning,
              [](In& in) { in.host.reboot_setting = "/etc/apt/apt.conf.d/50unattended-upgrades"; },
              "may reboot this computer (/etc/apt/apt.conf.d/50unattended-upgrades)",
              "cansync setup --appliance"},
        Fault{"governor", Level::warning,
              [](In& in) {
                in.host.governors = {{"performance", 2}, {"powersave", 2}};
              },
              "powersave on 2 processors", "cansync setup --appliance"},
        Fault{"watchdog", Level::warning, [](In& in) { in.host.watchdog_set.reset(); },
              "systemd does not use it", "cansync setup --appliance"},
        Fault{
            "dds_incompatible", Level::error,
            [](In& in) {
              in.incompatible = 2;
              in.newest_incompatible = "a writer of topic Command of plc does not match: type";
            },
            "2 programs on this bus's topics can neither hear the daemon nor be heard; the newest: a writer of",
            "Other DDS implementations"},
        Fault{"drive fault", Level::error,
              [](In& in) {
                in.status->faults = {{0, "fault, SYNC edges missing"}};
              },
              "slave 0 'winder': fault, SYNC edges missing", "cansync control 0 WORD"},
        Fault{"data model", Level::warning, [](In& in) { in.status->gateway.data_model = 3; },
              "the daemon has number 3", "update cansyncd"},
        Fault{"data model", Level::warning, [](In& in) { in.status->gateway.data_model = 5; },
              "this program 4", "update cansync"},
        Fault{"interface", Level::error,
              [](In& in) {
                in.link = {};
                put(in.status->bus.link_state, "missing");
              },
              "no such interface", "ip -br link show type can"},
        Fault{"interface", Level::error, [](In& in) { in.link.is_can = false; }, "no CAN interface",
              "bus.interface"},
        Fault{"interface", Level::error, [](In& in) { in.link.up = false; }, "can0 is down",
              "ip link set can0 up"},
        Fault{"interface", Level::error,
              [](In& in) {
                in.link.up = false;
                in.link.timing.reset();
              },
              "can0 is down",
              "ip link set can0 type can bitrate 500000 sample-point 0.600 && ip link set can0 up"},
        Fault{"interface", Level::warning, [](In& in) { in.link.listen_only = true; },
              "listen-only mode: nothing is sent",
              "ip link set can0 type can listen-only off && ip link set can0 up"},
        Fault{"interface", Level::warning, [](In& in) { in.kernel_silent = "no descriptor left"; },
              "no descriptor left", "ip -details link show can0"},
        Fault{"bit rate", Level::error, [](In& in) { in.link.timing->bits_per_second = 250'000; },
              "250000 bit/s, but the bus has 500000", "type can bitrate 500000 sample-point 0.600"},
        Fault{"bit rate", Level::warning, [](In& in) { in.link.timing.reset(); }, "does not tell",
              "ip -details link show can0"},
        Fault{"sample point", Level::warning, [](In& in) { in.link.timing->sample_point = 875; },
              "0.875 instead of 0.600", "ip link set can0 type can bitrate 500000 sample-point 0.600"},
        Fault{"sample point", Level::warning, [](In& in) { in.status->bus.sample_point_wanted = 875; },
              "0.600 instead of 0.875", "sample-point 0.875"},
        Fault{"restart-ms", Level::warning, [](In& in) { in.link.restart_ms = 0; }, "stays silent",
              "down && ip link set can0 type can restart-ms 100 && ip link set can0 up"},
        Fault{"one-shot", Level::warning, [](In& in) { in.link.one_shot = false; }, "go out late",
              "type can one-shot on && ip link set can0 up   (with systemd-networkd: OneShot=yes in [CAN])"},
        Fault{"echo", Level::warning, [](In& in) { in.link.echoes = false; }, "does not tell",
              "another adapter"},
        Fault{"controller", Level::error, [](In& in) { put(in.status->bus.link_state, "unacknowledged"); },
              "nobody on the bus acknowledges", "120 ohm"},
        Fault{"controller", Level::error, [](In& in) { put(in.status->bus.link_state, "not-emptied"); },
              "cannot be reset", "ip link set can0 down && ip link set can0 up"},
        Fault{"txqueuelen", Level::warning, [](In& in) { in.link.queue_length = 1000; }, "1000 frames",
              "ip link set can0 txqueuelen 10"},
        Fault{"txqueuelen", Level::warning, [](In& in) { in.link.queue_length = 1; }, "do not fit",
              "txqueuelen 10"},
        Fault{"controller", Level::error, [](In& in) { put(in.status->bus.controller_state, "bus-off"); },
              "bus-off", "cansync mode reset-can"},
        Fault{"controller", Level::warning,
              [](In& in) { put(in.status->bus.controller_state, "error-passive"); }, "error-passive",
              "120 ohm"},
        Fault{"error counters", Level::warning, [](In& in) { in.status->bus.transmit_errors = 8; },
              "8 transmit", "ip -details -statistics link show can0"},
        Fault{"time stamps", Level::warning, [](In& in) { put(in.status->bus.timestamp_source, "thread"); },
              "realtime thread", "ethtool -T can0"},
        Fault{"time stamps", Level::warning, [](In& in) { put(in.status->bus.timestamp_source, ""); },
              "not told", "update cansyncd"},
        Fault{"SYNC", Level::warning, [](In& in) { put(in.status->realtime.sync_state, "holdover"); },
              "edges of the input pps are missing", "cansync events"},
        Fault{"SYNC", Level::error, [](In& in) { put(in.status->realtime.sync_state, "lost"); },
              "input pps: lost", "cansync events"},
        Fault{"SYNC", Level::warning,
              [](In& in) {
                put(in.status->realtime.sync_output, "none");
                put(in.status->realtime.sync_state, "");
              },
              "put out nowhere", "sync.output"},
        Fault{"controller", Level::error, [](In& in) { put(in.status->bus.controller_state, "stopped"); },
              "stopped", "ip link set can0 up"},
        Fault{"second master", Level::error,
              [](In& in) {
                in.status->master->second_master = true;
                in.status->master->second_master_frames = 12;
              },
              "sends on this bus: 12 frames", "switch the other master off"},
        Fault{"second master", Level::warning, [](In& in) { in.status->master->second_master_frames = 12; },
              "has sent 12 frames", "switch the other master off"}),
    [](const auto& test) { return "Bus" + std::to_string(test.index); });

client::SlaveStatus& first_slave(In& in) {
  return in.status->slaves.front();
}

INSTANTIATE_TEST_SUITE_P(
    Line, OneFault,
    testing::Values(
        Fault{"slave", Level::error, [](In& in) { put(first_slave(in).state, "absent"); },
              "slave 0 'winder' has never answered", "slave number, bit rate and wiring"},
        Fault{"slave", Level::error,
              [](In& in) {
                put(first_slave(in).state, "lost");
                first_slave(in).last_seen = 3500;
              },
              "slave 0 'winder' has stopped answering; its last answer came 3.0 s ago",
              "switch the drive on"},
        Fault{"slave", Level::error,
              [](In& in) {
                put(first_slave(in).state, "held");
                put(first_slave(in).held_reason, "not the drive expected: parameter 102");
              },
              "is held out: not the drive expected: parameter 102", "cansync release 0 --force"},
        Fault{"duplicate slave", Level::error, [](In& in) { in.status->master->slaves_duplicate = 1u << 5; },
              "two drives answer as slave 5", "cansync release NUMBER"},
        Fault{"unknown slave", Level::warning,
              [](In& in) { in.status->master->slaves_unknown = (1u << 9) | (1u << 31); },
              "slave 9, 31 answers and is not in the configuration", "[[slave]]"},
        Fault{"slave", Level::error, [](In& in) { first_slave(in).synchronized = false; },
              "answers, but is not synchronized", "SYNC line"},
        Fault{"slave", Level::warning, [](In& in) { put(first_slave(in).state, "checking"); },
              "slave 0 'winder' is checking", "cansync wait released 0"},
        Fault{"references 1", Level::warning,
              [](In& in) {
                put(in.status->master->reference_release[0].state, "stopped");
                put(in.status->master->reference_release[0].cause, "writer_lost");
              },
              "stopped because of writer_lost", "cansync events"},
        Fault{"references 1", Level::warning,
              [](In& in) {
                put(in.status->master->reference_release[0].state, "stopped");
                put(in.status->master->reference_release[0].cause, "bus_lost");
              },
              "stopped: what was given before the bus was lost is not sent any more", "give new values"},
        Fault{"missed", Level::warning,
              [](In& in) {
                in.status->realtime.missed_syncs = 12;
                in.newest_missed = "2030-01-02 03:04:05.678";
              },
              "12 SYNC edges, 0 telegrams left out since the start; the newest at 2030-01-02",
              "cansync timing --follow"},
        Fault{"missed", Level::warning, [](In& in) { in.status->master->left_out = 3; },
              "3 telegrams left out", "cansync timing"},
        Fault{"configuration", Level::warning,
              [](In& in) { in.reload_refused = "nothing is changed: bus.name: found 6"; },
              "the file on disk is not what runs: nothing is changed: bus.name", "cansyncd --check"},
        Fault{"network", Level::warning,
              [](In& in) {
                put(in.status->gateway.network_reason, "network interface 'eth1' (dds.interface) is down");
              },
              "'eth1' (dds.interface) is down", "ip address"},
        Fault{"network", Level::warning,
              [](In& in) {
                put(in.status->gateway.network_reason,
                    "the daemon of computer plc2 has the name of bus can0");
                put(in.status->gateway.name_taken_by, "plc2");
              },
              "plc2 has the name", "another bus.name"},
        Fault{"operating state", Level::warning,
              [](In& in) {
                in.status->master->option_status = 0x0003;
                put(in.status->master->state, "stopped");
                first_slave(in).synchronized = false;
              },
              "stopped: no SYNC is made", "cansync mode setup"},
        Fault{"operating state", Level::warning, [](In& in) { in.status->master->option_status = 0x0043; },
              "every slave is ready", "cansync mode run"}),
    [](const auto& test) { return "Line" + std::to_string(test.index); });

INSTANTIATE_TEST_SUITE_P(
    Machine, OneFault,
    testing::Values(
        Fault{"priority", Level::warning, [](In& in) { in.status->realtime.realtime_priority = 0; },
              "SCHED_FIFO 60 was not granted", "LimitRTPRIO=60"},
        Fault{"locked memory", Level::warning, [](In& in) { in.status->realtime.memory_locked = false; },
              "not granted", "LimitMEMLOCK=infinity"},
        Fault{"isolated", Level::warning, [](In& in) { in.machine.isolated = "3"; }, "processor 2 is shared",
              "isolcpus=2"},
        Fault{"isolated", Level::warning,
              [](In& in) { in.status->realtime.realtime_cpu = in.status->realtime.realtime_cpu_wanted = -1; },
              "not bound", "realtime.cpu = 2"},
        Fault{"processor", Level::warning, [](In& in) { in.status->realtime.realtime_cpu = -1; },
              "2 was not granted", "realtime.cpu"},
        Fault{"idle states", Level::warning, [](In& in) { in.status->realtime.cpu_held_awake = false; },
              "C6 takes 133 us", "60-cansyncd.rules"},
        Fault{"kernel", Level::warning, [](In& in) { in.machine.preemption = "PREEMPT_DYNAMIC"; },
              "PREEMPT_DYNAMIC", "linux-image-rt-amd64"},
        Fault{"DDS", Level::warning, [](In& in) { put(in.status->gateway.dds_interface, "eth0"); }, "eth0",
              "dds.interface"},
        Fault{"DDS", Level::warning, [](In& in) { put(in.status->gateway.dds_interface, ""); },
              "dds.xml, DDS Security off", "docs/security.md"}),
    [](const auto& test) { return "Machine" + std::to_string(test.index); });

/// What is found of `topic`; nothing when it is not looked at.
const Finding* find(const std::vector<Finding>& findings, std::string_view topic) {
  const auto found =
      std::find_if(findings.begin(), findings.end(), [topic](const Finding& f) { return f.topic == topic; });
  return found == findings.end() ? nullptr : &*found;
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

/// The interface is in a network namespace with the daemon, which says that it is up.
DoctorInput apart() {
  DoctorInput in = healthy();
  in.link = {};
  return in;
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

TEST(Doctor, AnInterfaceInANetworkNamespaceIsNotMissing) {
  DoctorInput in = apart();
  EXPECT_EQ(find(diagnose(in), "interface")->level, Level::ok);
  put(in.status->bus.controller_state, "bus-off");
  EXPECT_NE(find(diagnose(in), "controller")->remedy.find("ip -n cansync-can0 link set can0 down && ip -n"),
            std::string::npos);
  put(in.status->bus.link_state, "missing");
  EXPECT_EQ(find(diagnose(in), "interface")->level, Level::error);
}

TEST(Doctor, ABusWithoutSyncHasNoFindingOnIt) {
  DoctorInput in = healthy();
  in.status->master.reset();
  in.status->has_sync = false;
  const auto findings = diagnose(in);
  EXPECT_EQ(find(findings, "SYNC"), nullptr);
  EXPECT_NE(find(findings, "DDS")->found.find("can send frames"), std::string::npos);
}

TEST(Doctor, ASimulatedLineHasNoInterface) {
  DoctorInput in = healthy();
  in.interface_name = "sim";
  in.link = {};
  const auto findings = diagnose(in);
  EXPECT_EQ(exit_code(findings, true), ExitCode::done);
  for (const char* topic : {"bit rate", "sample point", "restart-ms", "one-shot", "echo", "txqueuelen"})
    EXPECT_EQ(find(findings, topic), nullptr) << topic;
}

can::InterfaceAdapter adapter(const char* interface, std::string_view serial) {
  can::InterfaceAdapter one{interface, {}};
  std::copy(serial.begin(), serial.end(), one.adapter.serial.begin());
  return one;
}

/// One of two adapters, which the kernel names in the order in which it finds them.
DoctorInput with_two_adapters() {
  DoctorInput in = healthy();
  in.adapters = {adapter("can0", "A"), adapter("can1", "B")};
  in.link.adapter = in.adapters.front().adapter;
  return in;
}

TEST(Doctor, OneOfTwoAdaptersWithTheKernelsNameIsAWarning) {
  DoctorInput in = with_two_adapters();
  const auto findings = diagnose(in);
  const Finding* found = find(findings, "adapter");
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(found->level, Level::warning);
  EXPECT_EQ(found->found, "serial=A,channel=0 of 2 adapters; after a boot can0 can be another one");
  EXPECT_NE(found->remedy.find("set bus.adapter = \"serial=A\""), std::string::npos) << found->remedy;
  EXPECT_NE(found->remedy.find("cansync scan can0 --write FOLDER --interface-name"), std::string::npos);
  in.adapters.pop_back();
  EXPECT_EQ(find(diagnose(in), "adapter"), nullptr) << "the only one";
  in = with_two_adapters();
  in.interface_name = "can-winder";
  in.adapters.front().interface = "can-winder";
  EXPECT_EQ(find(diagnose(in), "adapter")->level, Level::ok) << "a name that somebody gave to it";
}

TEST(Doctor, APinnedAdapterIsComparedAndTheRightOneNamed) {
  DoctorInput in = with_two_adapters();
  put(in.status->bus.adapter_wanted, "serial=A");
  EXPECT_EQ(find(diagnose(in), "adapter")->level, Level::ok);
  put(in.status->bus.adapter_wanted, "serial=B");
  put(in.status->bus.link_state, "wrong-adapter");
  auto findings = diagnose(in);
  const Finding* found = find(findings, "adapter");
  EXPECT_EQ(found->level, Level::error);
  EXPECT_EQ(found->found,
            "serial=A,channel=0, but bus.adapter is serial=B: nothing is sent or received; that one is can1");
  in.adapters.pop_back();
  findings = diagnose(in);
  EXPECT_NE(find(findings, "adapter")->found.find("that one is not there"), std::string::npos);
  in.adapters = {adapter("can0", "B"), adapter("can1", "B")};
  in.link.adapter = in.adapters.front().adapter;
  put(in.status->bus.link_state, "up");
  findings = diagnose(in);
  EXPECT_EQ(find(findings, "adapter")->level, Level::warning);
  EXPECT_EQ(find(findings, "adapter")->found, "bus.adapter is serial=B, which can0 and can1 have");
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

TEST(Doctor, AVirtualInterfaceHasNothingToSet) {
  DoctorInput in = healthy();
  in.link = can_link("vcan");
  in.link.queue_length = 0;
  const auto findings = diagnose(in);
  EXPECT_EQ(exit_code(findings, true), ExitCode::done);
  ASSERT_NE(find(findings, "interface"), nullptr);
  EXPECT_EQ(find(findings, "interface")->found, "can0 is up, virtual (vcan): nothing to set");
  for (const char* topic : {"bit rate", "sample point", "restart-ms", "one-shot", "echo", "txqueuelen"})
    EXPECT_EQ(find(findings, topic), nullptr) << topic;
  in.link.up = false;
  EXPECT_EQ(find(diagnose(in), "interface")->remedy, "ip link set can0 up");
}

TEST(Doctor, ADriverWithoutOneShotHasNothingToSet) {
  DoctorInput in = healthy();
  in.link.one_shot = false;
  in.link.can_one_shot = false;
  EXPECT_EQ(find(diagnose(in), "one-shot")->level, Level::ok);
  in.link.one_shot.reset();
  EXPECT_EQ(find(diagnose(in), "one-shot"), nullptr);
}

TEST(Doctor, OneShotIsForLinesWithSlots) {
  DoctorInput in = healthy();
  in.status->master.reset();
  put(in.status->realtime.sync_state, "");
  in.link.one_shot = false;
  EXPECT_EQ(find(diagnose(in), "one-shot")->level, Level::ok);
  in.link.one_shot = true;
  const auto findings = diagnose(in);
  EXPECT_EQ(find(findings, "one-shot")->level, Level::warning);
  EXPECT_NE(find(findings, "one-shot")->remedy.find("one-shot off"), std::string::npos);
  put(in.status->realtime.sync_state, "locked");  // a slave's
  EXPECT_EQ(find(diagnose(in), "one-shot")->level, Level::ok);
}

TEST(Doctor, ASamplePointAsNearAsAControllerComesIsWell) {
  DoctorInput in = healthy();
  in.link.timing->sample_point = 625;  // 10 of 16 quanta
  EXPECT_EQ(exit_code(diagnose(in), true), ExitCode::done);
  in.link.timing->sample_point = 633;
  EXPECT_EQ(exit_code(diagnose(in), true), ExitCode::failed);
}

TEST(Doctor, ABusWithoutSlotsHasTheSamplePointOfItsProtocol) {
  DoctorInput in = healthy();
  in.status->master.reset();
  put(in.status->realtime.sync_state, "");
  in.status->bus.sample_point_wanted = 875;  // J1939
  for (const std::uint16_t point : {std::uint16_t{800}, std::uint16_t{875}, std::uint16_t{900}}) {
    in.link.timing->sample_point = point;
    EXPECT_EQ(find(diagnose(in), "sample point")->level, Level::ok) << point;
  }
  for (const std::uint16_t point : {std::uint16_t{600}, std::uint16_t{799}, std::uint16_t{901}}) {
    in.link.timing->sample_point = point;
    const auto findings = diagnose(in);
    EXPECT_EQ(find(findings, "sample point")->level, Level::warning) << point;
    EXPECT_NE(find(findings, "sample point")->remedy.find("sample-point 0.875"), std::string::npos);
  }
  in.status->bus.sample_point_wanted = 0;  // general frames
  EXPECT_EQ(find(diagnose(in), "sample point"), nullptr);
}

TEST(Doctor, AnOlderDaemonLeavesTheSamplePointsOfBothFamilies) {
  DoctorInput in = healthy();
  in.status->bus.sample_point_wanted = 0;
  for (const std::uint16_t point : {std::uint16_t{600}, std::uint16_t{875}}) {
    in.link.timing->sample_point = point;
    EXPECT_EQ(find(diagnose(in), "sample point")->level, Level::ok) << point;
  }
  in.link.timing->sample_point = 750;
  EXPECT_EQ(find(diagnose(in), "sample point")->level, Level::warning);
  // The Omega Drive-Line II has no 1 Mbit/s.
  in.status->bus.bit_rate = in.link.timing->bits_per_second = 1'000'000;
  in.link.timing->sample_point = 875;
  EXPECT_EQ(find(diagnose(in), "sample point")->level, Level::warning);
}

TEST(Doctor, WithoutADaemonLooksAtTheInterfaceItself) {
  DoctorInput in = healthy();
  in.status.reset();
  in.no_daemon = "no daemon found";
  in.link.state = can::ControllerState::bus_off;
  in.link.transmit_errors = 248;
  auto findings = diagnose(in);
  EXPECT_EQ(find(findings, "bit rate")->found, "500000 bit/s");
  EXPECT_EQ(find(findings, "bit rate")->level, Level::ok);
  EXPECT_EQ(find(findings, "controller")->level, Level::error);
  EXPECT_EQ(find(findings, "controller")->remedy, "ip link set can0 down && ip link set can0 up");
  EXPECT_EQ(find(findings, "error counters")->found, "248 transmit, 0 receive");
  in.link.timing->bits_per_second = 800'000;
  in.link.up = in.link.has_counters = false;
  findings = diagnose(in);
  EXPECT_EQ(find(findings, "bit rate")->level, Level::error);
  EXPECT_NE(find(findings, "bit rate")->remedy.find("bitrate 1000000 sample-point 0.600"), std::string::npos);
  EXPECT_EQ(find(findings, "controller"), nullptr) << "it is down";
  EXPECT_EQ(find(findings, "error counters"), nullptr);
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
