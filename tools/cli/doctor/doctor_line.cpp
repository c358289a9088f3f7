#include "cli/doctor/doctor_line.h"

#include <fmt/format.h>

#include <string>
#include <string_view>

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

void look_at_state_of_master(const client::MasterStatus& master, FindingList& out) {
  constexpr const char* kTopic = "operating state";
  if (is_in(master, kLineActive)) {
    out.ok(kTopic, master.state);
  } else if (!is_in(master, kLineInSetUp)) {
    out.warning(kTopic,
                fmt::format("{}: no SYNC is made, and no slave is asked or told anything", master.state),
                "cansync mode setup, then cansync mode run");
  } else if ((master.slaves_configured & ~master.slaves_released) != 0) {
    out.error(kTopic,
              fmt::format("{}: waits for slaves, see below; no reference value goes out", master.state),
              "mend the slaves; or go without them: cansync mode run, with --force when that is refused");
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

/// False when the slave is not as it should be, which is told.
bool look_at_slave(const client::MasterStatus& master, const client::SlaveStatus& slave, FindingList& out) {
  const std::string_view state = slave.state;
  constexpr const char* kTopic = "slave";
  if (state == "absent") {
    out.error(kTopic, slave_called(slave) + " has never answered", kMissingSlaveRemedy);
  } else if (state == "lost") {
    out.error(kTopic,
              fmt::format("{} has stopped answering; its last answer came {}", slave_called(slave),
                          seconds_ago(master, slave.last_seen)),
              kMissingSlaveRemedy);
  } else if (state == "held") {
    out.error(
        kTopic, slave_called(slave) + " is held out: its return parameters are not right",
        fmt::format("cansync events says which; put them right, then: cansync release {}", slave.slave));
  } else if (lacks_status_word(slave)) {
    out.error("status word", status_refusal(slave), kStatusRefusalRemedy);
  } else if (!slave.synchronized) {
    out.error(kTopic, fmt::format("{} answers, but is not synchronized", slave_called(slave)),
              "check its SYNC line and cable, and SYNC above; the drive's own display says more");
  } else if (state == "checking" || state == "returning" || state == "starting") {
    out.warning(kTopic, fmt::format("{} is {}: not to be used yet", slave_called(slave), state),
                fmt::format("wait for it: cansync wait released {}", slave.slave));
  } else {
    return true;
  }
  return false;
}

void look_at_slaves(const DaemonStatus& status, FindingList& out) {
  const client::MasterStatus& master = *status.master;
  // Without SYNC nobody is asked, and what was known is past.
  if (!is_in(master, kLineActive) && !is_in(master, kLineInSetUp)) return;
  bool well = true;
  for (const client::SlaveStatus& slave : status.slaves) {
    if (!look_at_slave(master, slave, out)) well = false;
    if (const auto fault = status.faults.find(slave.slave); fault != status.faults.end() && slave.responds) {
      out.error(
          "drive fault", fmt::format("{}: {}", slave_called(slave), fault->second),
          fmt::format("mend the cause (cansync params {0} shows the drive's own words), then acknowledge it "
                      "with the drive's control word: cansync control {0} WORD",
                      slave.slave));
      well = false;
    }
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
    } else if (cause.empty() || cause == "none_given") {
      out.ok(topic, "nobody has given any");
    } else {
      out.ok(topic, fmt::format("{} ({})", state, cause));
    }
  }
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
  look_at_state_of_master(master, out);
  look_at_slaves(*in.status, out);
  look_at_references(master, out);
  look_at_misses(in, out);
}

}  // namespace cansync::cli
