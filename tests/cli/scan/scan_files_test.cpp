// What `scan --write` writes: a configuration that the daemon takes, with what the drives told in it.
#include "cli/scan/scan_files.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "cansync/config/file.h"
#include "profile/reader.h"

namespace cansync::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kWinder = R"([profile]
name = "winder"
recognised_by = ["100=4400"]
[[parameter]]
number = 310
name = "web-position"
format = "doubleword"
access = "read-only"
signed = true
unit = "mm"
factor = 0.25
actual_value = 0
[[parameter]]
number = 314
name = "temperature"
format = "word"
access = "read-only"
actual_value = 6
)";

class ScanFiles : public ::testing::Test {
 protected:
  ScanFiles() {
    std::string name = (fs::temp_directory_path() / "cansync_files.XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    line_.heard.interface = "can3";
    line_.heard.live = true;
    line_.heard.bit_rate = BitRate::kbit250;
    line_.heard.rate_source = RateSource::interface;
  }
  ~ScanFiles() override { fs::remove_all(folder_); }

  FoundSlave& add(unsigned number) {
    FoundSlave slave;
    slave.number = *SlaveNumber::from(number);
    slave.status_word = 0x8021;
    slave.parameters = {{301, false, 0x8021, 0}};
    line_.slaves.push_back(slave);
    return line_.slaves.back();
  }

  cansyncd::ConfigFile written() {
    write_learned_files((folder_ / "line").string(), scan_files(line_));
    return cansyncd::load_config((folder_ / "line" / "can3.toml").string(), {});
  }

  std::string text_of_file(const std::string& name) const {
    std::ifstream in(folder_ / "line" / name);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  fs::path folder_;
  ScannedLine line_;
};

TEST_F(ScanFiles, TheDaemonTakesTheConfiguration) {
  FoundSlave& winder = add(7);
  winder.status_parameter = 501;
  winder.block_limit = 126;
  winder.actual[0] = TelegramMapping{{WordMapping{true, false, 2}, WordMapping{true, false, 0}, {}, {}}};
  winder.actual[1] = TelegramMapping{};
  winder.reference[0] = TelegramMapping{{WordMapping{true, false, 1}, {}, {}, {}}};
  winder.reference[1] = TelegramMapping{};
  const auto reading = profile::parse(kWinder, "winder.toml");
  ASSERT_TRUE(reading.profile);
  winder.profile = std::make_shared<const profile::Profile>(*reading.profile);
  line_.profiles = {{"winder", kWinder}, {"not-used", "x"}};
  const auto file = written();
  ASSERT_TRUE(file.problems.empty()) << config::problems_text(file.problems);
  const cansyncd::Config& config = file.config;
  EXPECT_EQ(config.master.bit_rate, BitRate::kbit250);
  EXPECT_EQ(config.master.configured().bits, 1u << 7);
  const SlaveSettings& slave = config.master.slaves[7];
  EXPECT_EQ(slave.status_parameter, 501);
  EXPECT_EQ(slave.block_limit, 126);
  EXPECT_EQ(slave.actual_mapping[0], *winder.actual[0]);
  EXPECT_EQ(slave.actual_mapping[1], TelegramMapping{});
  EXPECT_EQ(config.master.process.reference_mapping[0], *winder.reference[0]);
  EXPECT_EQ(config.slaves[7].actual[0].name, "web-position");
  EXPECT_EQ(config.slaves[7].actual[0].unit, "mm");
  EXPECT_EQ(config.slaves[7].actual[0].factor, 0.25);
  EXPECT_EQ(config.slaves[7].actual[6].name, "") << "the drive does not send it";
  ASSERT_TRUE(config.slaves[7].parameters);
  EXPECT_EQ(slave.expect_count, 0) << "the profile has no identity";
  EXPECT_FALSE(fs::exists(folder_ / "line" / "profiles" / "not-used.toml"));
  EXPECT_TRUE(fs::exists(folder_ / "line" / "network" / "80-can3.network"));
}

TEST_F(ScanFiles, WhoTheDriveIsIsExpectedAsFarAsItWasRead) {
  const auto identity = [](unsigned number, const std::string& name, const char* kind) {
    return "\n[[parameter]]\nnumber = " + std::to_string(number) + "\nname = \"" + name +
           "\"\nformat = \"doubleword\"\naccess = \"read-only\"\nidentity = \"" + kind + "\"\n";
  };
  const std::string profile = kWinder + identity(600, "type", "type") + identity(601, "serial", "unit") +
                              identity(602, "not-read", "unit");
  const auto reading = profile::parse(profile, "winder.toml");
  ASSERT_TRUE(reading.profile);
  for (const unsigned number : {7u, 8u}) {
    FoundSlave& winder = add(number);
    winder.profile = std::make_shared<const profile::Profile>(*reading.profile);
    winder.parameters = {{600, true, 4400, 0}, {601, true, 0x12345678, 0}, {602, true, 0, 0xFFFA}};
  }
  line_.slaves.back().twice = true;
  line_.profiles = {{"winder", profile}};
  const auto file = written();
  ASSERT_TRUE(file.problems.empty()) << config::problems_text(file.problems);
  const auto expected = expected_of(file.config.master.slaves[7]);
  ASSERT_EQ(expected.size(), 2u);
  EXPECT_EQ(expected[0], (ParameterValue{*ParameterNumber::from(600), 4400}));
  EXPECT_EQ(expected[1], (ParameterValue{*ParameterNumber::from(601), 0x12345678}));
  EXPECT_EQ(file.config.master.slaves[8].expect_count, 0) << "nobody knows of which drive it was read";
}

TEST_F(ScanFiles, ADriveWithoutAProfileGetsADraftThatIsOne) {
  FoundSlave& slave = add(2);
  slave.parameters.push_back({420, false, 0, 0xFFFA});
  slave.parameters.push_back({1000, true, 77, 0});
  const auto file = written();
  ASSERT_TRUE(file.problems.empty()) << config::problems_text(file.problems);
  ASSERT_TRUE(file.config.slaves[2].parameters);
  EXPECT_EQ(file.config.slaves[2].parameters->name, "scanned-2");
  EXPECT_EQ(file.config.slaves[2].parameters->parameters.size(), 2u);
}

TEST_F(ScanFiles, MappingsThatDifferAreLeftToThePerson) {
  add(1).reference[0] = TelegramMapping{{WordMapping{true, false, 1}, {}, {}, {}}};
  add(2).reference[0] = TelegramMapping{{WordMapping{true, false, 2}, {}, {}, {}}};
  const auto file = written();
  ASSERT_TRUE(file.problems.empty()) << config::problems_text(file.problems);
  EXPECT_EQ(file.config.master.process.reference_mapping[0], default_mapping(Channel::one));
}

TEST_F(ScanFiles, TheAdapterIsPinnedAndGetsAName) {
  add(1);
  line_.heard.pin = can::read_pin("serial=0042B7,channel=1").pin;
  line_.new_name = "can-winder";
  write_learned_files((folder_ / "line").string(), scan_files(line_));
  const auto file = cansyncd::load_config((folder_ / "line" / "can-winder.toml").string(), {});
  ASSERT_TRUE(file.problems.empty()) << config::problems_text(file.problems);
  EXPECT_EQ(file.config.bus.name, "can-winder");
  EXPECT_EQ(file.config.bus.interface, "can-winder");
  EXPECT_EQ(file.config.bus.adapter, "serial=0042B7,channel=1");
  const std::string link = text_of_file("network/60-can-winder.link");
  EXPECT_NE(link.find("[Match]\nProperty=ID_SERIAL_SHORT=0042B7 CANSYNC_CHANNEL=1\n"), std::string::npos)
      << link;
  EXPECT_NE(link.find("\nName=can-winder\n"), std::string::npos) << link;
  EXPECT_NE(text_of_file("network/80-can-winder.network").find("[Match]\nName=can-winder\n"),
            std::string::npos);
}

TEST_F(ScanFiles, WithoutANewNameTheAdapterIsPinnedAllTheSame) {
  add(1);
  line_.heard.pin = can::read_pin("path=pci-0000:03:00.0").pin;
  EXPECT_EQ(written().config.bus.adapter, "path=pci-0000:03:00.0");
  const std::string link = text_of_file("network/60-can3.link");
  EXPECT_NE(link.find("[Match]\nPath=pci-0000:03:00.0\n"), std::string::npos) << link;
  EXPECT_EQ(link.find("\nName="), std::string::npos)
      << "a name that the kernel gives is for the first that it finds";
}

TEST_F(ScanFiles, AnAdapterThatNothingDistinguishesGetsNoName) {
  add(1);
  EXPECT_EQ(written().config.bus.adapter, "");
  line_.new_name = "can-winder";
  EXPECT_THROW(scan_files(line_), std::runtime_error);
}

TEST_F(ScanFiles, NothingIsWrittenWithoutSlavesOrBitRate) {
  EXPECT_THROW(scan_files(line_), std::runtime_error);
  add(1);
  line_.heard.bit_rate.reset();
  EXPECT_THROW(scan_files(line_), std::runtime_error);
}

}  // namespace
}  // namespace cansync::cli
