#include "sim/fault_script.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "cansync/sim/drive_faults.h"
#include "scripted_node.h"

namespace {

using namespace sim::test;
using sim::Fault;
using sim::FaultKind;
using sim::FaultScript;

Fault only(std::string_view text) {
  const FaultScript script = sim::parse_fault_script(text, "script.toml", sim::drive_faults());
  for (const auto& error : script.errors) ADD_FAILURE() << to_string(error);
  return script.faults.size() == 1 ? script.faults[0] : Fault{};
}

TEST(FaultScript, EmptyScriptHasNoFaults) {
  const FaultScript script = sim::parse_fault_script("# nothing\n", "script.toml", sim::drive_faults());
  EXPECT_TRUE(script.faults.empty());
  EXPECT_TRUE(script.errors.empty());
}

TEST(FaultScript, EveryKeyOfALostFrame) {
  const Fault fault = only(R"([[fault]]
kind = "lost"
from = 100
to = 120
count = 3
probability = 0.5
slave = 5
channel = "rdc2"
receivers = [1, 31, "master"]
)");
  EXPECT_EQ(fault.kind, FaultKind::lost);
  EXPECT_EQ(fault.from, 100u);
  EXPECT_EQ(fault.to, 120u);
  EXPECT_EQ(fault.count, 3u);
  EXPECT_EQ(fault.probability, 0.5);
  EXPECT_EQ(fault.node, 5);
  EXPECT_EQ(fault.identifier, 0x380u);
  EXPECT_EQ(fault.mask, 0x780u);
  EXPECT_EQ(fault.receivers.bits, 0x80000002u);
  EXPECT_TRUE(fault.lost_to_master);
}

TEST(FaultScript, IdentifiersMayHave29Bits) {
  const Fault wide = only("[[fault]]\nkind = \"lost\"\nidentifier = 0x18DAF110\nextended = true\n");
  EXPECT_EQ(wide.identifier, 0x18DAF110u);
  EXPECT_EQ(wide.extended, true);
  EXPECT_EQ(only("[[fault]]\nkind = \"lost\"\n").extended, std::nullopt);
  const FaultScript wrong =
      sim::parse_fault_script("[[fault]]\nkind = \"lost\"\nextended = 1\n", "f.toml", sim::drive_faults());
  ASSERT_EQ(wrong.errors.size(), 1u);
  EXPECT_EQ(to_string(wrong.errors[0]),
            "f.toml:3:12: extended is 1; allowed: true (29-bit identifiers) or false (those of 11 bits)");
}

TEST(FaultScript, DefaultsAreAlwaysAndEverybody) {
  const Fault fault = only("[[fault]]\nkind = \"lost\"\n");
  EXPECT_EQ(fault.from, 0u);
  EXPECT_EQ(fault.to, Fault::kNoLimit);
  EXPECT_EQ(fault.count, Fault::kNoLimit);
  EXPECT_EQ(fault.probability, 1.0);
  EXPECT_FALSE(fault.node.has_value());
  EXPECT_EQ(fault.mask, 0u);
  EXPECT_EQ(fault.receivers, sim::NodeSet::all());
  EXPECT_TRUE(fault.lost_to_master);
  EXPECT_FALSE(only("[[fault]]\nkind = \"lost\"\nreceivers = [3]\n").lost_to_master);
}

TEST(FaultScript, EveryKind) {
  EXPECT_EQ(only("[[fault]]\nkind = \"late\"\ndelay_us = 12.5\n").delay, us(12.5));
  EXPECT_EQ(only("[[fault]]\nkind = \"corrupted\"\nidentifier = 0x010\n").mask, 0x1FFFFFFFu);
  EXPECT_EQ(only("[[fault]]\nkind = \"corrupted\"\nidentifier = 0x010\nmask = 0x0F0\n").mask, 0x0F0u);
  EXPECT_EQ(only("[[fault]]\nkind = \"duplicated\"\nchannel = \"action\"\n").identifier, 0x010u);
  EXPECT_EQ(only("[[fault]]\nkind = \"silent\"\nslave = 7\n").node, 7);
  EXPECT_EQ(only("[[fault]]\nkind = \"wrong_answer\"\n").kind, FaultKind::wrong_answer);
  EXPECT_EQ(only("[[fault]]\nkind = \"busy\"\nslave = 0\n").node, 0);
  EXPECT_EQ(only("[[fault]]\nkind = \"missing_sync\"\n").kind, FaultKind::missing_sync);
  const Fault inject = only("[[fault]]\nkind = \"inject\"\nframe = \"17F#0102\"\nat_us = 250\n");
  EXPECT_EQ(inject.frame, frame("17F#0102"));
  EXPECT_EQ(inject.delay, us(250));
}

TEST(FaultScript, EveryChannel) {
  const std::pair<std::string, std::uint32_t> channels[] = {{"wrc1", 0x100},    {"wrc2", 0x180},
                                                            {"rdc1", 0x300},    {"rdc2", 0x380},
                                                            {"command", 0x500}, {"response", 0x580}};
  for (const auto& [channel, identifier] : channels) {
    const Fault fault = only("[[fault]]\nkind = \"lost\"\nchannel = \"" + channel + "\"\n");
    EXPECT_EQ(fault.identifier, identifier);
    EXPECT_EQ(fault.mask, 0x780u);
  }
}

struct Wrong {
  std::string_view text;
  std::string_view error;  // whole or the beginning of it
};

class FaultScriptErrors : public testing::TestWithParam<Wrong> {};

TEST_P(FaultScriptErrors, NamePlaceFindAndRange) {
  const FaultScript script = sim::parse_fault_script(GetParam().text, "f.toml", sim::drive_faults());
  EXPECT_TRUE(script.faults.empty());
  ASSERT_FALSE(script.errors.empty());
  EXPECT_EQ(to_string(script.errors[0]).substr(0, GetParam().error.size()), GetParam().error);
}

INSTANTIATE_TEST_SUITE_P(
    Scripts, FaultScriptErrors,
    testing::Values(
        Wrong{"[[fault]\n", "f.toml:1:9: not valid TOML: "},
        Wrong{"bus = 1\n", "f.toml:1:1: bus is unknown here; allowed: tables [[fault]]"},
        Wrong{"[fault]\n", "f.toml:1:1: fault is a table; allowed: tables [[fault]] with double brackets"},
        Wrong{"fault = [1]\n", "f.toml:1:10: fault is 1; allowed: tables [[fault]]"},
        Wrong{"\n[[fault]]\nslave = 1\n",
              "f.toml:2:1: a fault needs the key kind; allowed: \"lost\", \"late\","},
        Wrong{"[[fault]]\nkind = \"gone\"\n", "f.toml:2:8: kind is \"gone\"; allowed: \"lost\", \"late\""},
        Wrong{"[[fault]]\nkind = 3\n", "f.toml:2:8: kind is 3; allowed: "},
        Wrong{"[[fault]]\nkind = \"busy\"\ndelay_us = 3\n",
              "f.toml:3:1: delay_us is no key of a fault of kind \"busy\"; allowed: kind, from, to, count, "
              "probability, slave"},
        Wrong{"[[fault]]\nkind = \"lost\"\nslaev = 3\n", "f.toml:3:1: slaev is no key of a fault"},
        Wrong{"[[fault]]\nkind = \"lost\"\nslave = 32\n",
              "f.toml:3:9: slave is 32; allowed: a whole number 0 to 31"},
        Wrong{"[[fault]]\nkind = \"lost\"\nslave = \"x\"\n",
              "f.toml:3:9: slave is \"x\"; allowed: a whole number"},
        Wrong{"[[fault]]\nkind = \"lost\"\nfrom = -1\n",
              "f.toml:3:8: from is -1; allowed: a whole number 0 to "},
        Wrong{"[[fault]]\nkind = \"lost\"\ncount = 0\n",
              "f.toml:3:9: count is 0; allowed: a whole number 1 to "},
        Wrong{"[[fault]]\nkind = \"lost\"\nfrom = 5\nto = 4\n",
              "f.toml:4:6: to is 4; allowed: from (5) or later"},
        Wrong{"[[fault]]\nkind = \"lost\"\nprobability = 1.5\n",
              "f.toml:3:15: probability is 1.5; allowed: a number 0 to 1"},
        Wrong{"[[fault]]\nkind = \"lost\"\nprobability = nan\n",
              "f.toml:3:15: probability is nan; allowed: "},
        Wrong{"[[fault]]\nkind = \"lost\"\nchannel = \"rc\"\n",
              "f.toml:3:11: channel is \"rc\"; allowed: \"action\", \"wrc1\", \"wrc2\", \"rdc1\", \"rdc2\", "
              "\"command\", \"response\""},
        Wrong{"[[fault]]\nkind = \"lost\"\nchannel = \"rdc1\"\nidentifier = 1\n",
              "f.toml:4:14: channel and identifier exclude each other"},
        Wrong{"[[fault]]\nkind = \"lost\"\nmask = 1\n", "f.toml:3:8: mask needs the key identifier"},
        Wrong{"[[fault]]\nkind = \"lost\"\nidentifier = 0x20000000\n",
              "f.toml:3:14: identifier is 536870912; allowed: a whole number 0 to 536870911"},
        Wrong{"[[fault]]\nkind = \"lost\"\nreceivers = []\n",
              "f.toml:3:13: receivers is an array; allowed: "},
        Wrong{"[[fault]]\nkind = \"lost\"\nreceivers = [1, \"all\"]\n",
              "f.toml:3:17: receivers is \"all\"; allowed: "},
        Wrong{"[[fault]]\nkind = \"late\"\n", "f.toml:1:1: a fault of kind \"late\" needs the key delay_us"},
        Wrong{"[[fault]]\nkind = \"late\"\ndelay_us = 0\n",
              "f.toml:3:12: delay_us is 0; allowed: a number 0.001 to 1000000"},
        Wrong{"[[fault]]\nkind = \"silent\"\n", "f.toml:1:1: a fault of kind \"silent\" needs the key slave"},
        Wrong{"[[fault]]\nkind = \"inject\"\n", "f.toml:1:1: a fault of kind \"inject\" needs the key frame"},
        Wrong{"[[fault]]\nkind = \"inject\"\nframe = \"17#\"\n",
              "f.toml:3:9: frame is \"17#\"; allowed: \"identifier#data\" (at character 1: "},
        Wrong{"[[fault]]\nkind = \"inject\"\nframe = \"20000008#\"\n",
              "f.toml:3:9: frame is \"20000008#\"; allowed: a data or remote frame"}));

TEST(FaultScript, AllErrorsAreReportedInTheOrderOfTheFile) {
  const FaultScript script = sim::parse_fault_script(R"([[fault]]
kind = "lost"
slave = 99
count = 0
[[fault]]
kind = "nothing"
)",
                                                     "f.toml", sim::drive_faults());
  ASSERT_EQ(script.errors.size(), 3u);
  EXPECT_EQ(script.errors[0].where.line, 3u);
  EXPECT_EQ(script.errors[1].where.line, 4u);
  EXPECT_EQ(script.errors[2].where.line, 6u);
  EXPECT_TRUE(script.refused());
}

