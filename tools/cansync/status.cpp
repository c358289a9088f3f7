#include <fmt/format.h>

#include <cstdint>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "cansync/verbs.h"

namespace cansync::cli {
namespace {

struct SlavesOptions {
  std::vector<std::string> slaves;
};

JsonObject value_names(const cansync_ValueName& value) {
  return JsonObject()
      .add("name", value.name)
      .add("unit", value.unit_symbol)
      .add("factor", value.factor)
      .add("offset", value.offset);
}

JsonArray release_objects(const client::MasterStatus& status) {
  JsonArray out;
  for (const auto& release : status.reference_release) {
    out.add_json(JsonObject()
                     .add("writer", release.writer)
                     .add("strength", release.strength)
                     .add("state", release.state)
                     .add("cause", release.cause)
                     .add("interval", release.interval)
                     .add("updates", release.updates)
                     .add("too_old", release.too_old)
                     .text());
  }
  return out;
}

/// "released, given by 'lead axis' (lead_axis, process 1234 on host plc7), strength 5"
std::string release_text(const cansync_ReferenceRelease& release) {
  std::string text = release.state;
  if (release.cause[0] != '\0') text += fmt::format(" ({})", release.cause);
  if (release.writer[0] == '\0') return text + ", given by nobody";
  return text + fmt::format(", given by {}, strength {}", release.writer, release.strength);
}

/// The counts of received frames that were not taken, by kind.
void add_frame_kinds(JsonObject& object, const client::MasterStatus& status) {
  object.add("frames_foreign", status.frames_foreign)
      .add("frames_extended", status.frames_extended)
      .add("frames_remote", status.frames_remote)
      .add("frames_error", status.frames_error)
      .add("frames_slave_number", status.frames_slave_number)
      .add("frames_length", status.frames_length)
      .add("frames_reserved", status.frames_reserved)
      .add("unexpected_slave", status.unexpected_slave)
      .add("unexpected_answer", status.unexpected_answer)
      .add("unexpected_late", status.unexpected_late)
      .add("unexpected_duplicate", status.unexpected_duplicate)
      .add("unexpected_unasked", status.unexpected_unasked);
}

/// Who asks, and the counts of requests that were not taken, by kind.
void add_request_kinds(JsonObject& object, const client::MasterStatus& status) {
  object.add("clients", status.clients)
      .add("rejected_values", status.rejected_values)
      .add("rejected_full", status.rejected_full)
      .add("rejected_stale", status.rejected_stale)
      .add("rejected_numbers", status.rejected_numbers)
      .add("rejected_identities", status.rejected_identities)
      .add("rejected_malformed", status.rejected_malformed)
      .add("rejected_state", status.rejected_state);
}

JsonObject status_object(const client::MasterStatus& status) {
  JsonArray names;
  for (const auto& value : status.reference_value) names.add_json(value_names(value).text());
  JsonObject object;
  object.add("bus", status.bus)
      .add("version", status.version)
      .add("state", status.state)
      .add("option_status", status.option_status)
      .add("cansync_status", status.cansync_status)
      .add("bit_rate", status.bit_rate)
      .add("interval_length_ns", status.interval_length)
      .add("interval", status.interval)
      .add("controller_state", status.controller_state)
      .add("transmit_errors", status.transmit_errors)
      .add("receive_errors", status.receive_errors)
      .add("slaves_configured", status.slaves_configured)
      .add("slaves_responding", status.slaves_responding)
      .add("slaves_synchronized", status.slaves_synchronized)
      .add("slaves_released", status.slaves_released)
      .add("open_parameter_jobs", status.open_parameter_jobs)
      .add("open_transfers", status.open_transfers)
      .add("parameter_queue", status.parameter_queue)
      .add("transfer_queue", status.transfer_queue)
      .add("telegrams_sent", status.telegrams_sent)
      .add("left_out", status.left_out)
      .add("references_not_released", status.references_not_released)
      .add("rejected_frames", status.rejected_frames)
      .add("unexpected_frames", status.unexpected_frames)
      .add("missed_syncs", status.missed_syncs)
      .add("lost_reports", status.lost_reports)
      .add("serving", status.serving)
      .add("sync_output", status.sync_output)
      .add("sync_input", status.sync_input)
      .add("sync_state", status.sync_state)
      .add("sync_phase_error_ns", status.sync_phase_error)
      .add("sync_holdover_ns", status.sync_holdover)
      .add("sync_edges", status.sync_edges)
      .add("sync_rejected_edges", status.sync_rejected_edges)
      .add("sync_output_failures", status.sync_output_failures)
      .add("link_state", status.link_state)
      .add("timestamp_source", status.timestamp_source)
      .add("interface_bit_rate", status.interface_bit_rate)
      .add("sample_point_permille", status.sample_point)
      .add("restart_ms", status.restart_time)
      .add("queue_length", status.queue_length)
      .add("error_frames", status.error_frames)
      .add("acknowledge_errors", status.acknowledge_errors)
      .add("restarts", status.restarts)
      .add("queue_full", status.queue_full)
      .add("overruns", status.overruns)
      .add("dropped_frames", status.dropped_frames)
      .add("second_master", status.second_master)
      .add("second_master_frames", status.second_master_frames);
  add_request_kinds(object, status);
  add_frame_kinds(object, status);
  return object.add("reference_values", names)
      .add("reference_release", release_objects(status))
      .add("read_only", status.read_only)
      .add("secured", status.secured);
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

void print_status(Output& output, const client::MasterStatus& status) {
  const auto row = [&output](std::string_view label, const std::string& text) {
    output.line(fmt::format("{:<22}{}", label, text));
  };
  row("bus", fmt::format("{}, cansyncd {}", status.bus, status.version));
  row("state", fmt::format("{} (0x{:04X})", status.state, status.option_status));
  row("bit rate",
      fmt::format("{} bit/s, an interval takes {} us", status.bit_rate, status.interval_length / 1000));
  row("interval", fmt::format("{}", status.interval));
  row("controller",
      fmt::format("{}; errors: {} transmit, {} receive; CANsync status 0x{:04X}", status.controller_state,
                  status.transmit_errors, status.receive_errors, status.cansync_status));
  row("access", fmt::format("{}, DDS Security {}", status.read_only ? "read-only" : "requests are taken",
                            status.secured ? "on" : "off"));
  if (const std::string line = sync_line(status); !line.empty()) row("SYNC line", line);
  row("interface", interface_text(status));
  row("bus faults", fmt::format("{} error frames, {} not acknowledged, {} restarts; lost: {} for a full send "
                                "queue, {} in the controller, {} in the kernel",
                                status.error_frames, status.acknowledge_errors, status.restarts,
                                status.queue_full, status.overruns, status.dropped_frames));
  if (status.second_master || status.second_master_frames != 0) {
    row("second master",
        fmt::format("{}, {} of its frames seen", status.second_master ? "on the bus" : "gone",
                    status.second_master_frames));
  }
  row("slaves configured", format_slave_set(status.slaves_configured));
  row("slaves responding", share(status.slaves_responding, status.slaves_configured));
  row("slaves synchronized", share(status.slaves_synchronized, status.slaves_configured));
  row("slaves released", share(status.slaves_released, status.slaves_configured));
  row("open jobs",
      fmt::format("{} of {} parameter jobs, {} of {} transfers; served: {}", status.open_parameter_jobs,
                  status.parameter_queue, status.open_transfers, status.transfer_queue, status.serving));
  row("telegrams sent", fmt::format("{}", status.telegrams_sent));
  row("telegrams left out", fmt::format("{}", status.left_out));
  for (std::size_t i = 0; i < std::size(status.reference_release); ++i) {
    row(fmt::format("reference telegram {}", i + 1), release_text(status.reference_release[i]));
  }
  row("no reference values", fmt::format("{} telegrams", status.references_not_released));
  row("frames", frames_text(status));
  row("clients",
      fmt::format(
          "{}; requests rejected: {} values, {} limits, {} stale, {} numbers, {} identities, {} malformed, "
          "{} by the master",
          status.clients, status.rejected_values, status.rejected_full, status.rejected_stale,
          status.rejected_numbers, status.rejected_identities, status.rejected_malformed,
          status.rejected_state));
  row("missed", fmt::format("{} SYNC edges, {} reports", status.missed_syncs, status.lost_reports));
  for (std::size_t i = 0; i < std::size(status.reference_value); ++i) {
    const auto& value = status.reference_value[i];
    if (std::string_view(value.name).empty()) continue;
    row(fmt::format("reference value {}", i),
        fmt::format("{}, one step is {} {}", value.name, value.factor, value.unit_symbol));
  }
}

ExitCode status_verb(Session& session) {
  const client::MasterStatus status = session.client().master_status();
  if (session.json()) {
    session.output().object(status_object(status));
    return ExitCode::done;
  }
  print_status(session.output(), status);
  return ExitCode::done;
}

JsonObject slave_object(const client::SlaveStatus& slave) {
  JsonObject object;
  object.add("slave", slave.slave)
      .add("name", slave.name)
      .add("responds", slave.responds)
      .add("synchronized", slave.synchronized);
  if (slave.status_known)
    object.add("status_word", slave.status_word);
  else
    object.add_null("status_word");
  return object.add("last_seen_interval", slave.last_seen)
      .add("answers", slave.answers)
      .add("unanswered", slave.unanswered)
      .add("missed_actual", slave.missed_actual)
      .add("slow_answers", slave.slow_answers)
      .add("last_response_ns", slave.last_response)
      .add("longest_response_ns", slave.longest_response)
      .add("state", slave.state)
      .add("times_lost", slave.times_lost)
      .add("times_returned", slave.times_returned)
      .add("jobs_ended", slave.jobs_ended);
}

void add_slave_row(Table& table, const client::SlaveStatus& slave) {
  const auto microseconds = [](std::int64_t time) {
    return fmt::format("{:.1f}", static_cast<double>(time) / 1e3);
  };
  table.add({fmt::format("{}", slave.slave), slave.name, slave.state, slave.responds ? "yes" : "no",
             slave.synchronized ? "yes" : "no",
             slave.status_known ? fmt::format("0x{:04X}", slave.status_word) : "-",
             fmt::format("{}", slave.last_seen), fmt::format("{}", slave.answers),
             fmt::format("{}", slave.unanswered), fmt::format("{}", slave.missed_actual),
             fmt::format("{}", slave.slow_answers), microseconds(slave.last_response),
             microseconds(slave.longest_response), fmt::format("{}", slave.times_lost),
             fmt::format("{}", slave.times_returned), fmt::format("{}", slave.jobs_ended)});
}

ExitCode slaves_verb(Session& session, const SlavesOptions& options) {
  const std::uint32_t wanted = session.configured_slaves(options.slaves);
  constexpr auto right = Table::Align::right;
  Table table({{"SLAVE", right},
               {"NAME"},
               {"STATE"},
               {"RESPONDS"},
               {"SYNCHRONIZED"},
               {"STATUS"},
               {"LAST SEEN", right},
               {"ANSWERS", right},
               {"UNANSWERED", right},
               {"MISSED", right},
               {"SLOW", right},
               {"LAST us", right},
               {"LONGEST us", right},
               {"LOST", right},
               {"RETURNED", right},
               {"JOBS ENDED", right}});
  for (const client::SlaveStatus& slave : session.client().slaves()) {
    if (((wanted >> slave.slave) & 1u) == 0) continue;
    if (session.json())
      session.output().object(slave_object(slave));
    else
      add_slave_row(table, slave);
  }
  if (!session.json()) session.output().table(table);
  return ExitCode::done;
}

}  // namespace

void add_status_verbs(CLI::App& app, Verb& chosen) {
  auto* status = app.add_subcommand("status", "the master: operating state, slaves, jobs, counters");
  status->footer(
      "Lines:\n"
      "  state                operating state, with w_OPTION_STATUS\n"
      "  controller           state and error counters of the CAN controller, with w_CANsync_STATUS\n"
      "  interface            state and settings of the CAN interface, and where the times of frames come "
      "from\n"
      "  bus faults           since the start; a full send queue and what is lost cost telegrams\n"
      "  second master        somebody else sends what only a master may send\n"
      "  slaves ...           which slaves are configured, answer, have locked to SYNC, and may be used with "
      "references\n"
      "  telegrams left out   not sent because their slot had passed\n"
      "  no reference values  active intervals in which a reference value telegram had nothing to send\n"
      "  frames               received ones that were no valid telegram, and ones nobody asked for, by kind\n"
      "  missed               SYNC edges skipped, and reports of the realtime thread without room");
  status->callback([&chosen] { chosen = status_verb; });

  auto* slaves = app.add_subcommand("slaves", "one line for each slave: does it answer, and how fast");
  auto slaves_options = std::make_shared<SlavesOptions>();
  slaves->add_option("SLAVE", slaves_options->slaves, "numbers or names (default: every configured slave)");
  slaves->footer(
      "Columns:\n"
      "  STATE         absent (never answered), starting, released; lost, then returning (waits for SYNC), "
      "checking\n"
      "                (its return parameters), and held (they are not right; see `events`, then `release`)\n"
      "  STATUS        last status word of the slave; - = never read since it responds\n"
      "  LAST SEEN     interval of its last telegram\n"
      "  ANSWERS       answers on the command channel; UNANSWERED: commands without one\n"
      "  MISSED        times it was asked for actual values and sent none\n"
      "  SLOW          answers later than tRSPTO\n"
      "  LAST, LONGEST time from the end of a command to the end of its answer\n"
      "  LOST          times it stopped answering; RETURNED: answered again\n"
      "  JOBS ENDED    jobs that ended because it stopped answering");
  slaves->callback([slaves_options, &chosen] {
    chosen = [slaves_options](Session& session) { return slaves_verb(session, *slaves_options); };
  });
}

}  // namespace cansync::cli
