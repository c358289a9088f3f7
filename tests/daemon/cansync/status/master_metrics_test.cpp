#include "daemon/cansync/status/master_metrics.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <regex>
#include <set>
#include <string>
#include <vector>

#include "cansync/dds/convert.h"
#include "cansync_members.h"
#include "daemon/status/common_metrics.h"
#include "gateway_members.h"
#include "tests/daemon/status/documented_metrics.h"

namespace cansyncd {
namespace {

using gateway::dds::copy_text;

/// Samples with a number of its own wherever one is looked for.
struct Samples {
  Samples() {
    copy_text("can0", gateway.bus);
    copy_text("1.2.3", gateway.version);
    copy_text("can0", bus.bus_interface);
    copy_text("lo", gateway.dds_interface);
    copy_text("kernel", bus.timestamp_source);
    copy_text("stop", master.state);
    copy_text("bus-off", bus.controller_state);
    copy_text("missing", bus.link_state);
    copy_text("held", master.reference_release[1].state);
    master.interval_length = 1'000'000;
    master.telegrams_sent = 18'446'744'073'709'551'615ULL;
    master.slaves_responding = 0b1011;
    realtime.sync_phase_error = -1'500;
    master.frames_length = 17;
    gateway.rejected_stale = 19;
    master.reference_release[0].updates = 23;
    gateway.read_only = true;
    slave.slave = 3;
    copy_text("a\"b\\c", slave.name);
    copy_text("held", slave.state);
    slave.responds = true;
    slave.answers = 29;
    slave.longest_response = 123'456;
    timing.intervals = 31;
    timing.left_out[2] = 37;
    timing.bus_load = 443;
    timing.slot[1] = {41, 250'000, 260'000, 270'000, 300'000, 350'000, 43};
    timing.slot[2].planned_start = -1;
    snapshot.histogram = {5, 0, 7};
    snapshot.histogram[15] = 4'294'967'296;  // more than the topic can hold
    snapshot.lateness_sum = std::chrono::nanoseconds(1'234'567'891);
  }
  std::string text(bool with_timing = true) const {
    const std::vector<const cansync_SlaveStatus*> slaves = {&slave};
    return master_metrics_text({gateway, bus, realtime},
                               {&master, slaves, with_timing ? &timing : nullptr, &snapshot}, 47);
  }

  gateway_GatewayStatus gateway = {};
  gateway_BusStatus bus = {};
  gateway_RealtimeStatus realtime = {};
  cansync_MasterStatus master = {};
  cansync_SlaveStatus slave = {};
  cansync_Timing timing = {};
  TimingSnapshot snapshot;
};

std::vector<MetricFamily> all_families() {
  std::vector<MetricFamily> all;
  for (const MetricFamilies& some : {common_metric_families(), master_metric_families()})
    all.insert(all.end(), some.begin(), some.end());
  return all;
}

TEST(MasterMetrics, HasTheNumbersOfTheTopicsInBaseUnits) {
  const std::string text = Samples().text();
  const auto lines = lines_of(text);
  const std::string slave = R"(bus="can0",slave="3",name="a\"b\\c")";
  for (
      const std::string& expected : {
          std::string(
              R"(cansync_info{bus="can0",version="1.2.3",interface="can0",dds_interface="lo",timestamp_source="kernel"} 1)"),
          std::string(R"(cansync_state{bus="can0",state="stop"} 1)"),
          std::string(R"(cansync_state{bus="can0",state="run"} 0)"),
          std::string(R"(cansync_controller_state{bus="can0",state="bus-off"} 1)"),
          std::string(R"(cansync_link_state{bus="can0",state="missing"} 1)"),
          std::string(R"(cansync_sync_state{bus="can0",state="locked"} 0)"),
          std::string(R"(cansync_reference_release_state{bus="can0",telegram="2",state="held"} 1)"),
          std::string(R"(cansync_reference_updates_total{bus="can0",telegram="1"} 23)"),
          std::string(R"(cansync_interval_length_seconds{bus="can0"} 0.001)"),
          std::string(R"(cansync_telegrams_sent_total{bus="can0"} 18446744073709551615)"),
          std::string(R"(cansync_slaves_responding{bus="can0"} 3)"),
          std::string(R"(cansync_sync_phase_error_seconds{bus="can0"} -1.5e-06)"),
          std::string(R"(cansync_frames_rejected_total{bus="can0",kind="length"} 17)"),
          std::string(R"(cansync_requests_rejected_total{bus="can0",reason="stale"} 19)"),
          std::string(R"(cansync_read_only{bus="can0"} 1)"),
          "cansync_slave_state{" + slave + R"(,state="held"} 1)",
          "cansync_slave_responds{" + slave + "} 1",
          "cansync_slave_answers_total{" + slave + "} 29",
          "cansync_slave_longest_response_seconds{" + slave + "} 0.000123456",
          std::string(R"(cansync_intervals_total{bus="can0"} 31)"),
          std::string(R"(cansync_telegrams_left_out_total{bus="can0",slot="CC"} 37)"),
          std::string(R"(cansync_bus_load_ratio{bus="can0"} 0.443)"),
          std::string(R"(cansync_slot_telegrams{bus="can0",slot="WRC1"} 41)"),
          std::string(R"(cansync_slot_start_earliest_seconds{bus="can0",slot="WRC1"} 0.00025)"),
          std::string(R"(cansync_slot_planned_start_seconds{bus="can0",slot="WRC1"} 0.0003)"),
          std::string(R"(cansync_slot_late_total{bus="can0",slot="WRC1"} 43)"),
          std::string(R"(cansync_metrics_write_failures_total{bus="can0"} 47)"),
      }) {
    EXPECT_TRUE(lines.count(expected)) << expected << "\n" << text;
  }
  EXPECT_EQ(text.find("cansync_slave_status_word"), std::string::npos) << "not known yet";
  EXPECT_EQ(text.find(R"(cansync_slot_start_earliest_seconds{bus="can0",slot="RC"})"), std::string::npos);
  EXPECT_EQ(text.find(R"(cansync_slot_planned_start_seconds{bus="can0",slot="RDC1"})"), std::string::npos);
}

TEST(MasterMetrics, TheHistogramIsCumulativeWithItsSum) {
  const auto lines = lines_of(Samples().text());
  for (const char* expected : {
           R"(cansync_sync_lateness_seconds_bucket{bus="can0",le="1e-06"} 5)",
           R"(cansync_sync_lateness_seconds_bucket{bus="can0",le="2e-06"} 5)",
           R"(cansync_sync_lateness_seconds_bucket{bus="can0",le="4e-06"} 12)",
           R"(cansync_sync_lateness_seconds_bucket{bus="can0",le="0.016384"} 12)",
           R"(cansync_sync_lateness_seconds_bucket{bus="can0",le="+Inf"} 4294967308)",
           R"(cansync_sync_lateness_seconds_count{bus="can0"} 4294967308)",
           R"(cansync_sync_lateness_seconds_sum{bus="can0"} 1.234567891)",
       }) {
    EXPECT_TRUE(lines.count(expected)) << expected;
  }
}

TEST(MasterMetrics, EveryFamilyHasItsHeadBeforeItsSamples) {
  const std::string text = Samples().text();
  EXPECT_TRUE(text.ends_with("\n# EOF\n"));
  std::istringstream in(text);
  std::string family;
  std::set<std::string> seen;
  for (std::string line; std::getline(in, line) && line != "# EOF";) {
    std::smatch head;
    if (std::regex_match(line, head, std::regex("# HELP (\\w+) [A-Z0-9].*\\."))) {
      family = head[1];
      EXPECT_TRUE(seen.insert(family).second) << family;
    } else if (line.starts_with("# ")) {
      EXPECT_TRUE(std::regex_match(line, std::regex("# (TYPE|UNIT) " + family + " [a-z_]+"))) << line;
    } else {
      EXPECT_TRUE(
          std::regex_match(line, std::regex(family + "(_total|_bucket|_sum|_count)?\\{bus=.*\\} \\S+")))
          << line;
    }
  }
}

TEST(MasterMetrics, WithoutTimingItsFamiliesAreMissing) {
  const std::string text = Samples().text(false);
  for (const MetricFamily& family : all_families()) {
    const bool of_timing = family.source.starts_with("Timing.");
    const std::string type = fmt::format("# TYPE {} {}\n", family.name, name(family.type));
    if (family.name == "cansync_slave_status_word") continue;
    EXPECT_EQ(text.find(type) == std::string::npos, of_timing) << family.name;
  }
}

TEST(MasterMetrics, UnitsStandAtTheEndOfNames) {
  for (const MetricFamily& family : all_families()) {
    const std::string name(family.name);
    EXPECT_TRUE(std::regex_match(name, std::regex("cansync(_[a-z]+)+"))) << name;
    EXPECT_FALSE(name.ends_with("_total")) << name;
    EXPECT_TRUE(name.ends_with(std::string(family.unit().empty() ? "" : "_") + std::string(family.unit())))
        << name;
    const bool looks_like_seconds = name.ends_with("_seconds");
    EXPECT_EQ(looks_like_seconds, family.unit() == "seconds") << name;
  }
}

/// Members that count, and what they are in the file.
TEST(MasterMetrics, EveryCounterOfTheTopicsIsThere) {
  std::set<std::string> sources;
  for (const MetricFamily& family : all_families()) sources.insert(std::string(family.source));
  const std::string text = Samples().text();
  const auto is_there = [&](std::string_view topic, std::string_view name) {
    if (sources.contains(fmt::format("{}.{}", topic, name))) return true;
    // The kinds of a count are samples of one family.
    return text.find(fmt::format("=\"{}\"}} ", name.substr(name.find('_') + 1))) != std::string::npos;
  };
  // The sums of kinds that are there, the same count as Timing's, and what is no count.
  const std::set<std::string_view> excused = {"rejected_frames", "unexpected_frames", "left_out",
                                              "missed_syncs", "mapping_number"};
  const auto look = [&](std::string_view topic, std::span<const text::Member> members) {
    for (const text::Member& member : members) {
      if (member.type != text::MemberType::unsigned_long_long || excused.contains(member.name)) continue;
      EXPECT_TRUE(is_there(topic, member.name)) << topic << "." << member.name << " is in no family";
    }
  };
  look("GatewayStatus", text::members_of<gateway_GatewayStatus>);
  look("BusStatus", text::members_of<gateway_BusStatus>);
  look("RealtimeStatus", text::members_of<gateway_RealtimeStatus>);
  look("MasterStatus", text::members_of<cansync_MasterStatus>);
  look("SlaveStatus", text::members_of<cansync_SlaveStatus>);
  look("Timing", text::members_of<cansync_Timing>);
}

TEST(MasterMetrics, TheTablesOfTheDocumentAreTheCode) {
  EXPECT_EQ(documented_metrics("Of every protocol"), rows_of(common_metric_families()));
  EXPECT_EQ(documented_metrics("Of a master"), rows_of(master_metric_families()));
}

}  // namespace
}  // namespace cansyncd
