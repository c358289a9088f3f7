#include "cli/doctor/doctor_line.h"

#include <fmt/format.h>

#include <bit>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "cli/base/status_refusal.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

constexpr const char* kMissingSlaveRemedy =
    "switch the drive on, check its slave number, bit rate and wiring; `cansync trace` shows what it answers";

// w_OPTION_STATUS of a master.
constexpr std::uint16_t kLineInSetUp = 0x0043;
constexpr std::uint16_t kLineActive = 0x0080;

bool is_in(const client::MasterStatus& master, std::uint16_t state) noexcept {
  return master.option_status == state;
}

/// Where the mode alone does not bring set-up: what has to come before.
std::string before_set_up(const DaemonStatus& status) {
  const std::string_view state = client::text(status.master->state);
  const std::string_view link = client::text(status.bus.link_state);
  if (link == "missing" || link == "down")
    return "fix the interface first, see above; when the state stays: ";
  if (status.master->second_master) return "switch the other master off and wait 3 s; when the state stays: ";
  if (state.starts_with("listening")) return "wait until it has listened; when the state stays: ";
  if (state.find("upper bus") != state.npos) return "start the upper bus first; when the state stays: ";
  return {};
}

void look_at_state_of_master(const DaemonStatus& status, FindingList& out) {
  const client::MasterStatus& master = *status.master;
  constexpr const char* kTopic = "operating state";
  if (is_in(master, kLineActive)) {
    out.ok(kTopic, master.state);
  } else if (!is_in(master, kLineInSetUp)) {
    out.warning(kTopic,
                fmt::format("{}: no SYNC is made, and no slave is asked or told anything", master.state),
                before_set_up(status) + "cansync mode setup, then cansync mode run");
  } else if ((master.slaves_configured & ~master.slaves_released) != 0) {
    out.error(kTopic,
              fmt::format("{}: waits for slaves, see below; no reference value goes out", master.state),
              "fix the slaves; or go without them: cansync mode run, with --force when that is refused");
  } else {
    out.warning(kTopic,
                fmt::format("{}: every slave is ready, but no reference value goes out", master.state),
                "cansync mode run");
  }
}

/// "3.2 s ago" for the interval in which a slave answered last.
std::string seconds_ago(const client::MasterStatus& master, std::uint64_t interval) {
  constexpr double kSecond = 1e9;  // ns
  const std::uint64_t passed = master.interval > interval ? master.interval - interval : 0;
  return fmt::format("{:.1f} s ago", static_cast<double>(passed * master.interval_length) / kSecond);
}

std::string slave_called(const client::SlaveStatus& slave) {
  const std::string_view name = slave.name;
  return name.empty() ? fmt::format("slave {}", slave.slave)
                      : fmt::format("slave {} '{}'", slave.slave, name);
}

/// What keeps a slave from use; nothing: it is as it should be.
std::optional<std::pair<Level, SlaveFinding>> slave_problem(const client::MasterStatus& master,
                                                            const client::SlaveStatus& slave) {
  const std::string_view state = slave.state;
  const std::string who = slave_called(slave);
  const auto of = [&](Level level, std::string found, std::string alike, std::string remedy) {
    return std::pair(level, SlaveFinding{slave.slave, std::move(found), std::move(alike), std::move(remedy)});
  };
  if (state == "absent")
    return of(Level::error, who + " has never answered", "never answered", kMissingSlaveRemedy);
  if (state == "lost")
    return of(Level::error,
              fmt::format("{} has stopped answering; its last answer came {}", who,
                          seconds_ago(master, slave.last_seen)),
              "stopped answering", kMissingSlaveRemedy);
  if (state == "held")
    return of(Level::error, fmt::format("{} is held out: {}", who, slave.held_reason),
              fmt::format("held out: {}", slave.held_reason),
              "connect the right drive or correct the value, then: cansync release {slaves}; as it is: "
              "cansync release {slaves} --force");
  if (!slave.synchronized)
    return of(Level::error, who + " answers, but is not synchronized", "answer, but are not synchronized",
              "check its SYNC line and cable, and SYNC above; the drive's own display says more");
  if (state == "checking" || state == "returning" || state == "starting")
    return of(Level::warning, fmt::format("{} is {}: not to be used yet", who, state),
              fmt::format("{}: not to be used yet", state), "wait for it: cansync wait released {slaves}");
  return std::nullopt;
}

/// False when the slave is not as it should be, which is told.
bool look_at_slave(const client::MasterStatus& master, const client::SlaveStatus& slave, FindingList& out) {
  const std::string_view state = slave.state;
  if (state != "absent" && state != "lost" && state != "held" && lacks_status_word(slave)) {
    out.add_slave(Level::error, "status word",
                  {slave.slave, status_refusal(slave), status_refusal_alike(slave), kStatusRefusalRemedy});
    return false;
  }
  auto problem = slave_problem(master, slave);
  if (!problem) return true;
  out.add_slave(problem->first, "slave", std::move(problem->second));
  return false;
}

/// "3, 5" for the bits of a mask.
std::string numbers_of(std::uint32_t mask) {
  std::string text;
  for (unsigned n = 0; n < 32; ++n) {
    if (((mask >> n) & 1u) != 0) text += fmt::format("{}{}", text.empty() ? "" : ", ", n);
  }
  return text;
}

