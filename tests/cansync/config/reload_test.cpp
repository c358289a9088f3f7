#include "cansync/config/reload.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cansync/config/options.h"
#include "config/document.h"

namespace cansyncd {
namespace {

using Keys = std::vector<std::string>;

ConfigFile from_text(const std::string& text) {
  ConfigFile file =
      build_config(config::resolve(config::parse_document(text, "test.toml"), options()), "test.toml");
  EXPECT_EQ(problems_text(file.problems), "");
  return file;
}

ConfigReload plan(const std::string& before, const std::string& after) {
  return plan_reload(from_text(before), from_text(after));
}

constexpr const char* kSlave = "[[slave]]\nnumber = 1\n";

TEST(Reload, TheSameFileChangesNothing) {
  const ConfigReload same = plan(kSlave, kSlave);
  EXPECT_EQ(same.applied, Keys{});
  EXPECT_EQ(same.needs_restart, Keys{});
}

TEST(Reload, WritingADefaultDownIsNoChange) {
  const ConfigReload same =
      plan(kSlave, std::string("[bus]\nbit_rate = 1000000\n[dds]\ndomain = 0\n") + kSlave);
  EXPECT_EQ(same.applied, Keys{});
  EXPECT_EQ(same.needs_restart, Keys{});
}

TEST(Reload, MappingNamesScalingAndPollingTakeEffect) {
  const ConfigReload changed =
      plan(std::string("[process]\npolling_1 = 1\n") + kSlave,
           "[process]\npolling_2 = 1\nreference_registers_1 = [0x09, 0, 0, 0]\n"
           "[command_channel]\ntransfer_cursor = \"winder\"\n[[reference]]\nnumber = 2\nname = \"speed\"\n"
           "[[slave]]\nnumber = 1\nname = \"winder\"\nactual_registers_2 = [0x1D, 0, 0, 0]\n"
           "[[slave.value]]\nnumber = 7\nfactor = 0.1\n");
  EXPECT_EQ(changed.applied, (Keys{"command_channel.transfer_cursor", "process.polling_1",
                                   "process.polling_2", "process.reference_registers_1", "reference.2.name",
                                   "slave.1.actual_registers_2", "slave.1.name", "slave.1.value.7.factor"}));
  EXPECT_EQ(changed.needs_restart, Keys{});
  EXPECT_EQ(problems_text(changed.merged.problems), "");
  const Config& config = changed.merged.config;
  EXPECT_EQ(config.master.process.polling[0].kind, cansync::Cursor::Kind::automatic);
  EXPECT_EQ(config.master.process.polling[1].kind, cansync::Cursor::Kind::fixed);
  EXPECT_EQ(config.master.command_channel.transfer.slave.value(), 1);
  EXPECT_EQ(config.master.process.reference_mapping[0].word[0].value, 2);
  EXPECT_EQ(config.master.slaves[1].actual_mapping[1].word[0].value, 7);
  EXPECT_EQ(config.references[2].name, "speed");
  EXPECT_EQ(config.slaves[1].name, "winder");
  EXPECT_EQ(config.slaves[1].actual[7].factor, 0.1);
}

TEST(Reload, WhatNeedsARestartKeepsItsRunningValue) {
  const ConfigReload changed =
      plan(std::string("[bus]\nbit_rate = 500000\n") + kSlave,
           std::string("[bus]\nbit_rate = 125000\n[dds]\ndomain = 5\n[process]\npolling_1 = \"nobody\"\n") +
               kSlave);
  EXPECT_EQ(changed.needs_restart, (Keys{"bus.bit_rate", "dds.domain"}));
  EXPECT_EQ(changed.applied, (Keys{"process.polling_1"}));
  EXPECT_EQ(changed.merged.config.master.bit_rate, cansync::BitRate::kbit500);
  EXPECT_EQ(changed.merged.config.dds.domain, 0U);
  EXPECT_EQ(changed.merged.config.master.process.polling[0].kind, cansync::Cursor::Kind::nobody);
}

TEST(Reload, TheSetOfSlavesNeedsARestart) {
  const ConfigReload changed =
      plan("[[slave]]\nnumber = 1\n[[slave]]\nnumber = 2\nname = \"gone\"\n",
           "[[slave]]\nnumber = 1\nname = \"kept\"\n[[slave]]\nnumber = 3\nname = \"new\"\n");
  EXPECT_EQ(changed.needs_restart,
            (Keys{"slave.2.name", "slave.2.number", "slave.3.name", "slave.3.number"}));
  EXPECT_EQ(changed.applied, (Keys{"slave.1.name"}));
  EXPECT_EQ(changed.merged.config.master.configured().bits, 0b110U);
  EXPECT_EQ(changed.merged.config.slaves[1].name, "kept");
  EXPECT_EQ(changed.merged.config.slaves[2].name, "gone");
}

TEST(Reload, OptionsOfTheLineAloneTakeEffectWhenItIsSetUpAnew) {
  const ConfigReload changed = plan(
      "[bus]\nbit_rate = 500000\n[[slave]]\nnumber = 1\n[[slave]]\nnumber = 2\nname = \"gone\"\n",
      "[bus]\nname = \"other\"\nbit_rate = 125000\n[dds]\ndomain = 5\n[process]\npolling_1 = 3\n"
      "poll_nobody = 99\n[access]\nread_only = true\n[[slave]]\nnumber = 1\nname = \"kept\"\n[[slave]]\nnumber = 3\n");
  EXPECT_NE(problems_text(changed.merged.problems), "") << "the cursor needs slave 3";
  EXPECT_EQ(changed.needs_set_up, (Keys{"bus.bit_rate", "process.poll_nobody", "slave.2.name",
                                        "slave.2.number", "slave.3.number"}));
  EXPECT_EQ(problems_text(changed.anew.problems), "");
  const Config& anew = changed.anew.config;
  EXPECT_EQ(anew.master.configured().bits, 0b1010U);
  EXPECT_EQ(anew.master.bit_rate, cansync::BitRate::kbit125);
  EXPECT_EQ(anew.master.process.poll_nobody, 99);
  EXPECT_EQ(anew.master.process.polling[0].slave.value(), 3);
  EXPECT_EQ(anew.slaves[1].name, "kept");
  EXPECT_TRUE(anew.access.read_only) << "what can change while the line runs changes with it";
  // What belongs to the process stays.
  EXPECT_EQ(anew.dds.domain, 0U);
  EXPECT_NE(anew.bus.name, "other");
}

TEST(Reload, ASimulatedLineOfAllSlavesStaysOne) {
  const ConfigReload fewer = plan("", "[[slave]]\nnumber = 1\nname = \"winder\"\n");
  EXPECT_EQ(fewer.needs_restart, (Keys{"slave.1.number"}));
  EXPECT_EQ(fewer.applied, (Keys{"slave.1.name"}));
  EXPECT_EQ(fewer.merged.config.master.configured(), cansync::SlaveMask::all());
  EXPECT_EQ(fewer.merged.config.slaves[1].name, "winder");
  EXPECT_EQ(plan("[[slave]]\nnumber = 1\n", "").merged.config.master.configured().bits, 0b10U);
}

TEST(Reload, ChangesThatMakeNoSenseWithoutARestartAreRefused) {
  const ConfigReload changed = plan("[[slave]]\nnumber = 1\n[[slave]]\nnumber = 2\nname = \"winder\"\n",
                                    "[[slave]]\nnumber = 1\nname = \"winder\"\n");
  ASSERT_EQ(changed.merged.problems.size(), 1U);
  EXPECT_NE(to_string(changed.merged.problems[0]).find("which is the name of slave 1 too"), std::string::npos)
      << to_string(changed.merged.problems[0]);
}

TEST(Reload, TheNextReloadComparesWithWhatIsRunning) {
  const std::string wanted = std::string("[dds]\ndomain = 5\n[process]\npolling_1 = 1\n") + kSlave;
  const ConfigReload first = plan(kSlave, wanted);
  const ConfigReload second = plan_reload(first.merged, from_text(wanted));
  EXPECT_EQ(second.applied, Keys{});
  EXPECT_EQ(second.needs_restart, (Keys{"dds.domain"}));
}

}  // namespace
}  // namespace cansyncd
