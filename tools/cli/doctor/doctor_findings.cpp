#include "cli/doctor/doctor_findings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <bit>

#include "cli/base/finding_list.h"
#include "cli/doctor/doctor_line.h"
#include "cli/doctor/doctor_link.h"
#include "cli/text/values.h"
#include "text/counts.h"
#include "text/unit_name.h"

namespace cansync::cli {
namespace {

using Status = DaemonStatus;

/// Idle states that take longer to leave are felt in a 1 ms interval.
constexpr std::uint32_t kLongestIdleLatency = 20;  // us
constexpr std::uint16_t kInRun = 0x0080;           // w_OPTION_STATUS

/// The service, as a word of a shell command.
std::string unit_of(const DoctorInput& in) {
  return text::shell_word("cansyncd@" + text::unit_instance(in.unit));
}

void look_at_daemon(const DoctorInput& in, FindingList& out) {
  if (!in.several_daemons.empty()) {
    out.error("daemon", in.several_daemons,
              "stop all but one, or give each a bus.name (or a dds.domain) of its own, and restart it");
  } else if (!in.status) {
    out.error("daemon", in.no_daemon,
              fmt::format("systemctl start {}   (or: cansyncd /etc/cansync/{}.toml)", unit_of(in), in.unit));
  }
  if (!in.status) {
    out.warning("not looked at",
                "without the daemon: versions, time stamps, realtime rights, DDS, SYNC, second master",
                "start the daemon, then `cansync doctor` again");
    return;
  }
  const std::string state = in.status->master ? in.status->master->state : in.status->gateway.protocol;
  out.ok("daemon", fmt::format("serves bus {}: {}", in.status->gateway.bus, state));
}

void look_at_versions(const DoctorInput& in, const Status& status, FindingList& out) {
  const std::string_view waits = client::text(status.gateway.restart_reason);
  const bool newer_waits = !client::text(status.gateway.installed_version).empty();
  if (waits.empty())
    out.ok("restart", "nothing that the daemon has loaded was replaced on disk");
  else
    out.warning("restart", std::string(waits), "when the line may stop: systemctl restart " + unit_of(in));
  if (newer_waits)  // which version runs, the finding above says
    out.ok("version", fmt::format("cansync {}", in.cli_version));
  else if (in.cli_version == status.gateway.version)
    out.ok("version", fmt::format("cansyncd and cansync {}", in.cli_version));
  else
    out.warning("version", fmt::format("cansyncd {}, but cansync {}", status.gateway.version, in.cli_version),
                "install both from the same package, then: systemctl restart " + unit_of(in));
  if (in.data_model == status.gateway.data_model) {
    out.ok("data model", fmt::format("number {} on both sides", in.data_model));
    return;
  }
  const bool older = status.gateway.data_model < in.data_model;
  out.warning("data model",
              fmt::format("the daemon has number {}, this program {}: {} members are not {}",
                          status.gateway.data_model, in.data_model, older ? "newer" : "the daemon's newer",
                          older ? "told" : "understood"),
              older ? "update cansyncd, then: systemctl restart " + unit_of(in) : "update cansync");
}

void look_at_timestamps(const DoctorInput& in, const Status& status, FindingList& out) {
  const std::string_view source = status.bus.timestamp_source;
  if (source.empty())
    out.warning("time stamps", "their source was not told", "update cansyncd");
  else if (source == "thread")
    out.warning("time stamps", "by the realtime thread: no better than its wake-ups",
                "use an adapter whose driver stamps frames: ethtool -T " + in.interface_name);
  else
    out.ok("time stamps", fmt::format("by {}", source));
}

void look_at_rights(const DoctorInput& in, const Status& status, FindingList& out) {
  const std::string unit = "systemctl edit " + unit_of(in);
  const std::int32_t wanted = status.realtime.realtime_priority_wanted;
  if (status.realtime.realtime_priority > 0)
    out.ok("priority", fmt::format("SCHED_FIFO {}", status.realtime.realtime_priority));
  else if (wanted > 0)
    out.warning("priority", fmt::format("normal scheduling; SCHED_FIFO {} was not granted", wanted),
                fmt::format("{}   ([Service] LimitRTPRIO={}); then restart it", unit, wanted));
  else
    out.warning("priority", "normal scheduling, as configured", "set realtime.priority = 60");
  if (status.realtime.memory_locked)
    out.ok("locked memory", "all memory is locked");
  else if (status.realtime.memory_lock_wanted)
    out.warning("locked memory", "was not granted",
                unit + "   ([Service] LimitMEMLOCK=infinity); then restart it");
  else
    out.warning("locked memory", "switched off in the configuration", "set realtime.lock_memory = true");
}

void look_at_processor(const DoctorInput& in, const Status& status, FindingList& out) {
  const std::int32_t wanted = status.realtime.realtime_cpu_wanted;
  const std::string& isolated = in.machine.isolated;
  if (wanted >= 0 && status.realtime.realtime_cpu != wanted)
    out.warning("processor", fmt::format("{} was not granted to the realtime thread", wanted),
                "set realtime.cpu to one of: cat /sys/devices/system/cpu/online");
  else
    out.ok("processor", wanted >= 0 ? fmt::format("the realtime thread is bound to {}", wanted)
                                    : std::string("the realtime thread may run on any"));
  if (isolated.empty() && wanted < 0)
    out.ok("isolated", "no processor is isolated, and none is asked for");
  else if (wanted < 0)
    out.warning("isolated", fmt::format("{}, but the realtime thread is not bound to one", isolated),
                fmt::format("set realtime.cpu = {}", isolated.substr(0, isolated.find_first_of(",-"))));
  else if (in_processor_list(isolated, wanted))
    out.ok("isolated", fmt::format("{}, with the realtime thread's", isolated));
  else
    out.warning("isolated", fmt::format("processor {} is shared with every other program", wanted),
                fmt::format("add isolcpus={} to GRUB_CMDLINE_LINUX in /etc/default/grub; update-grub; reboot",
                            wanted));
}

void look_at_idle_states(const DoctorInput& in, FindingList& out) {
  if (in.status && in.status->realtime.cpu_held_awake) {
    out.ok("idle states", "the daemon holds /dev/cpu_dma_latency at 0 us");
    return;
  }
  const auto& states = in.machine.idle_states;
  const auto deepest = std::max_element(
      states.begin(), states.end(),
      [](const IdleState& a, const IdleState& b) { return a.exit_latency < b.exit_latency; });
  if (deepest == states.end()) {
    out.ok("idle states", "the kernel manages none here");
  } else if (deepest->exit_latency <= kLongestIdleLatency) {
    out.ok("idle states",
           fmt::format("the deepest ({}) is left within {} us", deepest->name, deepest->exit_latency));
  } else {
    out.warning("idle states",
                fmt::format("{} takes {} us to leave, and nothing holds the processor awake", deepest->name,
                            deepest->exit_latency),
                fmt::format("install systemd/60-cansyncd.rules in /etc/udev/rules.d (lets the daemon hold "
                            "/dev/cpu_dma_latency), or: cpupower idle-set -D {}",
                            kLongestIdleLatency));
  }
}

void look_at_kernel(const DoctorInput& in, FindingList& out) {
  const MachineFacts& machine = in.machine;
  const std::string found =
      fmt::format("{} ({})", machine.kernel.empty() ? "unknown" : machine.kernel,
                  machine.preemption.empty() ? "preemption unknown" : machine.preemption);
  if (machine.preemption == "PREEMPT_RT")
    out.ok("kernel", found);
  else
    out.warning("kernel", found + ": not a realtime kernel", "apt install linux-image-rt-amd64; reboot");
}

/// Programs of a domain on this computer: with none left the next one cannot start.
void look_at_places(const DoctorInput& in, FindingList& out) {
  constexpr std::uint32_t kMany = 80;  // of 120
  const std::string found = text_of(in.places);
  if (std::max(in.places.serving, in.places.asking) < kMany)
    out.ok("DDS places", found);
  else
    out.warning("DDS places", found + ": the next programs may find none",
                "end programs that are not needed (`cansync clients`, `ss -ulpn`), or give groups of buses a "
                "dds.domain of their own");
}

void look_at_dds(const DoctorInput& in, const Status& status, FindingList& out) {
  const std::string peers = fmt::format("other participants in the domain: {}", in.participants);
  const std::string_view interface = status.gateway.dds_interface;
  const std::string_view power = status.has_sync ? "move drives" : "send frames";
  if (status.gateway.secured)
    out.ok("DDS", fmt::format("{}, DDS Security on: only who has an identity sees or does anything; {}",
                              interface.empty() ? "set up by dds.xml" : interface, peers));
  else if (interface == "lo")
    out.ok("DDS", fmt::format("lo: this computer alone, every program on it can {}; {}", power, peers));
  else if (interface.empty())
    out.warning("DDS", "set up by dds.xml, DDS Security off; " + peers,
                "see that no program on the network can reach it, or use DDS Security (docs/security.md)");
  else
    out.warning("DDS", fmt::format("{}: every program on that network can {}; {}", interface, power, peers),
                "set dds.interface = \"lo\", or use DDS Security (docs/security.md)");
}

/// Who may not ask the daemon has the bus itself.
void look_at_bus_access(const DoctorInput& in, const Status& status, FindingList& out) {
  if (!status.gateway.secured || in.interface_name == kSimulated || is_elsewhere(in)) return;
  if (is_apart(in))
    out.ok("bus access", "no other program of this computer can send on the bus");
  else if (in.link.present)
    out.warning("bus access",
                fmt::format("every program of this computer can send on {}, whatever DDS Security lets it do",
                            in.interface_name),
                "put it into a network namespace with the daemon: examples cansync-apart@.service and "
                "apart.conf (docs/security.md, \"The bus itself\")");
}

/// A daemon that is not where its configuration wants it.
void look_at_network(const Status& status, FindingList& out) {
  const std::string_view reason = status.gateway.network_reason;
  if (reason.empty()) return;
  const bool taken = !std::string_view(status.gateway.name_taken_by).empty();
  out.warning(
      "network", std::string(reason),
      taken ? "give one of the two buses another bus.name, or stop the other daemon; programs of this "
              "computer reach this one with --interface lo"
            : "look with: ip address; the daemon joins the network when the interface can be used, programs "
              "of this computer reach it with --interface lo");
}

/// DDS removes the daemon when its identity ends.
void look_at_identity(const Status& status, FindingList& out) {
  constexpr std::uint32_t kSince = 8;    // data model that tells it
  constexpr std::int64_t kDay = 86'400;  // s
  constexpr std::int64_t kNotice = 30 * kDay;
  if (!status.gateway.secured || status.gateway.data_model < kSince) return;
  const std::int64_t left = status.gateway.identity_time_left;
  const std::string remedy =
      "cansync-security renew DIR NAME where the authorities are, copy the folder, restart the daemon when the line may "
      "stop; `cansync events` names the file";
  if (left <= 0)
    out.error("identity", "the daemon's identity of DDS Security has ended", remedy);
  else if (left <= kNotice)
    out.warning("identity",
                fmt::format("the daemon's identity of DDS Security ends in {}; then no client reaches it",
                            left < kDay ? std::string("less than a day")
                                        : text::counted(static_cast<std::uint64_t>(left / kDay), "day")),
                remedy);
  else
    out.ok("identity",
           fmt::format("valid for {}", text::counted(static_cast<std::uint64_t>(left / kDay), "day")));
}

void look_at_incompatible(const DoctorInput& in, FindingList& out) {
  if (in.incompatible == 0) return;
  out.error(
      "dds_incompatible",
      fmt::format("{} on this bus's topics can neither hear the daemon nor be heard{}",
                  text::counted(in.incompatible, "program"),
                  in.newest_incompatible.empty() ? "" : "; the newest: " + in.newest_incompatible),
      "give the program the QoS, the types and the data model of the daemon (docs/dds-api.md, \"Other DDS "
      "implementations\"); `cansync events` names them");
}

void look_at_second_master(const client::MasterStatus& status, FindingList& out) {
  const std::string remedy =
      "switch the other master off; `cansync events` says when, `cansync trace` shows its telegrams";
  const std::uint64_t frames = status.second_master_frames;
  if (status.second_master)
    out.error("second master",
              fmt::format("another master sends on this bus: {} so far; state: {}",
                          text::counted(frames, "frame"), client::text(status.state)),
              remedy);
  else if (frames != 0)
    out.warning(
        "second master",
        fmt::format("another master has sent {}; none in the last 3 s", text::counted(frames, "frame")),
        remedy);
  else
    out.ok("second master", "none was heard");
}

/// A daemon that runs another configuration than the file on disk, or did not accept it in a reload.
void look_at_configuration(const DoctorInput& in, const Status& status, FindingList& out) {
  const std::string_view reason = status.gateway.configuration_reason;
  if (reason.empty() && in.reload_refused.empty()) return;
  out.warning(
      "configuration",
      reason.empty() ? "the file on disk is not what runs: " + in.reload_refused : std::string(reason),
      fmt::format(
          "cansyncd --check /etc/cansync/{}.toml; then systemctl reload {}, or restart where a restart is named",
          in.unit, unit_of(in)));
}

void look_at_sync(const DoctorInput& in, const Status& status, FindingList& out) {
  const std::string_view input = status.realtime.sync_input;
  const std::string_view output = status.realtime.sync_output;
  const std::string_view state = status.realtime.sync_state;
  if (state == "holdover") {
    out.warning("SYNC", fmt::format("edges of the input {} are missing; the daemon goes on by itself", input),
                "check the device that makes SYNC and its line; cansync events");
  } else if (!state.empty() && state != "locked") {
    out.error("SYNC", fmt::format("follows the input {}: {}", input, state),
              "check the device that makes SYNC and its line; cansync events");
  } else if (in.status->master && in.interface_name != kSimulated && output == "none" && state.empty()) {
    out.warning("SYNC", "is put out nowhere: no slave can lock to it", "set sync.output to gpio, phc or can");
  } else {
    out.ok("SYNC", state.empty() ? fmt::format("made by the daemon, output {}", output)
                                 : fmt::format("locked to the input {}, output {}", input, output));
  }
}

/// What a daemon that only looks on refuses.
bool is_refused_by_read_only(std::string_view remedy) {
  constexpr std::array<std::string_view, 4> kChanging = {"cansync mode", "cansync release", "cansync control",
                                                         "cansync can "};
  return std::any_of(kChanging.begin(), kChanging.end(),
                     [remedy](std::string_view verb) { return remedy.find(verb) != remedy.npos; });
}

/// A read-only daemon takes none of the commands that its remedies name.
void say_read_only(const DoctorInput& in, std::vector<Finding>& findings) {
  if (!in.status || !in.status->gateway.read_only) return;
  const std::string first =
      fmt::format("set access.read_only = false and systemctl reload {}, then: ", unit_of(in));
  for (Finding& finding : findings) {
    if (!is_refused_by_read_only(finding.remedy)) continue;
    finding.remedy = first + finding.remedy;
    if (!finding.remedy_form.empty()) finding.remedy_form = first + finding.remedy_form;
  }
}

}  // namespace

std::string_view name(Level level) noexcept {
  switch (level) {
    case Level::ok:
      return "ok";
    case Level::warning:
      return "warning";
    case Level::error:
      return "error";
  }
  return "unknown";
}

std::vector<Finding> diagnose(const DoctorInput& in) {
  FindingList out;
  look_at_daemon(in, out);
  if (in.status) look_at_versions(in, *in.status, out);
  look_at_link(in, out);
  look_at_controller(in, out);
  if (in.status) {
    look_at_timestamps(in, *in.status, out);
    if (in.status->has_sync) look_at_sync(in, *in.status, out);
    if (in.status->master) {
      look_at_second_master(*in.status->master, out);
      look_at_line(in, out);
    }
    out.add(in.of_protocol);
    look_at_configuration(in, *in.status, out);
    look_at_rights(in, *in.status, out);
    look_at_processor(in, *in.status, out);
  }
  look_at_idle_states(in, out);
  look_at_kernel(in, out);
  // Where a simulated line runs, no machine does.
  if (in.interface_name != kSimulated) {
    look_at_host(in.host, out);
    if (in.status) {
      const bool in_run = in.status->master && (in.status->master->option_status & kInRun) != 0;
      look_at_inhibitors(in.host, in.status->gateway.process, in_run, out);
    }
  }
  if (in.status) {
    look_at_dds(in, *in.status, out);
    look_at_bus_access(in, *in.status, out);
    look_at_network(*in.status, out);
    look_at_identity(*in.status, out);
  }
  look_at_places(in, out);
  look_at_incompatible(in, out);
  std::vector<Finding> findings = std::move(out).take();
  say_read_only(in, findings);
  return findings;
}

std::vector<Finding> with_options(std::vector<Finding> findings, std::string_view options) {
  if (options.empty()) return findings;
  constexpr std::string_view kProgram = "cansync ";
  // Those look at files and interfaces, not at a daemon.
  constexpr std::array<std::string_view, 3> kWithoutDaemon = {"learn", "scan", "setup"};
  const std::string inserted = std::string(options) + " ";
  const auto insert = [&](std::string& text) {
    for (std::size_t at = 0; (at = text.find(kProgram, at)) != std::string::npos;) {
      at += kProgram.size();
      const std::string_view verb = std::string_view(text).substr(at);
      const bool apart = std::any_of(kWithoutDaemon.begin(), kWithoutDaemon.end(),
                                     [verb](std::string_view one) { return verb.starts_with(one); });
      if (!apart) text.insert(at, inserted);
    }
  };
  for (Finding& finding : findings) {
    insert(finding.remedy);
    insert(finding.remedy_form);
  }
  return findings;
}

std::vector<Finding> grouped(const std::vector<Finding>& findings) {
  std::vector<Finding> out;
  for (const Finding& finding : findings) {
    const auto same = [&finding](const Finding& other) {
      return finding.slaves != 0 && other.slaves != 0 && other.level == finding.level &&
             other.topic == finding.topic && other.alike == finding.alike &&
             other.remedy_form == finding.remedy_form;
    };
    const auto group = std::find_if(out.begin(), out.end(), same);
    if (group == out.end()) {
      out.push_back(finding);
      continue;
    }
    group->slaves |= finding.slaves;
    const std::string numbers = format_slave_set(group->slaves);
    group->found = fmt::format("{} ({}): {}",
                               text::counted(static_cast<std::size_t>(std::popcount(group->slaves)), "slave"),
                               numbers, group->alike);
    group->remedy = group->remedy_form;
    for (std::size_t at = 0; (at = group->remedy.find(kSlavesHere)) != std::string::npos;)
      group->remedy.replace(at, kSlavesHere.size(), numbers);
  }
  return out;
}

const Finding* first_to_fix(const std::vector<Finding>& findings) {
  const auto first = [&findings](Level level, bool state) {
    return std::find_if(findings.begin(), findings.end(), [&](const Finding& one) {
      return one.level == level && !one.remedy.empty() && (one.topic == "operating state") == state;
    });
  };
  for (const Level level : {Level::error, Level::warning})
    for (const bool state : {false, true})
      if (const auto found = first(level, state); found != findings.end()) return &*found;
  return nullptr;
}

std::string summary(const std::vector<Finding>& findings) {
  std::string out;
  for (const Level level : {Level::error, Level::warning}) {
    std::vector<std::string> topics;
    std::size_t count = 0;
    for (const Finding& finding : findings) {
      if (finding.level != level) continue;
      ++count;
      if (std::find(topics.begin(), topics.end(), finding.topic) == topics.end())
        topics.push_back(finding.topic);
    }
    if (count == 0) continue;
    out += fmt::format("{}{}: {}", out.empty() ? "" : "; ", text::counted(count, name(level)),
                       fmt::join(topics, ", "));
  }
  return out.empty() ? "everything is ok" : out;
}

ExitCode exit_code(const std::vector<Finding>& findings, bool daemon_found) noexcept {
  if (!daemon_found) return ExitCode::not_reachable;
  const auto any = [&findings](Level level) {
    return std::any_of(findings.begin(), findings.end(),
                       [level](const Finding& f) { return f.level == level; });
  };
  if (any(Level::error)) return ExitCode::faults;
  return any(Level::warning) ? ExitCode::failed : ExitCode::done;
}

}  // namespace cansync::cli
