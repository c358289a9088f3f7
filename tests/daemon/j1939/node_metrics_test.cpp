#include "daemon/j1939/gateway/node_metrics.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "dds/bounded_text.h"
#include "j1939_members.h"
#include "tests/daemon/status/documented_metrics.h"

namespace cansyncd {
namespace {

using gateway::dds::copy_text;

TEST(NodeMetrics, HasTheNumbersOfTheStatus) {
  gateway_GatewayStatus gateway = {};
  gateway_BusStatus bus = {};
  gateway_RealtimeStatus realtime = {};
  j1939_NodeStatus told = {};
  copy_text("can0", gateway.bus);
  told.addresses_lost = 11;
  told.intruders = 13;
  told.received = 17;
  told.foreign = 19;
  told.messages = 23;
  told.taken = 29;
  told.lost = 37;
  told.packets_completed = 41;
  told.packets_broken = 43;
  told.packets_refused = 47;
  told.transports = 53;
  told.sent = 59;
  told.unanswered = 61;
  told.not_sent = 67;
  told.answers_lost = 71;
  told.waiting = 73;
  told.declined_length = 79;
  told.declined_unknown = 83;
  told.declined_impossible = 89;
  told.declined_busy = 97;
  told.declined_no_room = 101;
  told.bus_load = 443;
  told.address = -1;
  told.name_twice = true;
  copy_text("cannot-claim", told.claim_state);
  const std::string text = node_metrics_text({gateway, bus, realtime}, told, 31);
  const auto lines = lines_of(text);
  for (const char* expected : {
           R"(cansync_j1939_addresses_lost_total{bus="can0"} 11)",
           R"(cansync_j1939_intruders_total{bus="can0"} 13)",
           R"(cansync_j1939_frames_received_total{bus="can0"} 17)",
           R"(cansync_j1939_frames_foreign_total{bus="can0"} 19)",
           R"(cansync_j1939_messages_received_total{bus="can0"} 23)",
           R"(cansync_j1939_messages_taken_total{bus="can0"} 29)",
           R"(cansync_j1939_messages_lost_total{bus="can0"} 37)",
           R"(cansync_j1939_packets_completed_total{bus="can0"} 41)",
           R"(cansync_j1939_packets_broken_total{bus="can0"} 43)",
           R"(cansync_j1939_packets_refused_total{bus="can0"} 47)",
           R"(cansync_j1939_transports{bus="can0"} 53)",
           R"(cansync_j1939_frames_sent_total{bus="can0"} 59)",
           R"(cansync_j1939_requests_unanswered_total{bus="can0"} 61)",
           R"(cansync_j1939_requests_not_sent_total{bus="can0"} 67)",
           R"(cansync_j1939_answers_lost_total{bus="can0"} 71)",
           R"(cansync_j1939_requests_waiting{bus="can0"} 73)",
           R"(cansync_j1939_declined_total{bus="can0",kind="length"} 79)",
           R"(cansync_j1939_declined_total{bus="can0",kind="unknown"} 83)",
           R"(cansync_j1939_declined_total{bus="can0",kind="impossible"} 89)",
           R"(cansync_j1939_declined_total{bus="can0",kind="busy"} 97)",
           R"(cansync_j1939_declined_total{bus="can0",kind="no_room"} 101)",
           R"(cansync_j1939_address{bus="can0"} -1)",
           R"(cansync_j1939_name_twice{bus="can0"} 1)",
           R"(cansync_j1939_claim_state{bus="can0",state="cannot-claim"} 1)",
           R"(cansync_j1939_claim_state{bus="can0",state="claimed"} 0)",
           R"(cansync_metrics_write_failures_total{bus="can0"} 31)",
           R"(cansync_bus_load_ratio{bus="can0"} 0.443)",
           "# EOF",
       }) {
    EXPECT_TRUE(lines.contains(expected)) << expected << "\n" << text;
  }
}

TEST(NodeMetrics, EveryCounterOfTheStatusIsThere) {
  const auto sources = sources_of(node_metric_families());
  for (const text::Member& member : text::members_of<j1939_NodeStatus>) {
    if (member.type != text::MemberType::unsigned_long_long || member.name == "node_name") continue;
    if (member.name.starts_with("declined_") && member.name != "declined_length")
      continue;  // of the same family
    const auto more = member.name == "declined_length" ? "..." : "";
    EXPECT_TRUE(sources.contains(fmt::format("NodeStatus.{}{}", member.name, more))) << member.name;
  }
}

TEST(NodeMetrics, TheTableOfTheDocumentIsTheCode) {
  EXPECT_EQ(documented_metrics("Of a node of J1939"), rows_of(node_metric_families()));
}

}  // namespace
}  // namespace cansyncd