/// False when a drive is on the bus that should not be there, which is told.
bool look_at_strangers(const client::MasterStatus& master, FindingList& out) {
  if (master.slaves_duplicate != 0) {
    out.error("duplicate slave",
              fmt::format("two drives answer as slave {}: both follow every command",
                          numbers_of(master.slaves_duplicate)),
              "disconnect one of them, or give it another number; then: cansync release NUMBER");
  }
  if (master.slaves_unknown != 0) {
    out.warning(
        "unknown slave",
        fmt::format("slave {} answers and is not in the configuration", numbers_of(master.slaves_unknown)),
        "add it to the configuration ([[slave]]), or disconnect it");
  }
  return master.slaves_duplicate == 0 && master.slaves_unknown == 0;
}

void look_at_slaves(const DaemonStatus& status, FindingList& out) {
  const client::MasterStatus& master = *status.master;
  // Without SYNC nobody is asked, and what was known is past.
  if (!is_in(master, kLineActive) && !is_in(master, kLineInSetUp)) return;
  bool well = look_at_strangers(master, out);
  for (const client::SlaveStatus& slave : status.slaves) {
    if (!look_at_slave(master, slave, out)) well = false;
    if (const auto fault = status.faults.find(slave.slave); fault != status.faults.end() && slave.responds) {
      out.add_slave(
          Level::error, "drive fault",
          {slave.slave, fmt::format("{}: {}", slave_called(slave), fault->second), fault->second,
           "remove the cause (cansync params {slaves} shows the drive's own words), then acknowledge it "
           "with the drive's control word: cansync control {slaves} WORD"});
      well = false;
    }
  }
  if (const auto configured = static_cast<std::size_t>(std::popcount(master.slaves_configured));
      status.slaves.size() < configured) {
    out.warning("slaves",
                fmt::format("the daemon has told of {} of the {} configured slaves", status.slaves.size(),
                            configured),
                "call cansync doctor again; cansync slaves names those that are missing");
    well = false;
  }
  if (well) out.ok("slaves", fmt::format("all {} answer and are synchronized", status.slaves.size()));
}

void look_at_references(const client::MasterStatus& master, FindingList& out) {
  if (!is_in(master, kLineActive)) return;
  unsigned telegram = 0;
  for (const auto& release : master.reference_release) {
    const std::string topic = fmt::format("references {}", ++telegram);
    const std::string_view state = release.state;
    const std::string_view cause = release.cause;
    if (state == "released") {
      out.ok(topic, fmt::format("given by {}", release.writer));
    } else if (cause == "writer_lost" || cause == "deadline_missed" || cause == "too_old" ||
               cause == "mapping_changed") {
      out.warning(topic, fmt::format("{} because of {}: a drive that needs them faults", state, cause),
                  "look at the program that gives them; cansync events says when it ended");
    } else if (cause == "bus_lost") {
      out.warning(topic,
                  fmt::format("{}: what was given before the bus was lost is not sent any more", state),
                  "let the program give new values; cansync events says what the bus had");
    } else if (cause.empty() || cause == "none_given") {
      out.ok(topic, "nobody has given any");
    } else {
      out.ok(topic, fmt::format("{} ({})", state, cause));
    }
  }
}

void look_at_limits(const DaemonStatus& status, FindingList& out) {
  const client::MasterStatus& master = *status.master;
  std::string values;
  for (unsigned value = 0; value < std::size(master.reference_value); ++value) {
    if (((master.references_unlimited >> value) & 1u) == 0) continue;
    const std::string_view name = master.reference_value[value].name;
    values += fmt::format("{}{}", values.empty() ? "" : ", ", value);
    if (!name.empty()) values += fmt::format(" '{}'", name);
  }
  // Simulated drives break nothing.
  if (values.empty() || status.bus.bus_interface == std::string_view("sim")) return;
  out.warning(
      "limits",
      fmt::format("no minimum, maximum or max_step for reference values {}: drives get any value", values),
      "set them in [[reference]] of the configuration; cansync learn proposes them");
}

void look_at_misses(const DoctorInput& in, FindingList& out) {
  const std::uint64_t syncs = in.status->realtime.missed_syncs;
  const std::uint64_t telegrams = in.status->master->left_out;
  if (syncs == 0 && telegrams == 0) {
    out.ok("missed", "no SYNC edge, no telegram left out");
    return;
  }
  out.warning(
      "missed",
      fmt::format("{}, {} left out since the start{}", text::counted(syncs, "SYNC edge"),
                  text::counted(telegrams, "telegram"),
                  in.newest_missed.empty() ? "" : "; the newest at " + in.newest_missed),
      "see priority, processor, idle states and kernel below; cansync timing --follow shows whether it "
      "goes on");
}

}  // namespace

void look_at_line(const DoctorInput& in, FindingList& out) {
  const client::MasterStatus& master = *in.status->master;
  look_at_state_of_master(*in.status, out);
  look_at_slaves(*in.status, out);
  look_at_references(master, out);
  look_at_limits(*in.status, out);
  look_at_misses(in, out);
}

}  // namespace cansync::cli
