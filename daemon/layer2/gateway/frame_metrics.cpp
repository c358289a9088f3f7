#include "daemon/layer2/gateway/frame_metrics.h"

#include <array>
#include <string_view>

#include "daemon/status/common_metrics.h"
#include "dds/bounded_text.h"
#include "layer2/status_image.h"
#include "layer2_members.h"

namespace cansyncd {
namespace {

constexpr std::string_view kFrameTopic = "FrameStatus";

const layer2_FrameStatus& told_of(const MetricsSource& from) {
  return sample_of<layer2_FrameStatus>(kFrameTopic, from);
}

void add_queue(MetricSamples& to, std::string_view queue, std::uint64_t value) {
  to.add(label("queue", queue), value);
}

void queue_waiting(const MetricsSource& from, MetricSamples& to) {
  const layer2_FrameStatus& told = told_of(from);
  add_queue(to, "send", told.send_waiting);
  add_queue(to, "send_high", told.send_high_waiting);
  add_queue(to, "receive", told.receive_waiting);
  add_queue(to, "receive_high", told.receive_high_waiting);
}

void queue_depth(const MetricsSource& from, MetricSamples& to) {
  const layer2_FrameStatus& told = told_of(from);
  add_queue(to, "send", told.send_depth);
  add_queue(to, "send_high", told.send_high_depth);
  add_queue(to, "receive", told.receive_depth);
  add_queue(to, "receive_high", told.receive_high_depth);
}

void queue_overflows(const MetricsSource& from, MetricSamples& to) {
  const layer2_FrameStatus& told = told_of(from);
  add_queue(to, "send", told.send_overflows);
  add_queue(to, "receive", told.receive_overflows);
}

void queue_overflowed(const MetricsSource& from, MetricSamples& to) {
  const layer2_FrameStatus& told = told_of(from);
  add_queue(to, "send", std::uint64_t{told.send_overflowed});
  add_queue(to, "receive", std::uint64_t{told.receive_overflowed});
}

void bus_fault(const MetricsSource& from, MetricSamples& to) {
  using layer2::BusFault;
  add_states(to, "",
             std::array{layer2::name_of(BusFault::off), layer2::name_of(BusFault::bus_off),
                        layer2::name_of(BusFault::stopped), layer2::name_of(BusFault::passive),
                        layer2::name_of(BusFault::errors), layer2::name_of(BusFault::overflow)},
             gateway::dds::text(told_of(from).bus_fault));
}

constexpr MetricFamily kFrameFamilies[] = {
    {"cansync_bus_load_ratio", MetricType::gauge, "", "FrameStatus.bus_load",
     "Share of the last second in which the bus was busy, by the frames that came."},
    {"cansync_layer2_frames_received", MetricType::counter, "", "FrameStatus.received",
     "Frames of others, taken by a range or not."},
    {"cansync_layer2_frames_taken", MetricType::counter, "", "FrameStatus.taken",
     "Of those: taken by a range."},
    {"cansync_layer2_frames_taken_by_objects", MetricType::counter, "", "FrameStatus.taken_by_objects",
     "Frames of others that message objects took."},
    {"cansync_layer2_frames_taken_by_mapping", MetricType::counter, "", "FrameStatus.taken_by_mapping",
     "Frames of others that the process image took."},
    {"cansync_layer2_frames_dropped_by_mapping", MetricType::counter, "", "FrameStatus.dropped_by_mapping",
     "Frames of others that the mapping takes and nothing is mapped for."},
    {"cansync_layer2_frames_lost", MetricType::counter, "", "FrameStatus.lost",
     "Of those: not published, so that no client has them."},
    {"cansync_layer2_frames_sent", MetricType::counter, "", "FrameStatus.sent",
     "Own frames that were on the bus."},
    {"cansync_layer2_requests_unanswered", MetricType::counter, "", "FrameStatus.unanswered",
     "Requests for a frame that no node answered."},
    {"cansync_layer2_requests_not_sent", MetricType::counter, "", "FrameStatus.not_sent",
     "Requests that were taken and ended without their frame being sent."},
    {"cansync_layer2_requests_waiting", MetricType::gauge, "", "FrameStatus.waiting",
     "Requests that wait to be sent, of every priority."},
    {"cansync_layer2_queue_waiting", MetricType::gauge, "queue", "FrameStatus.send_waiting",
     "Frames in the queue: send, send_high, receive, receive_high.", queue_waiting},
    {"cansync_layer2_queue_depth", MetricType::gauge, "queue", "FrameStatus.send_depth",
     "Room of that queue.", queue_depth},
    {"cansync_layer2_queue_overflows", MetricType::counter, "queue", "FrameStatus.send_overflows",
     "Frames deleted or refused by full queues of both priorities: send, receive.", queue_overflows},
    {"cansync_layer2_queue_overflowed", MetricType::gauge, "queue", "FrameStatus.send_overflowed",
     "1 when one of them overflowed since the last reset, else 0.", queue_overflowed},
    {"cansync_layer2_running", MetricType::gauge, "", "FrameStatus.running", "1 in run, 0 in stop."},
    {"cansync_layer2_script_running", MetricType::gauge, "", "FrameStatus.script_running",
     "1 while a script is under way, else 0."},
    {"cansync_layer2_window_running", MetricType::gauge, "", "FrameStatus.window_running",
     "1 while requests are sent in the synchronous window alone, else 0."},
    {"cansync_layer2_status_word", MetricType::gauge, "", "FrameStatus.status_word",
     "STAT of a CAN 300 PRO."},
    {"cansync_layer2_bus_fault", MetricType::gauge, "state", "FrameStatus.bus_fault",
     "1 for why the LED BF would be lit, or off, 0 for the others.", bus_fault},
};

}  // namespace

MetricFamilies frame_metric_families() noexcept {
  return kFrameFamilies;
}

std::string frame_metrics_text(const ToldCommon& common, const layer2_FrameStatus& told,
                               std::uint64_t write_failures) {
  return metrics_text(common, write_failures, metric_topic(kFrameTopic, told), kFrameFamilies);
}

}  // namespace cansyncd