TEST(FaultScript, AFaultWithAnErrorIsLeftOutAlone) {
  const FaultScript script = sim::parse_fault_script(R"([[fault]]
kind = "silent"
slave = 1
[[fault]]
kind = "silent"
slaev = 2
[[fault]]
kind = "busy"
slave = "2
[[fault]]
kind = "busy"
slave = 3
)",
                                                     "f.toml", sim::drive_faults());
  ASSERT_EQ(script.faults.size(), 2u);
  EXPECT_EQ(script.faults[0].node, 1);
  EXPECT_EQ(script.faults[1].node, 3);
  ASSERT_EQ(script.places.size(), 2u);
  EXPECT_EQ(script.places[1].line, 11u);
  EXPECT_FALSE(script.refused());
  ASSERT_EQ(script.errors.size(), 3u);
  EXPECT_TRUE(
      to_string(script.errors[0]).starts_with("f.toml:4:1: a fault of kind \"silent\" needs the key"));
  EXPECT_TRUE(to_string(script.errors[1]).starts_with("f.toml:6:1: slaev is no key"));
  EXPECT_TRUE(to_string(script.errors[2]).starts_with("f.toml:9:")) << to_string(script.errors[2]);
}

TEST(FaultScript, IsReadFromAFile) {
  const auto path =
      std::filesystem::temp_directory_path() / ("cansync_faults_" + std::to_string(::getpid()) + ".toml");
  std::ofstream(path) << "[[fault]]\nkind = \"silent\"\nslave = 3\n";
  const FaultScript script = sim::load_fault_script(path, sim::drive_faults());
  std::filesystem::remove(path);
  EXPECT_EQ(script.faults.size(), 1u);
  EXPECT_TRUE(script.errors.empty());
}

