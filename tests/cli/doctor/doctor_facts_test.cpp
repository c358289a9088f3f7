#include "cli/doctor/doctor_facts.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace cansync::cli {
namespace {

namespace fs = std::filesystem;

/// A made-up root folder.
class Tree {
 public:
  Tree()
      : root_(fs::path(testing::TempDir()) /
              (std::string("cansync_doctor_") +
               testing::UnitTest::GetInstance()->current_test_info()->name())) {
    fs::remove_all(root_);
  }
  ~Tree() { fs::remove_all(root_); }
  Tree(const Tree&) = delete;
  Tree& operator=(const Tree&) = delete;
  void write(const std::string& path, const std::string& text) const {
    fs::create_directories((root_ / path).parent_path());
    std::ofstream(root_ / path) << text;
  }
  const fs::path& root() const { return root_; }

 private:
  fs::path root_;
};

TEST(DoctorFacts, AreReadFromTheTree) {
  const Tree tree;
  tree.write("proc/sys/kernel/osrelease", "6.1.0-37-rt-amd64\n");
  tree.write("proc/sys/kernel/version", "#1 SMP PREEMPT_RT Debian 6.1.140-1\n");
  tree.write("sys/devices/system/cpu/isolated", "1,4-7\n");
  const std::string idle = "sys/devices/system/cpu/cpu1/cpuidle/";
  tree.write(idle + "state0/name", "POLL\n");
  tree.write(idle + "state0/latency", "0\n");
  tree.write(idle + "state1/name", "C1\n");
  tree.write(idle + "state1/latency", "2\n");
  tree.write(idle + "state1/disable", "0\n");
  tree.write(idle + "state2/name", "C6\n");
  tree.write(idle + "state2/latency", "133\n");
  tree.write(idle + "state2/disable", "1\n");
  const MachineFacts facts = read_machine(tree.root(), 1);
  EXPECT_EQ(facts.kernel, "6.1.0-37-rt-amd64");
  EXPECT_EQ(facts.preemption, "PREEMPT_RT");
  EXPECT_EQ(facts.isolated, "1,4-7");
  ASSERT_EQ(facts.idle_states.size(), 2u) << "the third is switched off";
  EXPECT_EQ(facts.idle_states[1].name, "C1");
  EXPECT_EQ(facts.idle_states[1].exit_latency, 2u);
}

TEST(DoctorFacts, OfAnEmptyTreeAreUnknown) {
  const Tree tree;
  const MachineFacts facts = read_machine(tree.root(), -1);
  EXPECT_EQ(facts.kernel + facts.preemption + facts.isolated, "");
  EXPECT_TRUE(facts.idle_states.empty());
}

TEST(DoctorFacts, ProcessorLists) {
  EXPECT_TRUE(in_processor_list("1,4-7", 1));
  EXPECT_TRUE(in_processor_list("1,4-7", 5));
  EXPECT_FALSE(in_processor_list("1,4-7", 3));
  EXPECT_FALSE(in_processor_list("", 0));
  EXPECT_FALSE(in_processor_list("x-3", 3));
  EXPECT_FALSE(in_processor_list("1-", 1));
}

TEST(DoctorFacts, UnitAndInterfaceOfABusAreThoseOfItsConfiguration) {
  const Tree tree;
  tree.write("etc/cansync/press.toml", "[bus]\nname = \"press\"\ninterface = \"can3\"\n");
  tree.write("etc/cansync/unnamed.toml", "[dds]\ninterface = \"eth0\"\n[bus]\nname = \"unnamed\"\n");
  tree.write("etc/cansync/number.toml", "[bus]\ninterface = 3\n");
  tree.write("etc/cansync/empty.toml", "[bus]\ninterface = \"\"\n");
  tree.write("etc/cansync/wrong.toml", "[bus\ninterface = \"can3\"\n");
  tree.write("etc/cansync/can0.toml", "[bus]\nname = \"winder\"\ninterface = \"can0\"\n");
  tree.write("etc/cansync/first.toml", "[bus]\ninterface = \"can1\"\n");
  const auto found = [&](const char* bus) {
    const auto one = configured_bus(tree.root(), bus);
    return one ? one->unit + " " + one->interface : std::string("none");
  };
  EXPECT_EQ(found("press"), "press can3");
  EXPECT_EQ(found("winder"), "can0 can0") << "the unit has the name of the file, not that of the bus";
  EXPECT_EQ(found("can1"), "first can1");
  EXPECT_EQ(found("unnamed"), "unnamed ");
  EXPECT_EQ(found("number"), "number ");
  for (const char* bus : {"wrong", "absent"}) EXPECT_EQ(found(bus), "none") << bus;
}

}  // namespace
}  // namespace cansync::cli
