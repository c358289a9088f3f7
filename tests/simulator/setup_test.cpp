// The simulator program's command line, configuration and fault script.

#include "simulator/setup.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>

namespace {

using namespace std::chrono_literals;
using cansync_sim::Arguments;
using cansync_sim::make_setup;
using cansync_sim::parse_slaves;

Arguments on(const std::string& interface) {
  Arguments arguments;
  arguments.interface = interface;
  return arguments;
}

/// A file with these contents, gone with the test.
class ScratchFile {
 public:
  explicit ScratchFile(const std::string& contents)
      : path_(testing::TempDir() + "cansync_sim_test_" + std::to_string(::getpid()) + ".toml") {
    std::ofstream(path_) << contents;
  }
  ~ScratchFile() { std::remove(path_.c_str()); }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

std::string problems(const Arguments& arguments) {
  std::string out;
  for (const std::string& problem : make_setup(arguments).problems) out += problem + "\n";
  return out;
}

TEST(SlaveList, NumbersAndRanges) {
  EXPECT_EQ(parse_slaves("3")->bits, 1u << 3);
  EXPECT_EQ(parse_slaves("0-31")->bits, ~0u);
  EXPECT_EQ(parse_slaves("0,3,5-7")->bits, 0b11101001u);
  for (const char* wrong : {"", "32", "3-", "-3", "5-3", "1,,2", "1,", "a", "0x1", "1 2", "-1"}) {
    EXPECT_FALSE(parse_slaves(wrong)) << wrong;
  }
}

TEST(SyncIdentifier, MustNotBeOneOfCansync) {
  for (const std::uint32_t used : {0x010u, 0x100u, 0x17Fu, 0x1FFu, 0x300u, 0x3FFu, 0x500u, 0x5FFu}) {
    EXPECT_TRUE(cansync_sim::is_cansync_identifier(used)) << used;
  }
  for (const std::uint32_t free :
       {0x000u, 0x00Fu, 0x011u, 0x080u, 0x0FFu, 0x200u, 0x2FFu, 0x400u, 0x4FFu, 0x600u, 0x7FFu}) {
    EXPECT_FALSE(cansync_sim::is_cansync_identifier(free)) << free;
  }
  Arguments arguments = on("vcan0");
  arguments.sync_id = "0x510";
  EXPECT_NE(problems(arguments).find("--sync-id: found '0x510', which CANsync uses itself"),
            std::string::npos);
  arguments.sync_id = "2048";
  EXPECT_NE(problems(arguments).find("--sync-id: found '2048'; allowed: hexadecimal"), std::string::npos);
  arguments.sync_id = "0x081";
  EXPECT_EQ(make_setup(arguments).bench.sync_identifier, 0x081u);
}

TEST(Setup, Defaults) {
  const auto setup = make_setup(on("vcan0"));
  ASSERT_TRUE(setup.problems.empty()) << setup.problems[0];
  EXPECT_EQ(setup.interface, "vcan0");
  EXPECT_EQ(setup.bench.sync_identifier, 0x080u);
  EXPECT_EQ(setup.bench.bit_rate, cansync::BitRate::mbit1);
  ASSERT_EQ(setup.drives.size(), 1u);
  EXPECT_EQ(setup.drives[0].slave.number.value(), 0);
  EXPECT_EQ(setup.drives[0].status_parameter, 301);
  EXPECT_EQ(setup.drives[0].lock_time, 500ms);
}

TEST(Setup, ADeviceIsThatOfItsScript) {
  const ScratchFile script("[[answer]]\nto = \"601#\"\nframe = \"581#\"\n");
  Arguments arguments = on("vcan0");
  arguments.device = script.path();
  const auto setup = make_setup(arguments);
  EXPECT_TRUE(setup.problems.empty());
  ASSERT_TRUE(setup.device);
  EXPECT_EQ(setup.device->answers.size(), 1u);
  EXPECT_EQ(setup.interface, "vcan0");
  EXPECT_TRUE(setup.drives.empty());
  arguments.master = true;
  EXPECT_EQ(problems(arguments), "--master: given with --device; allowed: one of the two\n");
  arguments.master = false;
  const ScratchFile wrong("[[answer]]\nto = 1\n");
  arguments.device = wrong.path();
  EXPECT_NE(problems(arguments).find(":2:6: to is 1"), std::string::npos);
}

TEST(Setup, AMasterGetsTheLineAndItsReferenceValues) {
  Arguments arguments = on("can0");
  arguments.master = true;
  arguments.slaves = "0,31";
  arguments.bit_rate = "500000";
  arguments.references = {"0=1000+7", "5=-3"};
  const auto setup = make_setup(arguments);
  ASSERT_TRUE(setup.problems.empty()) << setup.problems[0];
  EXPECT_TRUE(setup.drives.empty());
  ASSERT_TRUE(setup.master);
  EXPECT_EQ(setup.master->master.bit_rate, cansync::BitRate::kbit500);
  EXPECT_EQ(setup.master->master.configured().bits, 0x80000001u);
  EXPECT_EQ(sim::value_of(setup.master->references[0], 2), 1014u);
  EXPECT_EQ(sim::value_of(setup.master->references[5], 2), 0xFFFFFFFDu);
  EXPECT_EQ(setup.master->references[1].kind, sim::ReferenceCurve::Kind::none);
}

TEST(Setup, WrongReferenceValuesAreNamed) {
  for (const char* text : {"", "0", "8=1", "0=", "0=1+", "=1", "0=1x", "0=2147483648", "0x1=1"}) {
    Arguments arguments = on("can0");
    arguments.master = true;
    arguments.references = {text};
    const auto setup = make_setup(arguments);
    ASSERT_EQ(setup.problems.size(), 1u) << text;
    EXPECT_NE(setup.problems[0].find("--reference: found '" + std::string(text) + "'; allowed: "),
              std::string::npos);
  }
  Arguments arguments = on("can0");
  arguments.references = {"0=1"};
  ASSERT_EQ(make_setup(arguments).problems.size(), 1u);
  EXPECT_NE(make_setup(arguments).problems[0].find("without --master"), std::string::npos);
}

TEST(Setup, EveryOptionArrives) {
  Arguments arguments = on("can0");
  arguments.slaves = "0,31";
  arguments.bit_rate = "500000";
  arguments.lock_time = "20";
  arguments.status_parameter = "444";
  arguments.memory = "8192";
  arguments.missing_references = "0";
  arguments.seed = "9";
  arguments.set = {"process.reference_registers_1=[1, 5, 9, 13]", "command_channel.block_limit=60",
                   "sim.missing_edges=50"};
  const auto setup = make_setup(arguments);
  ASSERT_TRUE(setup.problems.empty()) << setup.problems[0];
  ASSERT_EQ(setup.drives.size(), 2u);
  const sim::DriveSettings& drive = setup.drives[1];
  EXPECT_EQ(drive.slave.number.value(), 31);
  EXPECT_EQ(drive.slave.bit_rate, cansync::BitRate::kbit500);
  EXPECT_EQ(drive.lock_time, 20ms);
  EXPECT_EQ(drive.status_parameter, 444);
  EXPECT_EQ(drive.memory.size, 8192u);
  EXPECT_EQ(drive.misses_until_fault, 0u);
  EXPECT_EQ(drive.edges_until_fault, 50u);
  EXPECT_EQ(drive.slave.block_limit, 60);
  EXPECT_NE(drive.slave.reference_mapping, sim::DriveSettings{}.slave.reference_mapping);
  EXPECT_EQ(setup.bench.seed, 9u);
  EXPECT_EQ(setup.bench.bit_rate, cansync::BitRate::kbit500);
}

TEST(Setup, WrongArgumentsAreNamed) {
  EXPECT_NE(problems({}).find("no interface given"), std::string::npos);
  EXPECT_NE(problems(on("sim")).find("'sim', which is the daemon's own simulated line"), std::string::npos);
  EXPECT_NE(problems(on("a name too long for this")).find("bus.interface"), std::string::npos);
  for (const char* strange : {"can'0", "can0'\nbit_rate = 500000\n#", "can\t0"}) {
    EXPECT_EQ(problems(on(strange)),
              std::string("bus.interface: found \"") + strange +
                  "\"; allowed: printable characters but space and ', such as vcan0 or can0\n");
  }
  Arguments arguments = on("vcan0");
  arguments.slaves = "0,32";
  EXPECT_NE(problems(arguments).find("--slaves: found '0,32'; allowed: slave numbers 0..31"),
            std::string::npos);
  arguments = on("vcan0");
  arguments.bit_rate = "800000";
  EXPECT_NE(problems(arguments).find("bus.bit_rate"), std::string::npos);
}

TEST(Setup, TakesTheLineFromTheDaemonsFile) {
  const ScratchFile file(
      "[bus]\ninterface = \"can3\"\nbit_rate = 250000\n[startup]\nstatus_parameter = 77\n"
      "[sync]\noutput = \"can\"\ncan_identifier = 0x090\n"
      "[[slave]]\nnumber = 2\n[[slave]]\nnumber = 4\nstatus_parameter = 78\n");
  Arguments arguments;
  arguments.config = file.path();
  auto setup = make_setup(arguments);
  ASSERT_TRUE(setup.problems.empty()) << setup.problems[0];
  EXPECT_EQ(setup.interface, "can3");
  EXPECT_EQ(setup.bench.sync_identifier, 0x090u);
  EXPECT_EQ(setup.bench.bit_rate, cansync::BitRate::kbit250);
  ASSERT_EQ(setup.drives.size(), 2u);
  EXPECT_EQ(setup.drives[0].status_parameter, 77);
  EXPECT_EQ(setup.drives[1].status_parameter, 78);

  arguments.interface = "vcan1";
  arguments.slaves = "4";
  setup = make_setup(arguments);
  ASSERT_TRUE(setup.problems.empty()) << setup.problems[0];
  EXPECT_EQ(setup.interface, "vcan1");
  ASSERT_EQ(setup.drives.size(), 1u);

  arguments.slaves = "4-6";
  EXPECT_NE(problems(arguments).find("has no [[slave]] with number 5, 6; allowed: 2, 4"), std::string::npos);
}

TEST(Setup, RefusesFaultsThatOnlyASimulatedLineHas) {
  const ScratchFile file(
      "[[fault]]\nkind = \"silent\"\nslave = 0\n\n[[fault]]\nfrom = 4\nkind = \"corrupted\"\n\n"
      "[[fault]]\nkind = \"late\"\nchannel = \"wrc1\"\ndelay_us = 10\n\n"
      "[[fault]]\nkind = \"late\"\nchannel = \"response\"\ndelay_us = 10\n");
  Arguments arguments = on("vcan0");
  arguments.faults = file.path();
  const auto setup = make_setup(arguments);
  ASSERT_EQ(setup.problems.size(), 2u);
  EXPECT_EQ(setup.problems[0],
            file.path() +
                ":7:8: kind = \"corrupted\": a drive cannot destroy a frame on a real bus; allowed on the "
                "simulated line alone (interface = \"sim\")");
  EXPECT_EQ(setup.problems[1].substr(file.path().size(), 46),
            ":10:8: kind = \"late\": only the master decides ");
}

TEST(Setup, FilesThatCannotBeReadAreNamed) {
  const std::string missing = testing::TempDir() + "cansync_sim_test_missing.toml";
  for (const std::string& path : {missing, testing::TempDir()}) {
    Arguments arguments = on("vcan0");
    arguments.faults = path;
    EXPECT_NE(problems(arguments).find(path), std::string::npos) << problems(arguments);
    arguments = {};
    arguments.config = path;
    EXPECT_NE(problems(arguments).find(path), std::string::npos) << problems(arguments);
  }
}

TEST(CommandLine, IsReadWithoutLookingIntoItsTexts) {
  const auto parse = [](std::vector<const char*> words) {
    words.insert(words.begin(), "cansync-sim");
    return cansync_sim::parse_arguments(static_cast<int>(words.size()), words.data());
  };
  const auto good = parse({"vcan0", "--slaves", "0-3", "--set", "sim.seed=2", "-v"});
  ASSERT_TRUE(std::holds_alternative<Arguments>(good));
  EXPECT_EQ(std::get<Arguments>(good).slaves, "0-3");
  EXPECT_TRUE(std::get<Arguments>(good).verbose);
  const std::vector<std::vector<const char*>> wrong_lines = {{"vcan0", "--nonsense"},
                                                             {"vcan0", "vcan1"},
                                                             {"vcan0", "--slaves"},
                                                             {"vcan0", "--seed", "1", "--seed", "2"}};
  for (const auto& line : wrong_lines) {
    const auto end = parse(line);
    ASSERT_TRUE(std::holds_alternative<cansync_sim::CommandLineEnd>(end)) << line.back();
    EXPECT_TRUE(std::get<cansync_sim::CommandLineEnd>(end).wrong);
    EXPECT_NE(std::get<cansync_sim::CommandLineEnd>(end).text.find("--help"), std::string::npos);
  }
  const auto help = parse({"--help"});
  ASSERT_TRUE(std::holds_alternative<cansync_sim::CommandLineEnd>(help));
  EXPECT_FALSE(std::get<cansync_sim::CommandLineEnd>(help).wrong);
  EXPECT_NE(std::get<cansync_sim::CommandLineEnd>(help).text.find("--faults"), std::string::npos);
}

TEST(Setup, AWrongFaultScriptIsNamedWithItsPlace) {
  const ScratchFile file("[[fault]]\nkind = \"gone\"\n");
  Arguments arguments = on("vcan0");
  arguments.faults = file.path();
  EXPECT_EQ(problems(arguments).substr(0, file.path().size() + 5), file.path() + ":2:8:");
}

}  // namespace
