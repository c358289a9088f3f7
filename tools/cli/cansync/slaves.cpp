#include <fmt/format.h>

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cli/base/status_refusal.h"
#include "cli/base/verb_groups.h"
#include "cli/cansync/fault_words.h"
#include "cli/cansync/status_lines.h"
#include "cli/cansync/verbs.h"
#include "cli/text/column_help.h"

namespace cansync::cli {
namespace {

struct SlavesOptions {
  std::vector<std::string> slaves;
};

/// `asked`: SYNC is there; without it nothing is known of what the slave does now.
JsonObject slave_object(const client::SlaveStatus& slave, const std::string& fault, bool asked) {
  JsonObject object;
  object.add("slave", slave.slave).add("name", slave.name);
  if (asked)
    object.add("responds", slave.responds).add("synchronized", slave.synchronized);
  else
    object.add_null("responds").add_null("synchronized");
  if (slave.status_known)
    object.add("status_word", slave.status_word);
  else
    object.add_null("status_word");
  object.add("last_seen_interval", slave.last_seen)
      .add("answers", slave.answers)
      .add("unanswered", slave.unanswered)
      .add("missed_actual", slave.missed_actual)
      .add("slow_answers", slave.slow_answers)
      .add("last_response_ns", slave.last_response)
      .add("longest_response_ns", slave.longest_response);
  if (asked)
    object.add("state", slave.state);
  else
    object.add_null("state");
  return object.add("times_lost", slave.times_lost)
      .add("times_returned", slave.times_returned)
      .add("jobs_ended", slave.jobs_ended)
      .add("profile", slave.profile)
      .add("status_parameter", slave.status_parameter)
      .add("status_error", slave.status_error)
      .add("fault", fault)
      .add("held_reason", slave.held_reason);
}

std::string status_text(const client::SlaveStatus& slave, const std::string& fault) {
  if (slave.status_error != 0) return fmt::format("error 0x{:04X}", slave.status_error);
  if (!slave.status_known) return "-";
  return fmt::format("0x{:04X}{}{}", slave.status_word, fault.empty() ? "" : " ", fault);
}

const char* yes_or_no(bool yes) {
  return yes ? "yes" : "no";
}

void add_slave_row(Table& table, const client::SlaveStatus& slave, const std::string& fault, bool asked) {
  const auto microseconds = [](std::int64_t time) {
    return fmt::format("{:.1f}", static_cast<double>(time) / 1e3);
  };
  table.add({fmt::format("{}", slave.slave), slave.name, asked ? slave.state : "-",
             asked ? yes_or_no(slave.responds) : "-", asked ? yes_or_no(slave.synchronized) : "-",
             status_text(slave, fault), fmt::format("{}", slave.last_seen), fmt::format("{}", slave.answers),
             fmt::format("{}", slave.unanswered), fmt::format("{}", slave.missed_actual),
             fmt::format("{}", slave.slow_answers), microseconds(slave.last_response),
             microseconds(slave.longest_response), fmt::format("{}", slave.times_lost),
             fmt::format("{}", slave.times_returned), fmt::format("{}", slave.jobs_ended)});
}

std::vector<Table::Column> slave_columns() {
  constexpr auto left = Table::Align::left;
  constexpr auto right = Table::Align::right;
  return {
      {"SLAVE", right, "its number"},
      {"NAME", left, "its configured name"},
      {"STATE", left,
       "absent (never answered), starting, released; lost, then returning (waits for SYNC), checking "
       "(its return parameters), and held (the reason is below the table; see `release`); - = the line is "
       "stopped"},
      {"RESPONDS", left, "whether it answers", 0, 1},
      {"SYNCHRONIZED", left, "whether it has locked to SYNC: bit 15 of its status word", 0, 1},
      {"STATUS", left,
       "its last status word, and the faults in it by the slave's profile; - = never read since it responds; "
       "error = it refuses to give it"},
      {"LAST SEEN", right, "interval of its last telegram", 0, 6},
      {"ANSWERS", right, "answers on the command channel", 0, 5},
      {"UNANSWERED", right, "commands without an answer", 0, 2, true},
      {"MISSED", right, "times it was asked for actual values and sent none", 0, 2, true},
      {"SLOW", right, "answers later than tRSPTO", 0, 2, true},
      {"LAST us", right, "time from the end of its last command to the end of the answer", 0, 4},
      {"LONGEST us", right, "the longest such time", 0, 3},
      {"LOST", right, "times it stopped answering", 0, 2, true},
      {"RETURNED", right, "times it answered again", 0, 3, true},
      {"JOBS ENDED", right, "jobs that ended because it stopped answering", 0, 3, true}};
}

ExitCode slaves_verb(Session& session, const SlavesOptions& options) {
  session.look_only();
  const std::uint32_t wanted = session.configured_slaves(options.slaves);
  const client::MasterStatus master = session.client().master_status();
  const bool asked = asks_slaves(master);
  Table table(slave_columns());
  std::vector<std::string> refusals;
  if (!asked)
    refusals.push_back(
        fmt::format("the line is in {}: no slave is asked, and what stands here is of before; "
                    "`cansync mode setup`, then `cansync mode run`",
                    client::text(master.state)));
  std::vector<Style> styles;  // slaves in fault are red where there are colours
  std::uint32_t untold = wanted;
  FaultWords faults(session);
  for (const client::SlaveStatus& slave : session.client().slaves()) {
    if (((wanted >> slave.slave) & 1u) == 0) continue;
    untold &= ~(1u << slave.slave);
    if (lacks_status_word(slave))
      refusals.push_back(status_refusal(slave) + "; fix: " + kStatusRefusalRemedy);
    if (const std::string_view held = slave.held_reason; asked && !held.empty())
      refusals.push_back(
          fmt::format("slave {} '{}' is held out: {}", slave.slave, client::text(slave.name), held));
    const std::string fault = faults.of(slave);
    if (session.json()) {
      session.output().object(slave_object(slave, fault, asked));
      continue;
    }
    styles.push_back(!fault.empty() || lacks_status_word(slave) ? Style::bad : Style::plain);
    add_slave_row(table, slave, fault, asked);
  }
  if (untold != 0) refusals.push_back("not told by the daemon yet: slaves " + format_slave_set(untold));
  if (!session.json()) session.output().table(table, styles);
  for (const std::string& refused : refusals) session.output().remark(refused);
  return ExitCode::done;
}

}  // namespace

void add_slaves_verb(CLI::App& app, Verb& chosen) {
  auto* slaves = app.add_subcommand("slaves", "one line for each slave: does it answer, and how fast");
  slaves->group(kLookingVerbs);
  auto slaves_options = std::make_shared<SlavesOptions>();
  slaves->add_option("SLAVE", slaves_options->slaves,
                     "numbers, names, or lists such as 1,3,5-9 (default: every configured slave)");
  slaves->footer(columns_help(slave_columns()));
  slaves->callback([slaves_options, &chosen] {
    chosen = [slaves_options](Session& session) { return slaves_verb(session, *slaves_options); };
  });
}

}  // namespace cansync::cli
