#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "cli/doctor/doctor_input.h"

namespace cansync::cli {
namespace {

/// One thing that is not well.
struct Fault {
  const char* topic;
  Level level;
  void (*spoil)(DoctorInput&);
  const char* found;   ///< part of what is said
  const char* remedy;  ///< part of the command
};

TEST(ReferenceLimits, AreAskedForUntilEachValueHasSome) {
  DoctorInput in = healthy();
  in.status->master->references_unlimited = 0b101;
  put(in.status->master->reference_value[2].name, "draw");
  const auto findings = diagnose(in);
  const Finding* found = find(findings, "limits");
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(found->level, Level::warning);
  EXPECT_EQ(found->found,
            "no minimum, maximum or max_step for reference values 0, 2 'draw': drives get any value");
  in.status->master->references_unlimited = 0;
  EXPECT_EQ(find(diagnose(in), "limits"), nullptr);
}

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

}  // namespace
}  // namespace cansync::cli
