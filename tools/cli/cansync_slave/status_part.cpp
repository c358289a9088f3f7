#include "cli/cansync_slave/status_part.h"

#include <fmt/format.h>

#include <cstdint>
#include <iterator>
#include <string>
#include <utility>

#include "cansync_slave/client/slave_client.h"
#include "cansync_slave_members.h"
#include "cli/base/finding_list.h"
#include "cli/connect/bus_verb.h"
#include "dds/bounded_text.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

using SideStatus = cansync_slave_SlaveSideStatus;

/// Throws client::NoDaemon.
SideStatus side_status(Session& session) {
  auto client = connect_bus<cansync_slave::client::SlaveClient>(session);
  return expect_told(client.status(session.search_time()), "SlaveSideStatus", client.place());
}

std::string synchronized_text(const SideStatus& status) {
  if (status.synchronized) return "synchronized";
  return status.activated ? "activated, not synchronized" : "not activated by the master";
}

/// "12.3 us".
std::string slave_microseconds(std::int64_t nanoseconds) {
  return fmt::format("{:.1f} us", static_cast<double>(nanoseconds) / 1e3);
}

std::string margin_text(const SideStatus& status) {
  if (status.actual_sent[0] + status.actual_sent[1] == 0) return "no actual value telegram sent yet";
  return "least time left to an actual value telegram " + slave_microseconds(status.actual_margin_least);
}

std::string indicators(const SideStatus& status) {
  std::string text = status.indicator_traffic ? "traffic" : "no traffic";
  if (status.indicator_sync_missing) text += ", SYNC missing";
  text += fmt::format(", {} ms", status.indicator_interval);
  if (status.indicator_fault) text += ", fault";
  return text;
}

std::string fault_text(const SideStatus& status) {
  const std::string_view fault = gateway::dds::text(status.fault);
  if (fault == "none") return "none";
  return fmt::format("{}: {}", fault, gateway::dds::text(status.reaction));
}

std::string parameters_text(const SideStatus& status) {
  std::string text = fmt::format("{} in the daemon's table; ", status.parameters);
  const std::string_view application = gateway::dds::text(status.application);
  if (application.empty()) return text + "no application";
  return text + fmt::format("{}{} taken over by {}; {} answered, {} moved", status.taken_over,
                            status.takes_blocks ? " and blocks" : "", application,
                            text::counted_of(status.jobs_answered, status.jobs, "job"),
                            text::counted_of(status.blocks_done, status.blocks, "block"));
}

/// "active; 12 jobs and 3 blocks went down, 0 were for nobody; lead axis: WRC1 given 900 times, ..."
std::string cluster_text(const SideStatus& status) {
  std::string text =
      fmt::format("{}; {} and {} went down, {} were for nobody in the table; stopped {} with the SYNC above",
                  gateway::dds::text(status.cluster_state), text::counted(status.jobs_below, "job"),
                  text::counted(status.blocks_below, "block"), status.unknown_below,
                  text::counted(status.sync_stops, "time"));
  if (status.repeated_below != 0)
    text += fmt::format("; {} answered from memory, not given below again",
                        text::counted(status.repeated_below, "write"));
  for (unsigned n = 0; n < std::size(status.lead_given); ++n) {
    if (status.lead_given[n] + status.lead_missing[n] + status.lead_refused[n] == 0) continue;
    text += fmt::format("; lead axis: WRC{} given {}, left out {}", n + 1,
                        text::counted(status.lead_given[n], "time"),
                        text::counted(status.lead_missing[n], "time"));
    if (status.lead_refused[n] != 0)
      text += fmt::format(", refused {}", text::counted(status.lead_refused[n], "time"));
  }
  return text;
}

std::vector<Explained> lines_of_slave(Session& session) {
  const SideStatus status = side_status(session);
  std::vector<Explained> lines = {
      {"slave", fmt::format("{}, {}; {}; status word 0x{:04X}", status.slave_number, status.state,
                            synchronized_text(status), status.status_word)},
      {"intervals", fmt::format("{} of {}; {} missing", status.interval,
                                text::duration_text(std::chrono::nanoseconds(status.interval_length)),
                                text::counted(status.missing_edges, "SYNC edge"))},
      {"reference values",
       fmt::format("{} WRC1, {} WRC2; {} without, {} of them now", status.reference_telegrams[0],
                   status.reference_telegrams[1], text::counted(status.missing_references, "interval"),
                   status.missing_in_row)},
      {"actual values", fmt::format("{} RDC1, {} RDC2 sent; {} and {} nothing was released; {} and {} late",
                                    status.actual_sent[0], status.actual_sent[1], status.not_released[0],
                                    text::counted(status.not_released[1], "time"), status.actual_late[0],
                                    status.actual_late[1])},
      {"fault", fault_text(status)},
      {"answers",
       fmt::format("{} sent, {} late, {} not taken by the bus; {}", status.answers_sent, status.answers_late,
                   status.answers_failed, text::counted(status.actions, "action"))},
      {"parameters", parameters_text(status)},
      {"response", fmt::format("last {}, longest {}; {}", slave_microseconds(status.response_last),
                               slave_microseconds(status.response_longest), margin_text(status))},
      {"indicators", indicators(status)},
      {"bus load", fmt::format("{:.1f} %", status.bus_load / 10.0)}};
  if (!gateway::dds::text(status.cluster_state).empty()) lines.push_back({"cluster", cluster_text(status)});
  return lines;
}

void add_slave_members(Session& session, JsonObject& object) {
  text::add_members(object, side_status(session));
}

std::vector<Explained> slave_lines_help() {
  return {
      {"slave", "its number, operating state, whether bit 15 of the status word is set, and that word"},
      {"intervals", "those with a SYNC input, and how many went by without their edge"},
      {"reference values", "telegrams of the master with values, and intervals without any"},
      {"actual values",
       "telegrams sent when asked, left out because nothing was released, and left out late"},
      {"fault", "what the supervision has found, and what the application is to do about it"},
      {"answers", "to parameter commands and transfers; and actions of the master that name this slave"},
      {"parameters",
       "in the table of the configuration, and what an application has taken over and answered since the start"},
      {"response", "from the last bit of a request to its answer being handed over, since the start"},
      {"indicators", "what the four lamps of a module would show"},
      {"bus load", "share of the last second in which the bus was busy"},
      {"cluster", "of a gateway: the bus below, what went down for the master above, and the lead axis"}};
}

/// How near the answers came to the ends of their slots.
std::vector<Finding> slave_findings(Session& session) {
  const SideStatus status = side_status(session);
  const std::uint64_t sent = status.actual_sent[0] + status.actual_sent[1];
  const std::uint64_t late = status.actual_late[0] + status.actual_late[1];
  const std::string found = fmt::format(
      "{}; longest way from request to answer {}; too late and left out: {} actual value telegrams, "
      "{} responses",
      margin_text(status), slave_microseconds(status.response_longest), late, status.answers_late);
  FindingList list;
  if (late + status.answers_late == 0 && (sent == 0 || status.actual_margin_least > 0)) {
    list.ok("answers in time", found);
  } else {
    list.warning(
        "answers in time", found,
        "give the realtime thread a priority and a processor of its own (realtime.priority, realtime.cpu), "
        "have the master send WRC1 earlier (cansyncd as the master: a greater bus.send_margin_us), or lower "
        "the bit rate");
  }
  return std::move(list).take();
}

}  // namespace

const StatusPart kSlaveStatusPart = {"cansync-slave",  lines_of_slave, add_slave_members,
                                     slave_lines_help, nullptr,        slave_findings};

}  // namespace cansync::cli
