#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "cansync/settings/settings_check.h"
#include "config_text.h"

namespace cansyncd {
namespace {

// ---- defaults

TEST(Config, AFileWithOneSlaveIsEnough) {
  const Config config = good(kSmallest);
  EXPECT_EQ(config.bus.kind, BusKind::simulated);
  EXPECT_EQ(config.bus.name, "sim");
  EXPECT_EQ(config.dds.partition, "sim");
  EXPECT_EQ(config.dds.interface, "lo");
  EXPECT_EQ(config.slaves[0].name, "slave0");
  EXPECT_EQ(config.master.configured().bits, 1U);
  EXPECT_EQ(config.drives.slaves.bits, 1U);
  EXPECT_TRUE(cansync::check(config.master).empty());
}

TEST(Config, ASimulatedLineWithoutSlavesHasAll32) {
  for (const char* text : {"", "[bus]\ninterface = \"sim\"\n", "[sim]\nseed = 3\n"}) {
    const Config config = good(text);
    EXPECT_EQ(config.master.configured(), cansync::SlaveMask::all()) << text;
    EXPECT_EQ(config.drives.slaves, cansync::SlaveMask::all()) << text;
    EXPECT_EQ(config.slaves[31].name, "slave31") << text;
    EXPECT_EQ(config.master.process.maximum_slave.value(), 31) << text;
  }
  EXPECT_EQ(good("", {"slave.7.name=winder", "sim.drives=[\"winder\"]"}).drives.slaves.bits, 1U << 7);
  const Config one = good("[bus]\ninterface = \"can0\"\n[[slave]]\nnumber = 4\n");
  EXPECT_EQ(one.master.configured().bits, 1U << 4);
}

TEST(Config, ACanInterfaceWithoutSlavesIsRefused) {
  EXPECT_EQ(problems_text(from_text("", {"bus.interface=can0"}).problems),
            "test.toml: slave: found none configured; allowed: 1..32 configured slaves\n");
}

TEST(Config, TheSyncLine) {
  const Config plain = good(kSmallest);
  EXPECT_EQ(plain.sync.output, SyncOutput::none);
  EXPECT_EQ(plain.sync.input, SyncInput::none);
  EXPECT_FALSE(plain.sync.uses_frame()) << "the software SYNC frame is off by default";
  const Config config = good(
      "[sync]\noutput = \"gpio\"\nedge = \"rising\"\ngpio_line = 17\ninput = \"pps\"\npps_edge = \"clear\"\n"
      "holdover_ms = 5000\ngreatest_step_ns = 200\ninput_offset_ns = -300\n[[slave]]\nnumber = 0\n");
  EXPECT_EQ(config.sync.output, SyncOutput::gpio);
  EXPECT_EQ(config.sync.edge, SyncEdge::rising);
  EXPECT_EQ(config.sync.gpio_line, 17U);
  EXPECT_EQ(config.sync.input, SyncInput::pps);
  EXPECT_EQ(config.sync.pps_edge, SyncEdge::falling);
  EXPECT_EQ(config.sync.holdover, std::chrono::seconds(5));
  EXPECT_EQ(config.sync.greatest_step, std::chrono::nanoseconds(200));
  EXPECT_EQ(config.sync.input_offset, std::chrono::nanoseconds(-300));
}

TEST(Config, SyncCombinationsThatMakeNoSenseAreRefused) {
  const auto problems = [](const std::string& sync) {
    return problems_text(from_text("[sync]\n" + sync + "[[slave]]\nnumber = 0\n").problems);
  };
  EXPECT_EQ(problems("output = \"gpio\"\ninput = \"gpio\"\ninput_gpio_line = 1\n"), "");
  EXPECT_EQ(problems("output = \"can\"\ninput = \"pps\"\n"), "");
  EXPECT_EQ(problems("output = \"none\"\ninput = \"can\"\n"), "");
  EXPECT_NE(problems("output = \"phc\"\ninput = \"pps\"\n")
                .find("test.toml:3:9: sync.input: found an input beside output = \"phc\"; allowed: \"none\""),
            std::string::npos);
  EXPECT_NE(problems("output = \"can\"\ninput = \"can\"\n").find("sync.input: found \"can\" beside"),
            std::string::npos);
  EXPECT_NE(problems("output = \"gpio\"\ninput = \"gpio\"\ngpio_line = 4\ninput_gpio_line = 4\n")
                .find("test.toml:5:19: sync.input_gpio_line: found 4 of /dev/gpiochip0, which is the output"),
            std::string::npos);
  for (const char* identifier : {"0x010", "0x100", "0x1FF", "0x300", "0x3FF", "0x500", "0x5FF"}) {
    const std::string line = std::string("can_identifier = ") + identifier + "\n";
    EXPECT_NE(
        problems("output = \"can\"\n" + line).find("sync.can_identifier: found " + std::string(identifier)),
        std::string::npos)
        << identifier;
    EXPECT_EQ(problems(line), "") << "not used";
  }
  for (const char* identifier : {"1", "0x0FF", "0x200", "0x400", "0x600", "0x7FF"}) {
    EXPECT_EQ(problems(std::string("input = \"can\"\ncan_identifier = ") + identifier + "\n"), "")
        << identifier;
  }
}

TEST(Config, SendMarginFollowsTheBitRateUnlessGiven) {
  using std::chrono::microseconds;
  const std::string slave = "\n[[slave]]\nnumber = 0\n";
  EXPECT_EQ(good("[bus]\nbit_rate = 1000000" + slave).master.send_margin, microseconds(50));
  EXPECT_EQ(good("[bus]\nbit_rate = 500000" + slave).master.send_margin, microseconds(100));
  EXPECT_EQ(good("[bus]\nbit_rate = 250000" + slave).master.send_margin, microseconds(200));
  EXPECT_EQ(good("[bus]\nbit_rate = 125000" + slave).master.send_margin, microseconds(400));
  EXPECT_EQ(good("[bus]\nbit_rate = 125000\nsend_margin_us = 60" + slave).master.send_margin,
            microseconds(60));
}

// The table states each default once more, for the documents: it must say what the structs say.
TEST(Config, DefaultsOfTheTableAreThoseOfTheStructs) {
  const Config config = good(kSmallest);
  const cansync::MasterSettings plain;
  EXPECT_EQ(config.master.bit_rate, plain.bit_rate);
  EXPECT_EQ(config.master.send_margin, plain.send_margin);
  EXPECT_EQ(config.master.slaves[0].status_parameter, plain.slaves[0].status_parameter);
  EXPECT_EQ(config.master.slaves[0].block_limit, plain.slaves[0].block_limit);
  EXPECT_EQ(config.master.slaves[0].actual_mapping, plain.slaves[0].actual_mapping);
  EXPECT_EQ(config.master.process.reference_mapping, plain.process.reference_mapping);
  EXPECT_EQ(config.master.process.polling, plain.process.polling);
  EXPECT_EQ(config.master.process.poll_nobody, plain.process.poll_nobody);
  EXPECT_EQ(config.master.process.full_length, plain.process.full_length);
  EXPECT_EQ(config.master.process.poll_without_reference, plain.process.poll_without_reference);
  EXPECT_EQ(config.master.process.release_limit, plain.process.release_limit);
  EXPECT_EQ(config.master.process.ahead_limit, plain.process.ahead_limit);
  EXPECT_EQ(config.master.process.too_old_after, plain.process.too_old_after);
  EXPECT_EQ(config.master.process.hold_too_old, plain.process.hold_too_old);
  EXPECT_EQ(config.master.startup.enable, plain.startup.enable);
  EXPECT_EQ(config.master.startup.activate_command, plain.startup.activate_command);
  EXPECT_EQ(config.master.startup.activate_data, plain.startup.activate_data);
  EXPECT_EQ(config.master.startup.status_period, plain.startup.status_period);
  EXPECT_EQ(config.master.startup.lost_after, plain.startup.lost_after);
}

TEST(Config, DefaultsOfTheCommandChannelAreThoseOfTheStruct) {
  const cansync::CommandChannelSettings channel = good(kSmallest).master.command_channel;
  const cansync::CommandChannelSettings plain;
  EXPECT_EQ(channel.serving, plain.serving);
  EXPECT_EQ(channel.minimum_share, plain.minimum_share);
  EXPECT_EQ(channel.control_word, plain.control_word);
  EXPECT_EQ(channel.parameter, plain.parameter);
  EXPECT_EQ(channel.transfer, plain.transfer);
  EXPECT_EQ(channel.parameter_queue, plain.parameter_queue);
  EXPECT_EQ(channel.transfer_queue, plain.transfer_queue);
  EXPECT_EQ(channel.broadcast_queue, plain.broadcast_queue);
  EXPECT_EQ(channel.parameter_monitoring, plain.parameter_monitoring);
  EXPECT_EQ(channel.transfer_monitoring, plain.transfer_monitoring);
  EXPECT_EQ(channel.command_monitoring, plain.command_monitoring);
  EXPECT_EQ(channel.repeat_unanswered_writes, plain.repeat_unanswered_writes);
  EXPECT_EQ(channel.telegram_repeats, plain.telegram_repeats);
  EXPECT_EQ(channel.block_retries, plain.block_retries);
  EXPECT_EQ(channel.allow_reserved_addresses, plain.allow_reserved_addresses);
  EXPECT_EQ(channel.address_step, plain.address_step);
}

TEST(Config, DefaultsOfTheDaemonAreThoseOfTheStructs) {
  const Config config = good(kSmallest);
  const Config plain;
  EXPECT_EQ(config.realtime.mode, plain.realtime.mode);
  EXPECT_EQ(config.realtime.priority, plain.realtime.priority);
  EXPECT_EQ(config.realtime.cpu, plain.realtime.cpu);
  EXPECT_EQ(config.realtime.lock_memory, plain.realtime.lock_memory);
  EXPECT_EQ(config.realtime.request_queue, plain.realtime.request_queue);
  EXPECT_EQ(config.realtime.report_queue, plain.realtime.report_queue);
  EXPECT_EQ(config.startup.target, plain.startup.target);
  EXPECT_EQ(config.failsafe.reaction, plain.failsafe.reaction);
  EXPECT_EQ(config.failsafe.hold_intervals, plain.failsafe.hold_intervals);
  EXPECT_EQ(config.failsafe.control_word, plain.failsafe.control_word);
  EXPECT_EQ(config.failsafe.control_word_slaves, plain.failsafe.control_word_slaves);
  EXPECT_EQ(config.failsafe.reference_deadline, plain.failsafe.reference_deadline);
  EXPECT_EQ(config.failsafe.reference_max_age, plain.failsafe.reference_max_age);
  EXPECT_EQ(config.dds.domain, plain.dds.domain);
  EXPECT_EQ(config.dds.interval_topic, plain.dds.interval_topic);
  EXPECT_EQ(config.dds.xml, plain.dds.xml);
  EXPECT_EQ(config.drives.lock_time, plain.drives.lock_time);
  EXPECT_EQ(config.sim.seed, plain.sim.seed);
  EXPECT_EQ(config.drives.memory, plain.drives.memory);
  EXPECT_EQ(config.drives.missing_references, plain.drives.missing_references);
  EXPECT_EQ(config.drives.missing_edges, plain.drives.missing_edges);
  EXPECT_EQ(config.sim.trace, plain.sim.trace);
  EXPECT_EQ(config.references, plain.references);
}

// ---- what options do

TEST(Config, BothFormsOfAMappingMeanTheSame) {
  // M 3.1.1.1: doubleword value 0 in words 0 and 1, low words of values 2 and 3 in words 2 and 3.
  const Config arrays = good(
      "[process]\nreference_values_1 = [0, 0, 2, 3]\nreference_high_1 = [false, true, false, false]\n"
      "[[slave]]\nnumber = 5\nactual_values_1 = [0, 0, 2, 3]\nactual_high_1 = [false, true, false, false]\n");
  const Config registers = good(
      "[process]\nreference_registers_1 = [0x01, 0x03, 0x09, 0x0D]\n"
      "[[slave]]\nnumber = 5\nactual_registers_1 = [0x01, 0x03, 0x09, 0x0D]\n");
  EXPECT_EQ(arrays.master.process.reference_mapping, registers.master.process.reference_mapping);
  EXPECT_EQ(arrays.master.slaves[5].actual_mapping, registers.master.slaves[5].actual_mapping);
  EXPECT_EQ(arrays.master.slaves[5].actual_mapping[0].word[3], (cansync::WordMapping{true, false, 3}));
  EXPECT_EQ(arrays.master.slaves[5].actual_mapping[1], cansync::default_mapping(cansync::Channel::two));
}

TEST(Config, ValuesThatGrewTooOldAreHeldOnlyWithThatReaction) {
  const std::string rest = "reference_max_intervals = 20\nhold_intervals = 30\n[[slave]]\nnumber = 0\n";
  EXPECT_EQ(good("[failsafe]\n" + rest).master.process.hold_too_old, 0u);
  const Config config = good("[failsafe]\nreaction = \"hold\"\n" + rest);
  EXPECT_EQ(config.master.process.too_old_after, 20u);
  EXPECT_EQ(config.master.process.hold_too_old, 30u);
}

TEST(Config, NamesUnitsAndScaling) {
  const Config config = good(
      "[[reference]]\nnumber = 2\nname = \"line speed\"\nunit = \"m/min\"\nfactor = 0.5\n"
      "[[slave]]\nnumber = 7\nname = \"winder\"\n"
      "[[slave.value]]\nnumber = 3\nname = \"torque\"\nunit = \"Nm\"\nfactor = 2\noffset = -1.5\n");
  EXPECT_EQ(config.references[2], (ValueConfig{"line speed", "m/min", 0.5, 0.0}));
  EXPECT_EQ(config.slaves[7].name, "winder");
  EXPECT_EQ(config.slaves[7].actual[3], (ValueConfig{"torque", "Nm", 2.0, -1.5}));
  EXPECT_EQ(config.slaves[7].actual[2], ValueConfig{});
}

TEST(Config, CursorsTakeSlaveNamesWhereverTheSlaveStands) {
  const Config config = good(
      "[process]\npolling_1 = \"winder\"\npolling_2 = \"nobody\"\n[command_channel]\nparameter_cursor = 7\n"
      "[sim]\ndrives = [\"winder\", 0]\n[[slave]]\nnumber = 7\nname = \"winder\"\n[[slave]]\nnumber = 0\n");
  const auto seven = *cansync::SlaveNumber::from(7);
  EXPECT_EQ(config.master.process.polling[0], (cansync::Cursor{cansync::Cursor::Kind::fixed, seven}));
  EXPECT_EQ(config.master.process.polling[1].kind, cansync::Cursor::Kind::nobody);
  EXPECT_EQ(config.master.command_channel.parameter, (cansync::Cursor{cansync::Cursor::Kind::fixed, seven}));
  EXPECT_EQ(config.master.process.maximum_slave, seven);
  EXPECT_EQ(config.drives.slaves.bits, 0x81U);
}

TEST(Config, SlavesWithoutTheirOwnValueTakeTheCommonOne) {
  const Config config = good(
      "[[slave]]\nnumber = 0\nblock_limit = 60\n[[slave]]\nnumber = 1\nstatus_parameter = 8\n"
      "[startup]\nstatus_parameter = 400\n[command_channel]\nblock_limit = 600\n");
  EXPECT_EQ(config.master.slaves[0].block_limit, 60);
  EXPECT_EQ(config.master.slaves[0].status_parameter, 400);
  EXPECT_EQ(config.master.slaves[1].block_limit, 600);
  EXPECT_EQ(config.master.slaves[1].status_parameter, 8);
}

TEST(Config, ActualValuesOfAllSlavesAndTheirExceptions) {
  const Config config = good(
      "[process]\nactual_registers_2 = [0x11, 0x15, 0, 0]\n"
      "[[slave]]\nnumber = 0\n[[slave.value]]\nnumber = 1\nunit = \"m/s\"\n"
      "[[slave]]\nnumber = 1\nactual_values_2 = [4, -1, -1, -1]\nactual_high_2 = [true, false, false, "
      "false]\n"
      "[[actual]]\nnumber = 1\nname = \"speed\"\nunit = \"rpm\"\nfactor = 60\n");
  EXPECT_EQ(config.slaves[0].actual[1], (ValueConfig{"speed", "m/s", 60.0, 0.0}));
  EXPECT_EQ(config.slaves[1].actual[1], (ValueConfig{"speed", "rpm", 60.0, 0.0}));
  EXPECT_EQ(config.master.slaves[0].actual_mapping[1].word[1], (cansync::WordMapping{true, false, 5}));
  EXPECT_EQ(config.master.slaves[1].actual_mapping[1].word[0], (cansync::WordMapping{true, true, 4}));
  EXPECT_FALSE(config.master.slaves[1].actual_mapping[1].word[1].assigned);
  EXPECT_EQ(config.master.slaves[1].actual_mapping[0], cansync::default_mapping(cansync::Channel::one));
}

TEST(Config, ValuesHaveASignUnlessTheyAreSaidToHaveNone) {
  const Config config = good(
      "[[reference]]\nnumber = 1\nsigned = false\n[[actual]]\nnumber = 2\nsigned = false\n"
      "[[slave]]\nnumber = 0\n[[slave.value]]\nnumber = 2\nsigned = true\n[[slave.value]]\nnumber = 3\n"
      "signed = false\n[[slave]]\nnumber = 1\n");
  EXPECT_TRUE(config.references[0].is_signed);
  EXPECT_FALSE(config.references[1].is_signed);
  EXPECT_TRUE(config.slaves[0].actual[2].is_signed);
  EXPECT_FALSE(config.slaves[0].actual[3].is_signed);
  EXPECT_FALSE(config.slaves[1].actual[2].is_signed);
  EXPECT_TRUE(config.slaves[1].actual[3].is_signed);
}

TEST(Config, ASocketCanInterfaceNamesTheBus) {
  const Config config = good("[bus]\ninterface = \"can0\"\n[[slave]]\nnumber = 0\n");
  EXPECT_EQ(config.bus.kind, BusKind::socketcan);
  EXPECT_EQ(config.bus.name, "can0");
  EXPECT_EQ(config.dds.partition, "can0");
}

TEST(Config, EveryBitRateSetsItsInterval) {
  for (const cansync::SlotTimes& times : cansync::kSlotTimes) {
    const std::string text = "[bus]\nbit_rate = " + std::to_string(times.bits_per_second) + "\n" + kSmallest;
    EXPECT_EQ(good(text).master.bit_rate, times.bit_rate);
  }
}

TEST(Config, ASimulatedBusIsListenedToOnlyWhenTheFileSaysSo) {
  using std::chrono::milliseconds;
  const std::string slave = "[[slave]]\nnumber = 0\n";
  EXPECT_EQ(good("[bus]\ninterface = \"can0\"\n" + slave).master.startup.listen, milliseconds(1000));
  EXPECT_EQ(good(kSmallest).master.startup.listen, milliseconds(0));
  EXPECT_EQ(good("[startup]\nlisten_ms = 20\n" + slave).master.startup.listen, milliseconds(20));
}

TEST(Config, WhatAnotherMasterBringsAbout) {
  const Config plain = good(kSmallest);
  EXPECT_EQ(plain.startup.after_other_master, AfterOtherMaster::resume);
  EXPECT_EQ(plain.master.startup.on_second_master, cansync::OnSecondMaster::report);
  const Config other =
      good(kSmallest, {"startup.after_other_master=command", "startup.on_second_master=stop"});
  EXPECT_EQ(other.startup.after_other_master, AfterOtherMaster::command);
  EXPECT_EQ(other.master.startup.on_second_master, cansync::OnSecondMaster::stop);
}

// ---- --set

TEST(Override, WinsOverTheFileAndTakesBareWords) {
  const Config config =
      good("[bus]\nbit_rate = 500000\nname = \"a\"\n[[slave]]\nnumber = 3\nname = \"old\"\n",
           {"bus.bit_rate=125000", "bus.name=500", "slave.3.name=new", "slave.3.value.1.unit=rpm",
            "reference.2.factor=0.25", "actual.2.name=torque", "process.polling_1=new", "sim.drives=[]",
            "dds.domain=7"});
  EXPECT_EQ(config.master.bit_rate, cansync::BitRate::kbit125);
  EXPECT_EQ(config.bus.name, "500");
  EXPECT_EQ(config.slaves[3].name, "new");
  EXPECT_EQ(config.slaves[3].actual[1].unit, "rpm");
  EXPECT_EQ(config.references[2].factor, 0.25);
  EXPECT_EQ(config.slaves[3].actual[2].name, "torque");
  EXPECT_EQ(config.master.process.polling[0].slave.value(), 3);
  EXPECT_TRUE(config.drives.slaves.empty());
  EXPECT_EQ(config.dds.domain, 7U);
}

struct WrongOverride {
  const char* assignment;
  const char* expected;
};

TEST(Override, GoesThroughTheSameChecks) {
  const WrongOverride cases[] = {
      {"bus.bit_rate=1", "--set bus.bit_rate=1: bus.bit_rate: found 1; allowed: 125000, 250000"},
      {"bus.rate=1",
       "--set bus.rate=1: bus.rate: no such option; allowed in this section: protocol, name, interface"},
      {"bus.name", "--set bus.name: found no '='; allowed: KEY=VALUE"},
      {"slave.name=a", "--set slave.name=a: slave.name: found key slave.name; allowed: slave.N.OPTION"},
      {"slave.3.value.name=a",
       "slave.3.value.name: found key slave.3.value.name; allowed: slave.N.value.M.OPTION"},
      {"slave.9.name=a", "slave.9.name: no [[slave]] has this number; allowed: numbers of configured slaves"},
      {"slave.32.name=a", "slave.32.name: found key slave.32.name; allowed: slave numbers 0..31"},
      {"slave.1.number=1", "slave.1.number: numbers stand in the file alone"},
      {"actual.name=a", "actual.name: found key actual.name; allowed: actual.N.OPTION"},
      {"reference.8.unit=a", "reference.8.unit: found key reference.8.unit; allowed: value numbers 0..7"},
      {"dds.domain=seven", "dds.domain: found \"seven\"; allowed: 0..230"},
  };
  for (const WrongOverride& wrong : cases) {
    const ConfigFile file = from_text(kSmallest, {wrong.assignment});
    ASSERT_EQ(file.problems.size(), 1U) << wrong.assignment;
    EXPECT_NE(to_string(file.problems[0]).find(wrong.expected), std::string::npos)
        << to_string(file.problems[0]);
  }
}

// ---- status words

TEST(ConfigStatusWord, StandsInOneHalfOfAnActualValueThatIsMapped) {
  const Config config = good(
      "[process]\npolling_apart = true\n[[slave]]\nnumber = 3\nstatus_value = 5\n"
      "status_high = true\n[[slave]]\nnumber = 4\nstatus_value = 0\n",
      {});
  EXPECT_EQ(config.master.slaves[3].status_value, (cansync::ActualWord{5, true}));
  EXPECT_EQ(config.master.slaves[4].status_value, (cansync::ActualWord{0, false}));
  EXPECT_TRUE(config.master.process.polling_apart);
  const auto problems = [](const std::string& slave) {
    return problems_text(from_text("[[slave]]\nnumber = 3\n" + slave).problems);
  };
  EXPECT_NE(problems("status_value = 6\n")
                .find("slave.3.status_value: found 6, low word; allowed: a word of the "
                      "slave's mapping of actual values"),
            std::string::npos)
      << problems("status_value = 6\n");
  EXPECT_NE(problems("status_high = true\n").find("found without status_value"), std::string::npos);
}

// ---- slaves that return

TEST(ConfigReturn, ListsKeepTheirOrderAndTakeBothNotations) {
  const Config config = good(R"([[slave]]
number = 3
on_return = "write"
return_parameters = ["1020=0x12345678", "0x0A=5"]
)",
                             {"command_channel.cancel_at_start=false", "startup.enabling_control_bits=0x8"});
  const cansync::SlaveSettings& slave = config.master.slaves[3];
  EXPECT_EQ(slave.on_return, cansync::OnReturn::write);
  ASSERT_EQ(slave.return_count, 2u);
  EXPECT_EQ(slave.return_parameters[0].number.value(), 1020u);
  EXPECT_EQ(slave.return_parameters[0].value, 0x12345678u);
  EXPECT_EQ(slave.return_parameters[1].number.value(), 10u);
  EXPECT_EQ(slave.return_parameters[1].value, 5u);
  EXPECT_FALSE(config.master.command_channel.cancel_at_start);
  EXPECT_EQ(config.master.startup.enabling_control_bits, 8u);
}

TEST(ConfigReturn, AtMost32) {
  const auto with = [](unsigned count) {
    std::string list;
    for (unsigned i = 0; i < count; ++i) list += "\"" + std::to_string(i) + "=1\",";
    return from_text("[[slave]]\nnumber = 0\non_return = \"check\"\nreturn_parameters = [" + list + "]\n");
  };
  const ConfigFile most = with(32);
  EXPECT_EQ(problems_text(most.problems), "");
  EXPECT_EQ(most.config.master.slaves[0].return_count, 32u);
  EXPECT_NE(problems_text(with(33).problems).find("allowed: a list of at most 32"), std::string::npos);
}

}  // namespace
}  // namespace cansyncd
