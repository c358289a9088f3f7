#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "config/problem.h"
#include "daemon/layer2/gateway/send_requests.h"
#include "daemon/layer2/segment/layer2_segment.h"
#include "layer2/config/file.h"
#include "layer2/config/options.h"
#include "layer2/config/running.h"

namespace cansyncd {
namespace {

namespace fs = std::filesystem;

class Layer2Configuration : public testing::Test {
 protected:
  Layer2Configuration() {
    std::string name = (fs::temp_directory_path() / "cansyncd-test-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~Layer2Configuration() override {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  Layer2File load(const std::string& text, const std::vector<std::string>& overrides = {}) const {
    std::ofstream(folder_ / "f.toml") << text;
    return load_layer2_config((folder_ / "f.toml").string(), overrides);
  }
  /// The configuration of a file that is in order.
  Layer2Config good(const std::string& text, const std::vector<std::string>& overrides = {}) const {
    const Layer2File file = load(text, overrides);
    EXPECT_EQ(config::problems_text(file.problems), "");
    return file.config;
  }
  /// The problems, with the file's folder left out.
  std::string problems(const std::string& text) const {
    std::string out = config::problems_text(load(text).problems);
    const std::string folder = folder_.string() + "/";
    for (std::size_t at = 0; (at = out.find(folder, at)) != std::string::npos;) out.erase(at, folder.size());
    return out;
  }

  fs::path folder_;
};

TEST_F(Layer2Configuration, WithoutRangesEverythingIsReceived) {
  const Layer2Config config = good("");
  const std::vector<layer2::ReceiveRange> all = {{0, 0x7FF, false, layer2::FrameKinds::data_and_remote},
                                                 {0, 0x1FFFFFFF, true, layer2::FrameKinds::data_and_remote}};
  EXPECT_EQ(config.receive, all);
  EXPECT_EQ(config.bus.bits_per_second, 500'000u);
  EXPECT_EQ(config.send.queue, 400);
  EXPECT_EQ(config.send.high_queue, 20);
  EXPECT_EQ(config.send.timeout, std::chrono::milliseconds(1000));
}

TEST_F(Layer2Configuration, RangesStandInTheOrderOfTheirNumbers) {
  const Layer2Config config = good(R"([[receive]]
number = 7
first = 0x18FE0000
extended = true
kinds = "data"
[[receive]]
number = 2
first = 0x180
last = 0x1FF
kinds = "remote"
)");
  const std::vector<layer2::ReceiveRange> wanted = {{0x180, 0x1FF, false, layer2::FrameKinds::remote},
                                                    {0x18FE0000, 0x1FFFFFFF, true, layer2::FrameKinds::data}};
  EXPECT_EQ(config.receive, wanted);
}

TEST_F(Layer2Configuration, WrongRangesAreToldWithTheirPlace) {
  EXPECT_EQ(problems("[[receive]]\nnumber = 0\nlast = 0x800\n"),
            "f.toml:3:8: receive.0.last: found 0x800; allowed: 0..0x7FF, or extended = true beside it\n");
  EXPECT_EQ(problems("[[receive]]\nnumber = 3\nfirst = 0x200\nlast = 0x1FF\n"),
            "f.toml:3:9: receive.3.first: found 0x200, which is after last, 0x1FF; allowed: 0..0x1FF\n");
}

TEST_F(Layer2Configuration, SimulatedNodesHaveTheirFrame) {
  const Layer2Config config = good(R"([[node]]
number = 4
identifier = 0x321
data = [1, 0xFF]
period_ms = 20
)");
  ASSERT_EQ(config.nodes.size(), 1u);
  EXPECT_EQ(config.nodes[0].number, 4u);
  EXPECT_EQ(config.nodes[0].frame.id, 0x321u);
  EXPECT_EQ(config.nodes[0].frame.dlc, 2);
  EXPECT_EQ(config.nodes[0].frame.data[1], 0xFF);
  EXPECT_EQ(config.nodes[0].period, std::chrono::milliseconds(20));
  EXPECT_EQ(Layer2Parts::bus_plan(config).sim.nodes.size(), 1u);
}

TEST_F(Layer2Configuration, WrongNodesAreToldWithTheirPlace) {
  EXPECT_EQ(
      problems("[[node]]\nnumber = 1\nidentifier = 0x20000\n"),
      "f.toml:3:14: node.1.identifier: found 0x20000; allowed: 0..0x7FF, or extended = true beside it\n");
  EXPECT_NE(problems("[[node]]\nnumber = 1\ndata = [256]\n").find("a list of at most eight numbers 0..255"),
            std::string::npos);
}

TEST_F(Layer2Configuration, L9L10ScriptsAreCheckedWithTheirLine) {
  const Layer2Config config = good(R"([script]
run = ["// the SYNC timer", "Start 3", "Wait 10", "Send 0x000 2 1 0"]
[[timer]]
number = 3
identifier = 0x80
period_us = 5000
phase_us = 100
)");
  const FrameMachineSettings settings = Layer2Parts::machine_settings(config, nullptr);
  EXPECT_EQ(settings.module.run.commands.size(), 3u);
  ASSERT_TRUE(settings.module.timers[2]);
  EXPECT_EQ(settings.module.timers[2]->period, std::chrono::milliseconds(5));
  EXPECT_EQ(settings.module.timers[2]->phase, std::chrono::microseconds(100));
  EXPECT_EQ(settings.module.timers[2]->frame.id, 0x80u);
  EXPECT_FALSE(settings.module.timers[0]);
  EXPECT_EQ(problems("[script]\nstop = [\"Wait 1\", \"Wait 0\"]\n"),
            "f.toml:2:8: script.stop: line 2, column 6: time in ms: found '0'; allowed: 1..65535\n");
}

TEST_F(Layer2Configuration, L11L13TimersAndTheWindowAreChecked) {
  EXPECT_EQ(
      problems("[[timer]]\nnumber = 2\nidentifier = 0x800\n"),
      "f.toml:3:14: timer.2.identifier: found 0x800; allowed: 0..0x7FF, or extended = true beside it\n");
  EXPECT_NE(problems("[[timer]]\nnumber = 17\n").find("1..16"), std::string::npos);
  EXPECT_NE(problems("[window]\nused = true\n[[timer]]\nnumber = 2\n").find("takes timers 1 and 2"),
            std::string::npos);
  EXPECT_NE(
      problems("[window]\nused = true\nbegin_us = 500\nend_us = 500\n").find("not after window.begin_us"),
      std::string::npos);
  EXPECT_NE(problems("[window]\nused = true\nbegin_us = 500\nend_us = 819\n").find("at least 320 us after"),
            std::string::npos);
  EXPECT_EQ(problems("[window]\nused = true\nbegin_us = 500\nend_us = 820\n"), "");
  EXPECT_NE(problems("[window]\nused = true\nrepeat_us = 400\nend_us = 500\n").find("after window.repeat_us"),
            std::string::npos);
}

TEST_F(Layer2Configuration, L50AMappingIsChecked) {
  const Layer2Config config = good(R"([mapping]
identifier = 0x180
mask = 0x780
interval_ms = 20
[[mapped]]
number = 0
identifier = 0x181
size = 2
address = 10
[[mapped]]
number = 1
identifier = 0x201
output = true
size = 8
)");
  ASSERT_EQ(config.mapped.size(), 2u);
  EXPECT_TRUE(config.mapped[1].output);
  EXPECT_EQ(config.mapping.interval, std::chrono::milliseconds(20));
  EXPECT_EQ(
      problems("[[mapped]]\nnumber = 3\nsize = 2\n[[mapped]]\nnumber = 5\naddress = 1\nidentifier = 1\n"),
      "f.toml:5:10: mapped.5.number: another entry fills the same byte of the image\n");
}

TEST_F(Layer2Configuration, WithoutAMaskOnlyTheTableBelongsToAMapping) {
  const Layer2Config config = good("[[mapped]]\nnumber = 0\nidentifier = 0x201\n");
  EXPECT_TRUE(config.mapping.table_alone);
  EXPECT_FALSE(good("[mapping]\nmask = 0\n").mapping.table_alone);
  EXPECT_EQ(
      problems("[mapping]\nidentifier = 0x180\n").find("f.toml:2:14: mapping.identifier: found without"), 0u);
}

// 20 telegrams of 8 bytes have 111 bits each without stuff bits: 8.88 ms at 250 kbit/s.
TEST_F(Layer2Configuration, ATableThatTheBusCannotCarryIsRefused) {
  const auto text = [](int telegrams, const std::string& more) {
    std::string all = "[bus]\nbit_rate = 250000\n[mapping]\ninterval_ms = 9\n" + more;
    for (int i = 0; i < telegrams; ++i)
      all += fmt::format("[[mapped]]\nnumber = {}\nidentifier = {}\nsize = 8\noutput = true\n", i, i);
    return all;
  };
  (void)good(text(20, ""));
  EXPECT_EQ(
      problems(text(21, "")),
      "f.toml:4:15: mapping.interval_ms: found 9 ms, but all telegrams of the table together (21) take 9.3 ms at 250000 "
      "bit/s, without any other frame; allowed: at least 10, fewer telegrams, or mapping.on_change\n");
  (void)good(text(21, "on_change = true\n"));
}

// A remote frame with 29 bits has 67 bits, one with 11 and 8 bytes 111: 536 us and 888 us at 125 kbit/s.
TEST_F(Layer2Configuration, TimersThatTheBusCannotCarryAreRefused) {
  const auto text = [](int first_us, int second_us, const std::string& more) {
    return fmt::format(
        "[bus]\nbit_rate = 125000\n[[timer]]\nnumber = 3\nidentifier = 1\nextended = true\nremote = true\nperiod_us = {}\n"
        "[[timer]]\nnumber = 4\nidentifier = 2\ndata = [1, 2, 3, 4, 5, 6, 7, 8]\nperiod_us = {}\n{}",
        first_us, second_us, more);
  };
  (void)good(text(1072, 1776, ""));
  (void)good(text(1072, 100, "cyclic = false\n"));
  EXPECT_EQ(
      problems(text(1072, 1700, "")),
      "f.toml:13:13: timer.4.period_us: found 1700 us, but the timers and the table of the process image together take "
      "102 % of the bus at 125000 bit/s, without any other frame; allowed: up to 100 %: longer periods, or fewer of "
      "them\n");
  const std::string table =
      "[mapping]\ninterval_ms = 10\n[[mapped]]\nnumber = 0\nidentifier = 3\nsize = 8\noutput = true\n";
  EXPECT_NE(problems(text(1072, 1776, table)).find("take 108 % of the bus"), std::string::npos);
}

TEST_F(Layer2Configuration, ATextChangesWhatItNamesAndNothingElse) {
  const Layer2File file = load(R"([mapping]
identifier = 0x180
mask = 0x780
writer_lost = "zero"
first_always = false
[[mapped]]
number = 0
identifier = 0x201
output = true
[filter]
node = 5
)");
  ASSERT_TRUE(file.problems.empty());
  RunningConfiguration running(file);
  const auto change = [&](std::string_view toml) {
    std::string problem;
    const auto prepared = running.prepare(toml, problem);
    ASSERT_TRUE(prepared) << problem;
    running.adopt(*prepared);
  };
  // What CAN_DMAP says: nothing of what becomes of the image.
  change(
      "[mapping]\nidentifier = 0x200\nmask = 0x700\ninterval_ms = 20\n"
      "[[mapped]]\nnumber = 7\nidentifier = 0x202\n");
  EXPECT_EQ(running.config().writer_lost, WriterLost::zero);
  EXPECT_FALSE(running.config().mapping.first_always);
  EXPECT_EQ(running.config().mapping.rule.mask, 0x700u);
  ASSERT_EQ(running.config().mapped.size(), 1u);
  EXPECT_EQ(running.config().mapped[0].identifier, 0x202u);
  EXPECT_EQ(running.tables(), 1u);
  change("[mapping]\non_change = true\n");
  EXPECT_EQ(running.config().mapped.size(), 1u) << "the table stays";
  EXPECT_EQ(running.config().mapping.interval, std::chrono::milliseconds(20));
  change("[filter]\nextended = true\n");
  EXPECT_EQ(running.config().node_filter, 5);
  EXPECT_EQ(running.tables(), 2u);
  change("[[receive]]\nnumber = 0\nfirst = 1\n");
  EXPECT_EQ(running.config().node_filter, 0) << "ranges take its place";
  change("[mapping]\n");
  EXPECT_TRUE(running.config().mapped.empty());
  EXPECT_EQ(running.tables(), 3u);
}

TEST_F(Layer2Configuration, L33MessageObjectsAreChecked) {
  const Layer2Config config = good(R"([[object]]
number = 31
transmit = true
identifier = 0x18DAF110
extended = true
timeout_ms = 50
[[object]]
number = 0
identifier = 0x137
mask = 0x7EC
tell = true
)");
  ASSERT_EQ(config.objects.size(), 2u);
  EXPECT_EQ(config.objects[0].settings.rule, (layer2::MaskRule{0x137, 0x7EC, false}));
  EXPECT_TRUE(config.objects[0].settings.tell);
  const auto settings = Layer2Parts::machine_settings(config, nullptr);
  ASSERT_TRUE(settings.module.objects[31]);
  EXPECT_EQ(settings.module.objects[31]->timeout, std::chrono::milliseconds(50));
  EXPECT_EQ(
      problems("[[object]]\nnumber = 2\nidentifier = 0x800\n"),
      "f.toml:3:14: object.2.identifier: found 0x800; allowed: 0..0x7FF, or extended = true beside it\n");
  EXPECT_EQ(
      problems("[[mapped]]\nnumber = 0\n[[object]]\nnumber = 29\n"),
      "f.toml:4:10: object.29.number: found 29; allowed: 0..27, 30, 31, because the mapping has 28 and 29\n");
  EXPECT_NE(problems("[[object]]\nnumber = 32\n").find("0..31"), std::string::npos);
}

TEST_F(Layer2Configuration, L8ANodeFilterTakesThePlaceOfRanges) {
  const Layer2Config config = good("[filter]\nnode = 5\n");
  const FrameMachineSettings settings = Layer2Parts::machine_settings(config, nullptr);
  ASSERT_TRUE(settings.module.station.node);
  EXPECT_EQ(settings.module.station.node->node, 5);
}

TEST_F(Layer2Configuration, SectionsOfAnotherProtocolAreRefused) {
  EXPECT_NE(problems("[[slave]]\nnumber = 1\n").find("f.toml:1:"), std::string::npos);
  EXPECT_NE(problems("[process]\n").find("no such section"), std::string::npos);
}

TEST_F(Layer2Configuration, OptionsWithoutEffectAreRefusedWithTheirPlace) {
  for (const std::string key : {"recorder.syncs_missed", "recorder.slave_lost", "recorder.second_master",
                                "dds.interval_topic", "access.profile_rules"}) {
    const std::size_t dot = key.find('.');
    const std::string text = "[" + key.substr(0, dot) + "]\n" + key.substr(dot + 1) + " = true\n";
    EXPECT_EQ(problems(text).find("f.toml:2:1: " + key + ": "), 0u) << problems(text);
  }
  EXPECT_FALSE(good("[recorder]\nsending_failed = false\n").recorder.triggers.sending_failed);
}

TEST_F(Layer2Configuration, TheDefaultFileIsRightAndSaysTheDefaults) {
  const Layer2Config printed = good(config::default_file(layer2_options(), layer2_document_heads.file));
  EXPECT_EQ(printed.send.queue, SendConfig{}.queue);
  EXPECT_EQ(printed.bus.bits_per_second, good("").bus.bits_per_second);
}

TEST(SendRequests, AFullQueueIsToldWithTheRoomOfItsOwn) {
  Layer2File file;
  file.config.send.queue = 64;
  file.config.send.high_queue = 20;
  RunningConfiguration running(file);
  const SendRequests requests(running);
  const auto text = [&](layer2::Priority priority) {
    FrameRequest request;
    request.job = layer2::SendOrder{.priority = priority};
    const auto problem = requests.refusal({.refusal = layer2::Refusal::queue_full}, request);
    return problem.value_or(gateway::dds::Denial{}).reason;
  };
  EXPECT_NE(text(layer2::Priority::normal).find("at most 64 frames"), std::string::npos);
  EXPECT_NE(text(layer2::Priority::high).find("at most 20 frames"), std::string::npos);
}

}  // namespace
}  // namespace cansyncd
