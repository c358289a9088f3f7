#include "daemon/j1939/gateway/node_metrics.h"

#include <array>
#include <string_view>

#include "daemon/status/common_metrics.h"
#include "dds/bounded_text.h"
#include "j1939/dds/texts.h"
#include "j1939_members.h"

namespace cansyncd {
namespace {

constexpr std::string_view kNodeTopic = "NodeStatus";

void claim_state(const MetricsSource& from, MetricSamples& to) {
  using j1939::ClaimState;
  using j1939::dds::name_of;
  add_states(to, "",
             std::array{name_of(ClaimState::listening), name_of(ClaimState::claiming),
                        name_of(ClaimState::claimed), name_of(ClaimState::cannot_claim)},
             gateway::dds::text(sample_of<j1939_NodeStatus>(kNodeTopic, from).claim_state));
}

constexpr MetricFamily kNodeFamilies[] = {
    {"cansync_bus_load_ratio", MetricType::gauge, "", "NodeStatus.bus_load",
     "Share of the last second in which the bus was busy, by the frames that came."},
    {"cansync_j1939_claim_state", MetricType::gauge, "state", "NodeStatus.claim_state",
     "1 for how far the claim of an address is, 0 for the others.", claim_state},
    {"cansync_j1939_address", MetricType::gauge, "", "NodeStatus.address",
     "Address that is claimed, or being claimed; -1: none."},
    {"cansync_j1939_name_twice", MetricType::gauge, "", "NodeStatus.name_twice",
     "1 when another node has the same NAME, else 0."},
    {"cansync_j1939_addresses_lost", MetricType::counter, "", "NodeStatus.addresses_lost",
     "Times a stronger NAME took the address."},
    {"cansync_j1939_intruders", MetricType::counter, "", "NodeStatus.intruders",
     "Messages of others that had the daemon's address as their source."},
    {"cansync_j1939_frames_received", MetricType::counter, "", "NodeStatus.received",
     "Frames of others, of 29 bits with data."},
    {"cansync_j1939_frames_foreign", MetricType::counter, "", "NodeStatus.foreign",
     "Frames of others of any other kind, which are not looked at."},
    {"cansync_j1939_frames_sent", MetricType::counter, "", "NodeStatus.sent",
     "Own frames that were on the bus."},
    {"cansync_j1939_messages_received", MetricType::counter, "", "NodeStatus.messages",
     "Whole messages for this node or for all."},
    {"cansync_j1939_messages_taken", MetricType::counter, "", "NodeStatus.taken",
     "Of those: taken by a range."},
    {"cansync_j1939_messages_lost", MetricType::counter, "", "NodeStatus.lost",
     "Of those: not published, so that no client has them."},
    {"cansync_j1939_packets_completed", MetricType::counter, "", "NodeStatus.packets_completed",
     "Messages put together out of packets."},
    {"cansync_j1939_packets_broken", MetricType::counter, "", "NodeStatus.packets_broken",
     "Messages in packets that were begun and did not come whole."},
    {"cansync_j1939_packets_refused", MetricType::counter, "", "NodeStatus.packets_refused",
     "Messages in packets that were announced and not begun."},
    {"cansync_j1939_declined", MetricType::counter, "kind", "NodeStatus.declined_length...",
     "What other nodes sent and is not taken, by kind."},
    {"cansync_j1939_transports", MetricType::gauge, "", "NodeStatus.transports",
     "Messages in packets under way, in both directions."},
    {"cansync_j1939_requests_unanswered", MetricType::counter, "", "NodeStatus.unanswered",
     "Requests that were refused, broken off or not answered by other nodes."},
    {"cansync_j1939_requests_not_sent", MetricType::counter, "", "NodeStatus.not_sent",
     "Requests that were taken and ended without being sent."},
    {"cansync_j1939_requests_waiting", MetricType::gauge, "", "NodeStatus.waiting",
     "Requests that wait to be sent."},
    {"cansync_j1939_answers_lost", MetricType::counter, "", "NodeStatus.answers_lost",
     "Answers to other nodes for which there was no room."},
    {"cansync_j1939_groups_left_out", MetricType::counter, "", "NodeStatus.groups_left_out",
     "Times that a group of provide.period_ms was due and had no room."},
};

}  // namespace

MetricFamilies node_metric_families() noexcept {
  return kNodeFamilies;
}

std::string node_metrics_text(const ToldCommon& common, const j1939_NodeStatus& told,
                              std::uint64_t write_failures) {
  return metrics_text(common, write_failures, metric_topic(kNodeTopic, told), kNodeFamilies);
}

}  // namespace cansyncd
