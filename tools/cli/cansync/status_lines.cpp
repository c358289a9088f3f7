#include "cli/cansync/status_lines.h"

#include <fmt/format.h>

#include <cstdint>
#include <initializer_list>
#include <string_view>
#include <utility>

#include "cli/text/column_help.h"
#include "cli/text/values.h"

namespace cansync::cli {
namespace {

using Status = client::MasterStatus;

/// "released, given by 'lead axis' (lead_axis, process 1234 on host plc7), strength 5"
std::string release_text(const cansync_ReferenceRelease& release) {
  std::string text = release.state;
  if (release.cause[0] != '\0') text += fmt::format(" ({})", release.cause);
  if (release.writer[0] == '\0') return text + ", given by nobody";
  return text + fmt::format(", given by {}, strength {}", release.writer, release.strength);
}

/// "0-3 (4 of 4)".
std::string share(std::uint32_t mask, std::uint32_t of) {
  return fmt::format("{} ({} of {})", format_slave_set(mask), __builtin_popcount(mask),
                     __builtin_popcount(of));
}

/// "output gpio; follows pps: locked, 0.3 us off, 120 edges used, 1 rejected"; empty without a SYNC line.
std::string sync_line(const client::MasterStatus& status) {
  std::string text;
  if (std::string_view(status.sync_output) != "none" && !std::string_view(status.sync_output).empty()) {
    text = fmt::format("output {}", status.sync_output);
    if (status.sync_output_failures > 0)
      text += fmt::format(", {} edges failed", status.sync_output_failures);
  }
  if (std::string_view(status.sync_state).empty()) return text;
  constexpr double kMicrosecond = 1e3;
  constexpr double kMillisecond = 1e6;
  text += fmt::format("{}follows {}: {}, {:.1f} us off, {} edges used, {} rejected", text.empty() ? "" : "; ",
                      status.sync_input, status.sync_state,
                      static_cast<double>(status.sync_phase_error) / kMicrosecond, status.sync_edges,
                      status.sync_rejected_edges);
  if (status.sync_holdover > 0) {
    text += fmt::format(", none for {:.0f} ms", static_cast<double>(status.sync_holdover) / kMillisecond);
  }
  return text;
}

/// "can0 is up, 500000 bit/s, sample point 0.600, restart-ms 100, txqueuelen 10; times by the kernel".
std::string interface_text(const client::MasterStatus& status) {
  std::string text = fmt::format("{} is {}", status.bus_interface, status.link_state);
  if (status.interface_bit_rate != 0) text += fmt::format(", {} bit/s", status.interface_bit_rate);
  if (status.sample_point != 0) text += fmt::format(", sample point 0.{:03}", status.sample_point);
  if (status.restart_time >= 0) text += fmt::format(", restart-ms {}", status.restart_time);
  if (status.queue_length != 0) text += fmt::format(", txqueuelen {}", status.queue_length);
  return text + fmt::format("; times by: {}", status.timestamp_source);
}

/// " (3 of wrong length, 9 remote)": the kinds that there are; empty without any.
std::string kinds_text(std::initializer_list<std::pair<std::string_view, std::uint64_t>> kinds) {
  std::string text;
  for (const auto& [name, count] : kinds) {
    if (count != 0) text += fmt::format("{}{} {}", text.empty() ? " (" : ", ", count, name);
  }
  return text.empty() ? text : text + ")";
}

/// "12 rejected (3 of wrong length, 9 remote), 1 unexpected (1 late)".
std::string frames_text(const client::MasterStatus& status) {
  const std::string rejected = kinds_text({{"foreign", status.frames_foreign},
                                           {"extended", status.frames_extended},
                                           {"remote", status.frames_remote},
                                           {"error frames", status.frames_error},
                                           {"of a slave over 31", status.frames_slave_number},
                                           {"of wrong length", status.frames_length},
                                           {"with reserved bits", status.frames_reserved}});
  const std::string unexpected = kinds_text({{"of another slave than asked", status.unexpected_slave},
                                             {"with another answer than asked for", status.unexpected_answer},
                                             {"late", status.unexpected_late},
                                             {"twice", status.unexpected_duplicate},
                                             {"unasked", status.unexpected_unasked}});
  return fmt::format("{} rejected{}, {} unexpected{}", status.rejected_frames, rejected,
                     status.unexpected_frames, unexpected);
}

std::string bus_text(const Status& status, unsigned) {
  return fmt::format("{}, cansyncd {}", status.bus, status.version);
}

std::string state_text(const Status& status, unsigned) {
  return fmt::format("{} (0x{:04X})", status.state, status.option_status);
}

std::string bit_rate_text(const Status& status, unsigned) {
  return fmt::format("{} bit/s, an interval takes {} us", status.bit_rate, status.interval_length / 1000);
}

std::string controller_text(const Status& status, unsigned) {
  return fmt::format("{}; errors: {} transmit, {} receive; CANsync status 0x{:04X}", status.controller_state,
                     status.transmit_errors, status.receive_errors, status.cansync_status);
}

std::string access_text(const Status& status, unsigned) {
  return fmt::format("{}, DDS Security {}", status.read_only ? "read-only" : "requests are taken",
                     status.secured ? "on" : "off");
}

std::string bus_faults_text(const Status& status, unsigned) {
  return fmt::format(
      "{} error frames, {} not acknowledged, {} restarts; lost: {} for a full send queue, {} in the "
      "controller, {} in the kernel",
      status.error_frames, status.acknowledge_errors, status.restarts, status.queue_full, status.overruns,
      status.dropped_frames);
}

std::string second_master_text(const Status& status, unsigned) {
  if (!status.second_master && status.second_master_frames == 0) return "";
  return fmt::format("{}, {} of its frames seen", status.second_master ? "on the bus" : "gone",
                     status.second_master_frames);
}

std::string open_jobs_text(const Status& status, unsigned) {
  return fmt::format("{} of {} parameter jobs, {} of {} transfers; served: {}", status.open_parameter_jobs,
                     status.parameter_queue, status.open_transfers, status.transfer_queue, status.serving);
}

std::string clients_text(const Status& status, unsigned) {
  return fmt::format(
      "{}; requests rejected: {} values, {} limits, {} stale, {} numbers, {} identities, {} malformed, {} by "
      "the master",
      status.clients, status.rejected_values, status.rejected_full, status.rejected_stale,
      status.rejected_numbers, status.rejected_identities, status.rejected_malformed, status.rejected_state);
}

std::string missed_text(const Status& status, unsigned) {
  return fmt::format("{} SYNC edges, {} reports", status.missed_syncs, status.lost_reports);
}

std::string reference_value_text(const Status& status, unsigned number) {
  const auto& value = status.reference_value[number];
  if (std::string_view(value.name).empty()) return "";
  return fmt::format("{}, one step is {} {}", value.name, value.factor, value.unit_symbol);
}

/// A line, or several that differ in a number.
struct Line {
  std::string_view label;
  std::string_view help;
  std::string (*text)(const Status&, unsigned number);  ///< empty: the line is left out
  std::string_view number_name = "";  ///< of several: what stands for the number in the help
  unsigned first = 0;
  unsigned count = 1;
};

constexpr Line kLines[] = {
    {"bus", "its name, and the version of the daemon", bus_text},
    {"state", "operating state, with w_OPTION_STATUS", state_text},
    {"bit rate", "bit rate, and the length of an interval that follows from it", bit_rate_text},
    {"interval", "number of the present interval",
     [](const Status& status, unsigned) { return fmt::format("{}", status.interval); }},
    {"controller", "state and error counters of the CAN controller, with w_CANsync_STATUS", controller_text},
    {"access", "whether requests that change something are taken, and whether DDS Security is on",
     access_text},
    {"SYNC line",
     "where SYNC is put out, and what it follows with how much error; only with an output or input",
     [](const Status& status, unsigned) { return sync_line(status); }},
    {"interface", "state and settings of the CAN interface, and where the times of frames come from",
     [](const Status& status, unsigned) { return interface_text(status); }},
    {"bus faults", "since the start; a full send queue and what is lost cost telegrams", bus_faults_text},
    {"second master", "somebody else sends what only a master may send; only when one was seen",
     second_master_text},
    {"slaves configured", "those of the configuration",
     [](const Status& status, unsigned) { return format_slave_set(status.slaves_configured); }},
    {"slaves responding", "those that answer",
     [](const Status& status, unsigned) {
       return share(status.slaves_responding, status.slaves_configured);
     }},
    {"slaves synchronized", "those that have locked to SYNC",
     [](const Status& status, unsigned) {
       return share(status.slaves_synchronized, status.slaves_configured);
     }},
    {"slaves released", "those that may be used with reference values",
     [](const Status& status, unsigned) { return share(status.slaves_released, status.slaves_configured); }},
    {"open jobs", "queued and running ones, how many there may be, and whose are served", open_jobs_text},
    {"telegrams sent", "since the start",
     [](const Status& status, unsigned) { return fmt::format("{}", status.telegrams_sent); }},
    {"telegrams left out", "not sent because their slot had passed",
     [](const Status& status, unsigned) { return fmt::format("{}", status.left_out); }},
    {"reference telegram", "whether its values are released, why not, and who gives them with which strength",
     [](const Status& status, unsigned number) { return release_text(status.reference_release[number - 1]); },
     "1, 2", 1, 2},
    {"no reference values", "active intervals in which a reference value telegram had nothing to send",
     [](const Status& status, unsigned) {
       return fmt::format("{} telegrams", status.references_not_released);
     }},
    {"frames", "received ones that were no valid telegram, and ones nobody asked for, by kind",
     [](const Status& status, unsigned) { return frames_text(status); }},
    {"clients", "programs that use the daemon, and how many of their requests were rejected, by reason",
     clients_text},
    {"missed", "SYNC edges skipped, and reports of the realtime thread without room", missed_text},
    {"reference value", "name and scaling of each value that has a name", reference_value_text, "n", 0, 8},
};

std::string label(const Line& line, unsigned number) {
  return line.number_name.empty() ? std::string(line.label) : fmt::format("{} {}", line.label, number);
}

}  // namespace

std::vector<std::string> status_lines(const client::MasterStatus& status) {
  std::vector<std::string> out;
  for (const Line& line : kLines) {
    for (unsigned number = line.first; number < line.first + line.count; ++number) {
      const std::string text = line.text(status, number);
      if (!text.empty()) out.push_back(fmt::format("{:<22}{}", label(line, number), text));
    }
  }
  return out;
}

std::string status_lines_help() {
  std::vector<Explained> entries;
  for (const Line& line : kLines) {
    const std::string number = line.number_name.empty() ? "" : fmt::format(" {}", line.number_name);
    entries.emplace_back(std::string(line.label) + number, line.help);
  }
  return explanation("Lines", entries);
}

}  // namespace cansync::cli
