#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "cansync_cluster/config/file.h"
#include "config/problem.h"

namespace cansyncd {
namespace {

namespace fs = std::filesystem;

class ClusterConfiguration : public testing::Test {
 protected:
  ClusterConfiguration() {
    std::string name = (fs::temp_directory_path() / "cansyncd-test-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~ClusterConfiguration() override {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  ClusterFile load(const std::string& text, const std::vector<std::string>& overrides = {}) const {
    std::ofstream(folder_ / "f.toml") << text;
    return load_cluster_config((folder_ / "f.toml").string(), overrides);
  }
  ClusterConfig good(const std::string& text, const std::vector<std::string>& overrides = {}) const {
    const ClusterFile file = load(text, overrides);
    EXPECT_EQ(config::problems_text(file.problems), "");
    return file.config;
  }
  /// Without the file's folder.
  std::string problems(const std::string& text, const std::vector<std::string>& overrides = {}) const {
    std::string out = config::problems_text(load(text, overrides).problems);
    const std::string folder = folder_.string() + "/";
    for (std::size_t at = out.find(folder); at != std::string::npos; at = out.find(folder))
      out.erase(at, folder.size());
    return out;
  }

  fs::path folder_;
};

constexpr const char* kSmallest = "[upper.slave]\nnumber = 5\n";

TEST_F(ClusterConfiguration, TheSmallestFileIsTwoSimulatedBusesOfOneName) {
  const ClusterConfig config = good(kSmallest);
  EXPECT_EQ(config.upper.bus.name, "cluster.upper");
  EXPECT_EQ(config.lower.bus.name, "cluster.lower");
  EXPECT_EQ(config.upper.dds.partition, "cluster.upper");
  EXPECT_EQ(config.lower.dds.partition, "cluster.lower");
  EXPECT_EQ(config.upper.bus.kind, BusKind::simulated);
  EXPECT_EQ(config.cluster.upper.number.value(), 5);
  EXPECT_EQ(config.cluster.lower.configured().bits, 0xFFFFFFFFu);
}

TEST_F(ClusterConfiguration, WhatBothHaveTogetherReachesBoth) {
  const ClusterConfig config = good(
      "[bus]\nname = \"cell\"\nbit_rate = 250000\n[realtime]\npriority = 7\n"
      "[dds]\ndomain = 9\npartition = \"p\"\n" +
      std::string(kSmallest));
  EXPECT_EQ(config.upper.slave.bit_rate, cansync::BitRate::kbit250);
  EXPECT_EQ(config.lower.master.bit_rate, cansync::BitRate::kbit250);
  EXPECT_EQ(config.upper.realtime.priority, 7);
  EXPECT_EQ(config.lower.realtime.priority, 7);
  EXPECT_EQ(config.lower.dds.domain, 9u);
  EXPECT_EQ(config.upper.bus.name, "cell.upper");
  EXPECT_EQ(config.lower.dds.partition, "p.lower");
}

TEST_F(ClusterConfiguration, EachLevelHasTheOptionsOfItsProtocol) {
  const ClusterConfig config = good(
      "[upper.slave]\nnumber = 5\ntarget = \"setup\"\n[[upper.monitored]]\nnumber = 7\n"
      "[[upper.parameter]]\nnumber = 400\nvalue = 3\n[upper.bus]\ninterface = \"can0\"\n[upper.sync]\n"
      "input = \"gpio\"\n[lower.bus]\ninterface = \"can1\"\n[[lower.slave]]\nnumber = 3\nname = \"w\"\n"
      "[[lower.slave.value]]\nnumber = 0\nunit = \"rpm\"\n[lower.sync]\noutput = \"can\"\n",
      {"lower.slave.3.value.0.unit=m", "upper.slave.status_bits=9", "cluster.own_number=40"});
  EXPECT_EQ(config.upper.slave.number.value(), 5);
  EXPECT_EQ(config.upper.status_bits, 9);
  EXPECT_EQ(config.upper.target, SlaveTarget::setup);
  EXPECT_TRUE(config.upper.slave.monitored[7]);
  EXPECT_EQ(config.upper.bus.interface, "can0");
  EXPECT_TRUE(config.upper.bus.wake_on_frame);
  EXPECT_EQ(config.lower.bus.interface, "can1");
  EXPECT_FALSE(config.lower.bus.wake_on_frame);
  EXPECT_EQ(config.lower.slaves[3].name, "w");
  EXPECT_EQ(config.lower.slaves[3].actual[0].unit, "m");
  EXPECT_EQ(config.lower.sync.output, SyncOutput::can);
  EXPECT_EQ(config.cluster.gateway.own_number.value, 40);
}

TEST_F(ClusterConfiguration, SubSlavesAndTheLeadAxis) {
  const ClusterConfig config = good(
      "[[sub_slave]]\nnumber = 1001\nslave = 3\n[[sub_slave]]\nnumber = 2001\nslave = 4\ngateway = true\n"
      "[[lead]]\nnumber = 4\nvalue = 0\n[[lead]]\nnumber = 5\nfrom = \"monitored\"\nslave = 7\nvalue = 1\n"
      "[[upper.monitored]]\nnumber = 7\n" +
      std::string(kSmallest));
  const std::vector<cansync::SubSlaveRoute> expected = {{{1001}, *cansync::SlaveNumber::from(3), {0}},
                                                        {{2001}, *cansync::SlaveNumber::from(4), {2001}}};
  EXPECT_EQ(config.cluster.gateway.routes, expected);
  EXPECT_EQ(config.cluster.lead[4].kind, cansync::LeadSource::Kind::reference);
  EXPECT_EQ(config.cluster.lead[5].kind, cansync::LeadSource::Kind::monitored);
  EXPECT_EQ(config.cluster.lead[5].slave.value(), 7);
  EXPECT_EQ(config.cluster.lead[0].kind, cansync::LeadSource::Kind::none);
}

TEST_F(ClusterConfiguration, ProblemsNameTheirPlaceAndTheLevelsOption) {
  EXPECT_EQ(problems("[bus]\ninterface = \"x\"\n[upper.slave]\nnumber = 55\n[upper.realtime]\npriority = 3\n"
                     "[lower.sync]\ninput = \"gpio\"\n"),
            "f.toml:2:1: bus.interface: no such option; allowed in this section: protocol, name, bit_rate\n"
            "f.toml:4:10: upper.slave.number: found 55; allowed: 0..31\n"
            "f.toml:6:12: realtime.priority: found below upper; allowed: as realtime.priority, because both "
            "buses have it together\n"
            "f.toml:8:9: lower.sync.input: found \"gpio\"; allowed: nothing, because the lower SYNC follows "
            "that of the upper bus\n");
  EXPECT_EQ(problems("upper = 3\n").substr(0, 40), "f.toml:1:1: upper: found no section; all");
  EXPECT_EQ(problems("[[upper]]\nnumber = 3\n").substr(0, 31), "f.toml:1:1: upper: found no sec");
  EXPECT_NE(problems("").find("upper.slave.number: is missing"), std::string::npos) << problems("");
  EXPECT_NE(problems(kSmallest, {"lower.slave.number=3"}).find("--set lower.slave.number=3"),
            std::string::npos);
  EXPECT_EQ(problems("[bus\n").substr(0, 7), "f.toml:");
}

TEST_F(ClusterConfiguration, WhatDoesNotGoTogetherIsRefused) {
  const std::string slave = kSmallest;
  EXPECT_EQ(problems(slave + "[[sub_slave]]\nnumber = 4\nslave = 3\n[[lower.slave]]\nnumber = 1\n"),
            "f.toml:5:9: sub_slave.4.slave: found 3; allowed: a slave of the lower bus\n");
  EXPECT_EQ(problems(slave + "[[sub_slave]]\nnumber = 4\n"),
            "f.toml:4:10: sub_slave.4.slave: is missing; allowed: 0..31, a slave of the lower bus\n");
  EXPECT_EQ(
      problems(slave + "[[lead]]\nnumber = 4\nvalue = 1\nslave = 2\n"),
      "f.toml:6:9: lead.4.slave: found beside another source; allowed: with from = \"monitored\" alone\n");
  EXPECT_EQ(problems(slave + "[cluster]\nmonitoring_ms = 9000\n"),
            "f.toml:4:17: cluster.monitoring_ms: found 9000 ms; allowed: 1 and more, and shorter than "
            "cluster.asker_gone_ms\n");
  const std::string hold =
      "[lower.failsafe]\nreaction = \"hold\"\nhold_intervals = 5\nreference_max_intervals = ";
  const std::string lead = "[[lead]]\nnumber = 4\nvalue = 1\n";
  EXPECT_EQ(problems(slave + lead + hold + "1\n"),
            "f.toml: lower.failsafe.reference_max_intervals: found 1 where values that are too old are "
            "held; allowed: 0, or 2 and more: with 1 the lead axis would repeat old values\n");
  EXPECT_EQ(problems(slave + lead + hold + "2\n"), "");
  EXPECT_EQ(problems(slave + hold + "1\n"), "");
  EXPECT_NE(problems(slave + "[upper.bus]\ninterface = \"can0\"\n").find("upper.sync.input: is \"none\""),
            std::string::npos);
  EXPECT_NE(problems(slave + "[upper.bus]\ninterface = \"can0\"\n[lower.bus]\ninterface = \"can0\"\n"
                             "[[lower.slave]]\nnumber = 1\n")
                .find("lower.bus.interface: found can0, which is upper.bus.interface"),
            std::string::npos);
}

}  // namespace
}  // namespace cansyncd
