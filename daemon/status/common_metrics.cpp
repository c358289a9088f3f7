#include "daemon/status/common_metrics.h"

#include <array>
#include <string_view>
#include <utility>

#include "can/bus_names.h"
#include "dds/bounded_text.h"
#include "gateway_members.h"
#include "sync/phase_lock.h"

namespace cansyncd {
namespace {

using gateway::dds::text;

constexpr std::string_view kGatewayTopic = "GatewayStatus";
constexpr std::string_view kBusTopic = "BusStatus";
constexpr std::string_view kRealtimeTopic = "RealtimeStatus";

const gateway_GatewayStatus& gateway_of(const MetricsSource& from) {
  return sample_of<gateway_GatewayStatus>(kGatewayTopic, from);
}
const gateway_BusStatus& bus_of(const MetricsSource& from) {
  return sample_of<gateway_BusStatus>(kBusTopic, from);
}
const gateway_RealtimeStatus& realtime_of(const MetricsSource& from) {
  return sample_of<gateway_RealtimeStatus>(kRealtimeTopic, from);
}

void info(const MetricsSource& from, MetricSamples& to) {
  const gateway_GatewayStatus& gateway = gateway_of(from);
  const gateway_BusStatus& bus = bus_of(from);
  to.add(label("version", text(gateway.version)) + "," + label("interface", text(bus.bus_interface)) + "," +
             label("dds_interface", text(gateway.dds_interface)) + "," +
             label("timestamp_source", text(bus.timestamp_source)),
         std::uint64_t{1});
}

void controller_state(const MetricsSource& from, MetricSamples& to) {
  using can::ControllerState;
  add_states(to, "",
             std::array{name(ControllerState::error_active), name(ControllerState::error_warning),
                        name(ControllerState::error_passive), name(ControllerState::bus_off),
                        name(ControllerState::stopped)},
             text(bus_of(from).controller_state));
}

void state_of_link(const MetricsSource& from, MetricSamples& to) {
  using can::LinkState;
  add_states(to, "",
             std::array{name(LinkState::up), name(LinkState::down), name(LinkState::missing),
                        name(LinkState::wrong_adapter), name(LinkState::wrong_bit_rate),
                        name(LinkState::not_one_shot), name(LinkState::listen_only),
                        name(can::Delivery::unacknowledged), name(can::Delivery::not_emptied)},
             text(bus_of(from).link_state));
}

void sync_state(const MetricsSource& from, MetricSamples& to) {
  using sync_line::LockState;
  add_states(to, "",
             std::array{std::string_view(sync_line::name(LockState::searching)),
                        std::string_view(sync_line::name(LockState::locked)),
                        std::string_view(sync_line::name(LockState::holdover)),
                        std::string_view(sync_line::name(LockState::lost))},
             text(realtime_of(from).sync_state));
}

void configuration_differs(const MetricsSource& from, MetricSamples& to) {
  to.add({}, std::uint64_t{!text(gateway_of(from).configuration_reason).empty()});
}

void restart_pending(const MetricsSource& from, MetricSamples& to) {
  to.add({}, std::uint64_t{text(gateway_of(from).restart_reason).empty() ? 0u : 1u});
}

void network_missing(const MetricsSource& from, MetricSamples& to) {
  to.add({}, std::uint64_t{!text(gateway_of(from).network_reason).empty()});
}

void write_failures(const MetricsSource& from, MetricSamples& to) {
  to.add({}, from.write_failures);
}

constexpr MetricFamily kCommonFamilies[] = {
    {"cansync_info", MetricType::gauge, "version, interface, dds_interface, timestamp_source",
     "GatewayStatus.version", "Always 1; the labels tell what runs.", info},
    {"cansync_bit_rate_bits_per_second", MetricType::gauge, "", "BusStatus.bit_rate",
     "Bit rate of the bus as configured."},
    {"cansync_reports_lost", MetricType::counter, "", "RealtimeStatus.lost_reports",
     "Reports of the realtime thread for which there was no room."},
    {"cansync_controller_state", MetricType::gauge, "state", "BusStatus.controller_state",
     "1 for the state of the CAN controller, 0 for the others.", controller_state},
    {"cansync_controller_transmit_errors", MetricType::gauge, "", "BusStatus.transmit_errors",
     "Error counter of the CAN controller for sending; it falls again."},
    {"cansync_controller_receive_errors", MetricType::gauge, "", "BusStatus.receive_errors",
     "Error counter of the CAN controller for receiving; it falls again."},
    {"cansync_link_state", MetricType::gauge, "state", "BusStatus.link_state",
     "1 for the state of the CAN interface, 0 for the others.", state_of_link},
    {"cansync_error_frames", MetricType::counter, "", "BusStatus.error_frames", "Error frames on the bus."},
    {"cansync_acknowledge_errors", MetricType::counter, "", "BusStatus.acknowledge_errors",
     "Telegrams that nobody acknowledged."},
    {"cansync_bus_off_restarts", MetricType::counter, "", "BusStatus.restarts",
     "Times the controller left bus-off."},
    {"cansync_send_queue_full", MetricType::counter, "", "BusStatus.queue_full",
     "Times the send queue had no room: a CANsync telegram is left out then, other frames are tried again."},
    {"cansync_controller_overruns", MetricType::counter, "", "BusStatus.overruns",
     "Frames the controller had no room for."},
    {"cansync_frames_dropped", MetricType::counter, "", "BusStatus.dropped_frames",
     "Received frames lost before they were taken."},
    {"cansync_realtime_priority", MetricType::gauge, "", "RealtimeStatus.realtime_priority",
     "SCHED_FIFO priority granted; 0 is normal scheduling."},
    {"cansync_realtime_priority_wanted", MetricType::gauge, "", "RealtimeStatus.realtime_priority_wanted",
     "SCHED_FIFO priority as configured."},
    {"cansync_memory_locked", MetricType::gauge, "", "RealtimeStatus.memory_locked",
     "1 when all memory is locked, else 0."},
    {"cansync_sync_state", MetricType::gauge, "state", "RealtimeStatus.sync_state",
     "1 for the state of the timeline towards its SYNC source, 0 for the others; all 0 when it follows "
     "nothing.",
     sync_state},
    {"cansync_sync_phase_error_seconds", MetricType::gauge, "", "RealtimeStatus.sync_phase_error",
     "SYNC input after timeline, filtered."},
    {"cansync_sync_holdover_seconds", MetricType::gauge, "", "RealtimeStatus.sync_holdover",
     "For how long the edges of the SYNC input have been missing."},
    {"cansync_sync_edges", MetricType::counter, "", "RealtimeStatus.sync_edges",
     "Edges of the SYNC input that were used."},
    {"cansync_sync_rejected_edges", MetricType::counter, "", "RealtimeStatus.sync_rejected_edges",
     "Edges of the SYNC input that were not used."},
    {"cansync_sync_output_failures", MetricType::counter, "", "RealtimeStatus.sync_output_failures",
     "SYNC edges that could not be made."},
    {"cansync_clients", MetricType::gauge, "", "GatewayStatus.clients",
     "Programs with requests that the daemon knows."},
    {"cansync_requests_rejected", MetricType::counter, "reason", "GatewayStatus.rejected_values...",
     "Requests and samples of clients that were not taken, by reason."},
    {"cansync_read_only", MetricType::gauge, "", "GatewayStatus.read_only",
     "1 when changes are refused, else 0."},
    {"cansync_secured", MetricType::gauge, "", "GatewayStatus.secured", "1 when DDS Security is on, else 0."},
    {"cansync_identity_time_left_seconds", MetricType::gauge, "", "GatewayStatus.identity_time_left",
     "Time until the identity of DDS Security ends; 0 when it has ended, or DDS Security is off."},
    {"cansync_configuration_differs", MetricType::gauge, "", "GatewayStatus.configuration_reason",
     "1 when another configuration than the file on disk is in force, else 0.", configuration_differs},
    {"cansync_network_missing", MetricType::gauge, "", "GatewayStatus.network_reason",
     "1 when DDS is on lo and not on the interface of the configuration, else 0.", network_missing},
    {"cansync_restart_pending", MetricType::gauge, "", "GatewayStatus.restart_reason",
     "1 when the program or a library on disk was replaced since the start of the daemon, else 0.",
     restart_pending},
    {"cansync_metrics_write_failures", MetricType::counter, "", "(no topic)",
     "Times this file could not be written.", write_failures},
};

}  // namespace

MetricFamilies common_metric_families() noexcept {
  return kCommonFamilies;
}

MetricsSource common_metrics(const ToldCommon& common, std::uint64_t write_failures) {
  MetricsSource source;
  source.bus = common.gateway.bus;
  source.topics = {metric_topic(kGatewayTopic, common.gateway), metric_topic(kBusTopic, common.bus),
                   metric_topic(kRealtimeTopic, common.realtime)};
  source.write_failures = write_failures;
  return source;
}

std::string metrics_text(const ToldCommon& common, std::uint64_t write_failures, MetricTopic own,
                         MetricFamilies families) {
  MetricsSource source = common_metrics(common, write_failures);
  source.topics.push_back(std::move(own));
  return metrics_text(source, {common_metric_families(), families});
}

}  // namespace cansyncd
