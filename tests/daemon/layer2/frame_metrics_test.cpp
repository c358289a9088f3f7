#include "daemon/layer2/gateway/frame_metrics.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "dds/bounded_text.h"
#include "layer2_members.h"
#include "tests/daemon/status/documented_metrics.h"

namespace cansyncd {
namespace {

using gateway::dds::copy_text;

TEST(FrameMetrics, HasTheNumbersOfTheStatus) {
  gateway_GatewayStatus gateway = {};
  gateway_BusStatus bus = {};
  gateway_RealtimeStatus realtime = {};
  layer2_FrameStatus told = {};
  copy_text("can0", gateway.bus);
  told.received = 17;
  told.taken = 19;
  told.lost = 23;
  told.sent = 29;
  told.unanswered = 37;
  told.not_sent = 41;
  told.waiting = 43;
  told.send_waiting = 47;
  told.send_high_waiting = 53;
  told.receive_waiting = 59;
  told.receive_high_waiting = 61;
  told.send_depth = 67;
  told.receive_high_depth = 71;
  told.send_overflows = 73;
  told.receive_overflows = 79;
  told.bus_load = 443;
  told.receive_overflowed = true;
  told.running = true;
  copy_text("passive", told.bus_fault);
  const std::string text = frame_metrics_text({gateway, bus, realtime}, told, 31);
  const auto lines = lines_of(text);
  for (const char* expected : {
           R"(cansync_layer2_frames_received_total{bus="can0"} 17)",
           R"(cansync_layer2_frames_taken_total{bus="can0"} 19)",
           R"(cansync_layer2_frames_lost_total{bus="can0"} 23)",
           R"(cansync_layer2_frames_sent_total{bus="can0"} 29)",
           R"(cansync_layer2_requests_unanswered_total{bus="can0"} 37)",
           R"(cansync_layer2_requests_not_sent_total{bus="can0"} 41)",
           R"(cansync_layer2_requests_waiting{bus="can0"} 43)",
           R"(cansync_layer2_queue_waiting{bus="can0",queue="send"} 47)",
           R"(cansync_layer2_queue_waiting{bus="can0",queue="send_high"} 53)",
           R"(cansync_layer2_queue_waiting{bus="can0",queue="receive"} 59)",
           R"(cansync_layer2_queue_waiting{bus="can0",queue="receive_high"} 61)",
           R"(cansync_layer2_queue_depth{bus="can0",queue="send"} 67)",
           R"(cansync_layer2_queue_depth{bus="can0",queue="receive_high"} 71)",
           R"(cansync_layer2_queue_overflows_total{bus="can0",queue="send"} 73)",
           R"(cansync_layer2_queue_overflows_total{bus="can0",queue="receive"} 79)",
           R"(cansync_layer2_queue_overflowed{bus="can0",queue="send"} 0)",
           R"(cansync_layer2_queue_overflowed{bus="can0",queue="receive"} 1)",
           R"(cansync_layer2_running{bus="can0"} 1)",
           R"(cansync_layer2_bus_fault{bus="can0",state="passive"} 1)",
           R"(cansync_layer2_bus_fault{bus="can0",state="off"} 0)",
           R"(cansync_metrics_write_failures_total{bus="can0"} 31)",
           R"(cansync_bus_load_ratio{bus="can0"} 0.443)",
           "# EOF",
       }) {
    EXPECT_TRUE(lines.contains(expected)) << expected << "\n" << text;
  }
}

TEST(FrameMetrics, EveryCounterOfTheStatusIsThere) {
  const auto sources = sources_of(frame_metric_families());
  for (const text::Member& member : text::members_of<layer2_FrameStatus>) {
    // Both directions of overflows are samples of one family.
    if (member.type != text::MemberType::unsigned_long_long || member.name == "receive_overflows") continue;
    EXPECT_TRUE(sources.contains(fmt::format("FrameStatus.{}", member.name))) << member.name;
  }
}

TEST(FrameMetrics, TheTableOfTheDocumentIsTheCode) {
  EXPECT_EQ(documented_metrics("Of a bus of general frames"), rows_of(frame_metric_families()));
}

}  // namespace
}  // namespace cansyncd