TEST(FaultScript, FileThatCannotBeReadIsAnError) {
  const auto error_of = [](const char* path) {
    const FaultScript script = sim::load_fault_script(path, sim::drive_faults());
    return script.errors.size() == 1 ? to_string(script.errors[0]) : "";
  };
  EXPECT_EQ(error_of("/nonexistent/faults.toml"),
            "/nonexistent/faults.toml: cannot be read: No such file or directory");
  EXPECT_EQ(error_of("/tmp"), "/tmp: cannot be read: it is a folder");
  EXPECT_EQ(error_of("/dev/zero"),
            "/dev/zero: cannot be read: it is a device, pipe or socket; allowed: a text file");
}

TEST(FaultScript, WhatIsNoTextHasAPlace) {
  const auto error_of = [](const std::string& text) {
    const FaultScript script = sim::parse_fault_script(text, "f.toml", sim::drive_faults());
    return script.errors.empty() ? "" : to_string(script.errors[0]);
  };
  EXPECT_TRUE(error_of(std::string("\0", 1)).starts_with("f.toml:1:1: not valid TOML: ")) << "binary";
  EXPECT_TRUE(error_of("[[fault]]\nkind = \"\xFF\"\n").starts_with("f.toml:2:")) << "no UTF-8";
  EXPECT_TRUE(error_of("[[fault]]\nkind = \"lost\"\nkind = \"lost\"\n").starts_with("f.toml:3:")) << "twice";
  EXPECT_TRUE(error_of("a = " + std::string(100'000, '[')).starts_with("f.toml:1:")) << "nested lists";
  std::string deep = "a";
  for (int i = 0; i < 100'000; ++i) deep += ".a";
  EXPECT_EQ(error_of(deep + " = 1\n"),
            "f.toml:1:2: found a key of more than 16 parts; allowed: tables [[fault]]");
}

// The examples of the documentation are scripts that load.
TEST(FaultScript, ExamplesOfTheDocumentationAreValid) {
  std::ifstream file(CANSYNC_SOURCE_DIR "/docs/fault-scripts.md");
  ASSERT_TRUE(file) << "docs/fault-scripts.md";
  std::string line;
  std::string block;
  bool inside = false;
  std::size_t faults = 0;
  while (std::getline(file, line)) {
    if (inside && line == "```") {
      const FaultScript script = sim::parse_fault_script(block, "docs/fault-scripts.md", sim::drive_faults());
      for (const auto& error : script.errors) ADD_FAILURE() << to_string(error) << "\n" << block;
      faults += script.faults.size();
    }
    if (line.starts_with("```")) {
      inside = line == "```toml";
      block.clear();
    } else if (inside) {
      block += line + "\n";
    }
  }
  EXPECT_GE(faults, sim::kFaultKinds);
}

}  // namespace
