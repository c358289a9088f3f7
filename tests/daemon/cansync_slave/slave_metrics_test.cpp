#include "daemon/cansync_slave/gateway/slave_metrics.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "cansync_slave_members.h"
#include "dds/bounded_text.h"
#include "tests/daemon/status/documented_metrics.h"

namespace cansyncd {
namespace {

using gateway::dds::copy_text;

/// A sample with a number of its own wherever one is looked for.
std::string text_of_slave() {
  gateway_GatewayStatus gateway = {};
  gateway_BusStatus bus = {};
  gateway_RealtimeStatus realtime = {};
  cansync_slave_SlaveSideStatus told = {};
  copy_text("can0", gateway.bus);
  copy_text("run", told.state);
  copy_text("sync_lost", told.fault);
  told.slave_number = 5;
  told.synchronized = true;
  told.status_word = 0x8000;
  told.bus_load = 443;
  told.reference_telegrams[1] = 17;
  told.asked[0] = 19;
  told.actual_late[1] = 23;
  told.response_longest = 123'456;
  told.jobs_dropped = 29;
  return slave_metrics_text({gateway, bus, realtime}, told, 31);
}

TEST(SlaveMetrics, HasTheNumbersOfTheStatusInBaseUnits) {
  const std::string text = text_of_slave();
  const std::set<std::string> lines = lines_of(text);
  for (const char* expected : {
           R"(cansync_slave_side_state{bus="can0",state="run"} 1)",
           R"(cansync_slave_side_state{bus="can0",state="start-up"} 0)",
           R"(cansync_slave_side_fault{bus="can0",state="sync_lost"} 1)",
           R"(cansync_slave_side_fault{bus="can0",state="none"} 0)",
           R"(cansync_slave_side_number{bus="can0"} 5)",
           R"(cansync_slave_side_synchronized{bus="can0"} 1)",
           R"(cansync_slave_side_status_word{bus="can0"} 32768)",
           R"(cansync_bus_load_ratio{bus="can0"} 0.443)",
           R"(cansync_slave_side_reference_telegrams_total{bus="can0",telegram="2"} 17)",
           R"(cansync_slave_side_actual_asked_total{bus="can0",telegram="1"} 19)",
           R"(cansync_slave_side_actual_late_total{bus="can0",telegram="2"} 23)",
           R"(cansync_slave_side_response_longest_seconds{bus="can0"} 0.000123456)",
           R"(cansync_slave_side_jobs_dropped_total{bus="can0"} 29)",
           R"(cansync_metrics_write_failures_total{bus="can0"} 31)",
           "# UNIT cansync_slave_side_response_longest_seconds seconds",
           "# EOF",
       }) {
    EXPECT_TRUE(lines.count(expected)) << expected << "\n" << text;
  }
}

TEST(SlaveMetrics, EveryCounterOfTheStatusIsThere) {
  const auto sources = sources_of(slave_metric_families());
  for (const text::Member& member : text::members_of<cansync_slave_SlaveSideStatus>) {
    // The common families have it as that of RealtimeStatus.
    if (member.type != text::MemberType::unsigned_long_long || member.name == "reports_lost") continue;
    EXPECT_TRUE(sources.contains(fmt::format("SlaveSideStatus.{}", member.name))) << member.name;
  }
}

TEST(SlaveMetrics, TheTableOfTheDocumentIsTheCode) {
  EXPECT_EQ(documented_metrics("Of a slave"), rows_of(slave_metric_families()));
}

}  // namespace
}  // namespace cansyncd
