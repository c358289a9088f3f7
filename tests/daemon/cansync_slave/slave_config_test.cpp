#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "cansync_slave/config/file.h"
#include "cansync_slave/config/options.h"
#include "config/problem.h"
#include "daemon/cansync_slave/segment/slave_segment.h"

namespace cansyncd {
namespace {

namespace fs = std::filesystem;

class SlaveConfiguration : public testing::Test {
 protected:
  SlaveConfiguration() {
    std::string name = (fs::temp_directory_path() / "cansyncd-test-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~SlaveConfiguration() override {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  SlaveRoleFile load(const std::string& text, const std::vector<std::string>& overrides = {}) const {
    std::ofstream(folder_ / "f.toml") << text;
    return load_slave_config((folder_ / "f.toml").string(), overrides);
  }
  SlaveRoleConfig good(const std::string& text, const std::vector<std::string>& overrides = {}) const {
    const SlaveRoleFile file = load(text, overrides);
    EXPECT_EQ(config::problems_text(file.problems), "");
    return file.config;
  }
  std::string problems(const std::string& text) const { return config::problems_text(load(text).problems); }

  fs::path folder_;
};

TEST_F(SlaveConfiguration, ASlaveWakesForEveryFrameWhateverItSays) {
  const SlaveRoleFile file = load(
      "[bus]\nprotocol = \"cansync-slave\"\ninterface = \"can0\"\nwake_on_frame = false\n[slave]\nnumber = 3\n"
      "[sync]\ninput = \"can\"\n");
  ASSERT_TRUE(file.problems.empty()) << to_string(file.problems[0]);
  EXPECT_TRUE(slave_bus_plan(file.config).bus.wake_on_frame);
}

TEST_F(SlaveConfiguration, TheNumberIsRequired) {
  EXPECT_NE(problems("").find("slave.number: is missing; allowed: 0..31"), std::string::npos) << problems("");
  EXPECT_EQ(good("[slave]\nnumber = 31\n").slave.number.value(), 31);
  EXPECT_NE(problems("[slave]\nnumber = 32\n").find("allowed: 0..31"), std::string::npos);
}

TEST_F(SlaveConfiguration, TheBitRateFixesTheInterval) {
  const SlaveRoleConfig config = good("[slave]\nnumber = 0\n", {"bus.bit_rate=125000"});
  EXPECT_EQ(config.slave.bit_rate, cansync::BitRate::kbit125);
  EXPECT_EQ(config.supervision.interval, std::chrono::milliseconds(8));
}

TEST_F(SlaveConfiguration, MappingsAreRegisterBytesOfTheirTelegram) {
  const SlaveRoleConfig config = good(
      "[slave]\nnumber = 5\nreference_registers_1 = [0x0D, 0, 0x0F, 0]\n"
      "[[monitored]]\nnumber = 7\nregisters_2 = [0x11, 0, 0, 0]\n");
  EXPECT_EQ(config.slave.reference_mapping[0].word[0], (cansync::WordMapping{true, false, 3}));
  EXPECT_FALSE(config.slave.reference_mapping[0].word[1].assigned);
  EXPECT_EQ(config.slave.reference_mapping[0].word[2], (cansync::WordMapping{true, true, 3}));
  ASSERT_TRUE(config.slave.monitored[7]);
  EXPECT_EQ((*config.slave.monitored[7])[1].value_mask(), 0x10);
  EXPECT_FALSE(config.slave.monitored[6]);
  EXPECT_NE(problems("[slave]\nnumber = 5\nactual_registers_1 = [0x11, 0, 0, 0]\n")
                .find("allowed: values 0..3 in the first telegram"),
            std::string::npos);
  EXPECT_NE(problems("[slave]\nnumber = 5\nactual_registers_2 = [2, 0, 0, 0]\n").find("found 0x02 in word 0"),
            std::string::npos);
}

TEST_F(SlaveConfiguration, ASlaveDoesNotListenToItself) {
  EXPECT_NE(
      problems("[slave]\nnumber = 5\n[[monitored]]\nnumber = 5\n").find("allowed: numbers of other slaves"),
      std::string::npos);
}

TEST_F(SlaveConfiguration, TheSimulatedMasterBringsItsOwnSync) {
  EXPECT_NE(problems("[slave]\nnumber = 5\n[sync]\ninput = \"gpio\"\n").find("sync.input"),
            std::string::npos);
  EXPECT_EQ(good("[bus]\ninterface = \"can0\"\n[slave]\nnumber = 5\n[sync]\ninput = \"can\"\n").sync.input,
            SyncInput::can);
}

TEST_F(SlaveConfiguration, OptionsOfTheMasterAreRefused) {
  for (const char* text :
       {"[process]\npolling_1 = 0\n", "[sync]\noutput = \"gpio\"\n", "[[slave]]\nnumber = 1\n"})
    EXPECT_NE(problems(std::string("[slave]\nnumber = 5\n") + text), "") << text;
}

TEST_F(SlaveConfiguration, EachParameterIsADefinitionAndTheStatusWordIsTheDaemons) {
  const SlaveRoleConfig config = good(
      "[slave]\nnumber = 5\nstatus_bits = 7\nunknown_parameter_error = 0xFFFB\n"
      "[[parameter]]\nnumber = 400\nvalue = -5\nminimum = -10\nmaximum = 10\n"
      "[[parameter]]\nnumber = 401\nformat = \"doubleword\"\nvalue = 0xCAFEF00D\naccess = \"read_only\"\n"
      "error_without_application = 0xFFFA\n"
      "[[parameter]]\nnumber = 402\nmaximum = 100\n");
  EXPECT_EQ(config.service.jobs.unknown, cansync::ParameterError::not_present);
  EXPECT_EQ(config.service.jobs.answer_time, std::chrono::seconds(5));
  ASSERT_EQ(config.service.parameters.size(), 4u);
  const cansync::ParameterDefinition& word = config.service.parameters[0];
  EXPECT_EQ(word.number, 400);
  EXPECT_EQ(word.initial, 0xFFFFFFFBu);
  EXPECT_TRUE(word.limited);
  EXPECT_EQ(word.minimum, -10);
  EXPECT_EQ(word.maximum, 10);
  const cansync::ParameterDefinition& doubleword = config.service.parameters[1];
  EXPECT_TRUE(doubleword.doubleword);
  EXPECT_FALSE(doubleword.limited);
  EXPECT_EQ(doubleword.initial, 0xCAFEF00Du);
  EXPECT_EQ(doubleword.access, cansync::ParameterDefinition::Access::read_only);
  EXPECT_EQ(doubleword.without_application, cansync::ParameterError::not_available_now);
  EXPECT_EQ(config.service.parameters[2].minimum, 0);
  EXPECT_EQ(config.service.parameters[3].number, 301);
  EXPECT_EQ(config.service.parameters[3].access, cansync::ParameterDefinition::Access::read_only);
}

TEST_F(SlaveConfiguration, ValuesAndLimitsFitTheFormatAndEachOther) {
  const auto wrong = [this](const std::string& text) {
    return problems("[slave]\nnumber = 5\n[[parameter]]\nnumber = 400\n" + text);
  };
  EXPECT_NE(wrong("value = 65536\n").find("value: found 65536; allowed: 0..65535"), std::string::npos);
  EXPECT_NE(wrong("value = -32769\n").find("value: found -32769; allowed: -32768..32767"), std::string::npos);
  EXPECT_NE(wrong("minimum = 5\nmaximum = 4\n").find("maximum: found 4; allowed: 5..65535"),
            std::string::npos);
  EXPECT_NE(wrong("value = 3\nminimum = 5\n").find("value: found 3; allowed: 5..65535"), std::string::npos);
  EXPECT_NE(problems("[slave]\nnumber = 5\n[[parameter]]\nnumber = 301\n").find("slave.status_parameter"),
            std::string::npos);
  EXPECT_NE(problems("[slave]\nnumber = 5\n[[parameter]]\nnumber = 4096\n").find("allowed: 0..4095"),
            std::string::npos);
}

TEST_F(SlaveConfiguration, AJobOfTheSimulatedMasterIsAParameterOrABlock) {
  const SlaveRoleConfig config = good(
      "[slave]\nnumber = 5\n[[sim.job]]\nnumber = 1\nparameter = 400\nvalue = 3\nevery = 10\n"
      "[[sim.job]]\nnumber = 2\nbytes = 300\ndownload = true\n");
  ASSERT_EQ(config.simulated_jobs.size(), 2u);
  EXPECT_EQ(config.simulated_jobs[0].value, 3u);
  EXPECT_EQ(config.simulated_jobs[1].address, 0x100u);
  EXPECT_NE(problems("[slave]\nnumber = 5\n[[sim.job]]\nnumber = 1\n").find("allowed: one of them"),
            std::string::npos);
}

constexpr std::string_view kProfile =
    "[profile]\nname = \"drive\"\n"
    "[[parameter]]\nnumber = 301\nname = \"status-word\"\nformat = \"word\"\naccess = \"read-only\"\n"
    "[[parameter]]\nnumber = 401\nname = \"speed-limit\"\nformat = \"doubleword\"\naccess = \"read-write\"\n"
    "signed = true\nunit = \"rpm\"\nfactor = 0.5\nminimum = -100\nmaximum = 100\n"
    "[[parameter]]\nnumber = 402\nname = \"type\"\nformat = \"word\"\naccess = \"read-only\"\nminimum = 3\n"
    "[[parameter]]\nnumber = 403\nname = \"old\"\nformat = \"word\"\naccess = \"none\"\n";

TEST_F(SlaveConfiguration, AProfileGivesTheTableAndASectionNarrowsIt) {
  std::ofstream(folder_ / "drive.toml") << kProfile;
  const std::string slave = "[slave]\nnumber = 5\nprofile = \"./drive.toml\"\n";
  using Access = cansync::ParameterDefinition::Access;
  const SlaveRoleConfig plain = good(slave);
  ASSERT_EQ(plain.service.parameters.size(), 4u) << "the status word is the daemon's";
  const cansync::ParameterDefinition limit = plain.service.parameters[0];
  EXPECT_EQ(limit.number, 401);
  EXPECT_TRUE(limit.doubleword && limit.limited);
  EXPECT_EQ(limit.minimum, -200);
  EXPECT_EQ(limit.maximum, 200);
  EXPECT_EQ(plain.service.parameters[1].initial, 3u) << "the limit nearest to 0";
  EXPECT_EQ(plain.service.parameters[1].access, Access::read_only);
  EXPECT_EQ(plain.service.parameters[2].access, Access::not_available);
  EXPECT_EQ(plain.parameters->name, "drive");

  const SlaveRoleConfig narrowed =
      good(slave +
           "[[parameter]]\nnumber = 401\nvalue = -50\nmaximum = 20\naccess = \"read_only\"\n"
           "[[parameter]]\nnumber = 500\nname = \"own\"\nvalue = 9\n");
  ASSERT_EQ(narrowed.service.parameters.size(), 5u);
  EXPECT_EQ(narrowed.service.parameters[0].initial, static_cast<std::uint32_t>(-50));
  EXPECT_EQ(narrowed.service.parameters[0].minimum, -200);
  EXPECT_EQ(narrowed.service.parameters[0].maximum, 20);
  EXPECT_EQ(narrowed.service.parameters[0].access, Access::read_only);
  EXPECT_EQ(narrowed.service.parameters[3].number, 500);
}

TEST_F(SlaveConfiguration, WhatContradictsTheProfileIsTold) {
  std::ofstream(folder_ / "drive.toml") << kProfile;
  const std::string slave = "[slave]\nnumber = 5\nprofile = \"./drive.toml\"\n";
  const auto says = [&](const std::string& more, const char* words) {
    const std::string found = problems(slave + more);
    EXPECT_NE(found.find(words), std::string::npos) << more << found;
  };
  says("[[parameter]]\nnumber = 401\nformat = \"word\"\n",
       "parameter.401.format: found another format than that of speed-limit in the profile; allowed: "
       "\"doubleword\"");
  says("[[parameter]]\nnumber = 401\nmaximum = 201\n",
       "parameter.401.maximum: found 201; allowed: -200..200");
  says("[[parameter]]\nnumber = 401\nname = \"limit\"\n",
       "allowed: \"speed-limit\", as the profile calls it");
  says("[[parameter]]\nnumber = 500\nname = \"type\"\n", "found \"type\", which is parameter 402");
  says("[[parameter]]\nnumber = 500\nname = \"Type\"\n", "allowed: 1..64 lower-case letters");
  EXPECT_NE(problems("[slave]\nnumber = 5\nprofile = \"nowhere\"\n").find("slave.profile"),
            std::string::npos);
}

}  // namespace
}  // namespace cansyncd
