#include "cli/j1939/status_part.h"

#include <fmt/format.h>

#include "cli/base/finding_list.h"
#include "cli/connect/bus_verb.h"
#include "dds/bounded_text.h"
#include "j1939/client/message_client.h"
#include "j1939/name.h"
#include "j1939_members.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

/// Throws client::NoDaemon.
j1939_NodeStatus node_status(Session& session) {
  auto client = connect_bus<j1939::client::MessageClient>(session);
  return expect_told(client.status(session.search_time()), "NodeStatus", client.place());
}

std::string address_line(const j1939_NodeStatus& status) {
  std::string text = status.address < 0 ? "none" : fmt::format("{}", status.address);
  text += fmt::format(", {}", gateway::dds::text(status.claim_state));
  text += fmt::format("; NAME {:016X}", status.node_name);
  if (status.name_twice) text += ", which another node has, too";
  if (status.addresses_lost != 0)
    text += fmt::format("; lost {}", text::counted(status.addresses_lost, "time"));
  if (status.intruders != 0)
    text += fmt::format("; {} of others with it", text::counted(status.intruders, "message"));
  return text;
}

std::string not_understood(const j1939_NodeStatus& status) {
  const std::uint64_t count = status.declined_length + status.declined_unknown;
  return count == 0 ? "" : fmt::format("; {} not understood", count);
}

std::vector<Explained> lines_of_node(Session& session) {
  const j1939_NodeStatus status = node_status(session);
  return {
      {"address", address_line(status)},
      {"messages received",
       fmt::format("{} for the daemon or all, {} taken by a range, {} of them not published{}",
                   status.messages, status.taken, status.lost, not_understood(status))},
      {"in packets", fmt::format("{} whole, {} broken, {} refused, {} under way", status.packets_completed,
                                 status.packets_broken, status.packets_refused, status.transports)},
      {"messages sent",
       fmt::format("{}; {} not answered, {} not sent, {} waiting", text::counted(status.sent, "frame"),
                   text::counted(status.unanswered, "request"), status.not_sent, status.waiting)},
      {"load of the bus", fmt::format("{:.1f} %", status.bus_load / 10.0)}};
}

void add_node_members(Session& session, JsonObject& object) {
  text::add_members(object, node_status(session));
}

std::vector<Explained> node_lines_help() {
  return {{"address", "the daemon's own, how far its claim has come, its NAME"},
          {"messages received", "whole messages of other nodes, since the start"},
          {"in packets",
           "messages of more than eight bytes of other nodes, since the start; and what is under way now"},
          {"messages sent", "own frames and what became of requests, since the start; and how many wait now"},
          {"load of the bus", "share of the last second in which it was busy"}};
}

/// Which node wins when another one claims the address.
std::string strength_text(j1939::Name name) {
  if (name == j1939::kWeakestName) return "every other NAME wins against it";
  return name == 0 ? "it wins against every other NAME" : "a lower NAME wins against it";
}

std::vector<Finding> node_findings(Session& session) {
  const j1939_NodeStatus status = node_status(session);
  const std::string claim(gateway::dds::text(status.claim_state));
  const std::string name = fmt::format("NAME {:016X}", status.node_name);
  FindingList out;
  if (status.name_twice) {
    out.error("address", fmt::format("another node has the daemon's {}", name),
              "give the daemon another name.identity, and start it again");
  } else if (claim == "cannot-claim") {
    out.error("address", fmt::format("none: another node has address.preferred; {}", name),
              "set another address.preferred, or address.arbitrary = true");
  } else if (claim == "claimed") {
    out.ok("address", fmt::format("{}; {}: {}", status.address, name, strength_text(status.node_name)));
  } else if (claim == "listening") {
    out.ok("address", "none: the daemon listens alone");
  } else {
    out.warning(
        "address", fmt::format("{}: nothing is sent until it is claimed", claim),
        "call cansync doctor again after a second; a node that is alone on its bus claims none: connect another");
  }
  if (status.intruders != 0)
    out.warning("intruders",
                fmt::format("{} of other nodes had the daemon's address as their source",
                            text::counted(status.intruders, "message")),
                "give the other node an address of its own, or the daemon another address.preferred");
  if (status.answers_lost != 0)
    out.warning("answers",
                fmt::format("{} to other nodes had no room", text::counted(status.answers_lost, "answer")),
                "look at the load of the bus: cansync status");
  if (status.groups_left_out != 0)
    out.warning(
        "groups",
        fmt::format("a group of [[provide]] was left out {}", text::counted(status.groups_left_out, "time")),
        "make provide.period_ms longer, or let programs send fewer long messages");
  return std::move(out).take();
}

}  // namespace

const StatusPart kJ1939StatusPart = {"j1939",       lines_of_node, add_node_members, node_lines_help, nullptr,
                                     node_findings, false};

}  // namespace cansync::cli
