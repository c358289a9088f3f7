#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "config/problem.h"
#include "daemon/cansync_slave/config/file.h"
#include "daemon/cansync_slave/config/options.h"

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

}  // namespace
}  // namespace cansyncd
