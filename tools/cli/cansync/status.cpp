#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "cli/cansync/status_lines.h"
#include "cli/cansync/verbs.h"
#include "cli/text/column_help.h"

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
      .add("offset", value.offset)
      .add("width", raw_form(value).width == Width::word ? 16 : 32)
      .add("signed", raw_form(value).is_signed);
}

/// 32 digits.
std::string hexadecimal(const std::uint8_t (&identity)[16]) {
  return fmt::format("{:02x}", fmt::join(identity, ""));
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

void add_sync(JsonObject& object, const client::MasterStatus& status) {
  object.add("sync_output", status.sync_output)
      .add("sync_input", status.sync_input)
      .add("sync_state", status.sync_state)
      .add("sync_phase_error_ns", status.sync_phase_error)
      .add("sync_holdover_ns", status.sync_holdover)
      .add("sync_edges", status.sync_edges)
      .add("sync_rejected_edges", status.sync_rejected_edges)
      .add("sync_output_failures", status.sync_output_failures);
}

void add_bus(JsonObject& object, const client::MasterStatus& status) {
  object.add("link_state", status.link_state)
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
      .add("dropped_frames", status.dropped_frames);
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
      .add("parameter_timeout_ms", status.parameter_timeout)
      .add("transfer_timeout_ms", status.transfer_timeout)
      .add("command_timeout_ms", status.command_timeout)
      .add("transfer_queue", status.transfer_queue)
      .add("telegrams_sent", status.telegrams_sent)
      .add("left_out", status.left_out)
      .add("references_not_released", status.references_not_released)
      .add("rejected_frames", status.rejected_frames)
      .add("unexpected_frames", status.unexpected_frames)
      .add("missed_syncs", status.missed_syncs)
      .add("lost_reports", status.lost_reports)
      .add("serving", status.serving);
  add_sync(object, status);
  add_bus(object, status);
  object.add("second_master", status.second_master).add("second_master_frames", status.second_master_frames);
  add_request_kinds(object, status);
  add_frame_kinds(object, status);
  return object.add("reference_values", names)
      .add("reference_release", release_objects(status))
      .add("read_only", status.read_only)
      .add("secured", status.secured)
      .add("daemon", hexadecimal(status.daemon))
      .add("mapping_number", status.mapping_number);
}

ExitCode status_verb(Session& session) {
  const client::MasterStatus status = session.client().master_status();
  if (session.json()) {
    session.output().object(status_object(status));
    return ExitCode::done;
  }
  for (const std::string& line : status_lines(status)) session.output().line(line);
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
      .add("jobs_ended", slave.jobs_ended)
      .add("profile", slave.profile);
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

std::vector<Table::Column> slave_columns() {
  constexpr auto left = Table::Align::left;
  constexpr auto right = Table::Align::right;
  return {{"SLAVE", right, "its number"},
          {"NAME", left, "its configured name"},
          {"STATE", left,
           "absent (never answered), starting, released; lost, then returning (waits for SYNC), checking "
           "(its return parameters), and held (they are not right; see `events`, then `release`)"},
          {"RESPONDS", left, "whether it answers"},
          {"SYNCHRONIZED", left, "whether it has locked to SYNC: bit 15 of its status word"},
          {"STATUS", left, "its last status word; - = never read since it responds"},
          {"LAST SEEN", right, "interval of its last telegram"},
          {"ANSWERS", right, "answers on the command channel"},
          {"UNANSWERED", right, "commands without an answer"},
          {"MISSED", right, "times it was asked for actual values and sent none"},
          {"SLOW", right, "answers later than tRSPTO"},
          {"LAST us", right, "time from the end of its last command to the end of the answer"},
          {"LONGEST us", right, "the longest such time"},
          {"LOST", right, "times it stopped answering"},
          {"RETURNED", right, "times it answered again"},
          {"JOBS ENDED", right, "jobs that ended because it stopped answering"}};
}

ExitCode slaves_verb(Session& session, const SlavesOptions& options) {
  const std::uint32_t wanted = session.configured_slaves(options.slaves);
  Table table(slave_columns());
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
  status->footer(status_lines_help());
  status->callback([&chosen] { chosen = status_verb; });

  auto* slaves = app.add_subcommand("slaves", "one line for each slave: does it answer, and how fast");
  auto slaves_options = std::make_shared<SlavesOptions>();
  slaves->add_option("SLAVE", slaves_options->slaves,
                     "numbers, names, or lists such as 1,3,5-9 (default: every configured slave)");
  slaves->footer(columns_help(slave_columns()));
  slaves->callback([slaves_options, &chosen] {
    chosen = [slaves_options](Session& session) { return slaves_verb(session, *slaves_options); };
  });
}

}  // namespace cansync::cli
