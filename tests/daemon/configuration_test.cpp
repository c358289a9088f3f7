// Configuration files whatever their protocol: which one reads a file, and what is shipped and documented of
// all.
#include "daemon/configuration.h"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "daemon/bus/socketcan_line.h"
#include "daemon/protocols.h"

namespace cansyncd {
namespace {

namespace fs = std::filesystem;

std::string content(const fs::path& path) {
  std::ostringstream out;
  out << std::ifstream(path).rdbuf();
  return out.str();
}

/// A protocol that takes every file, and tells by its bus that it did.
template <char name>
LoadedConfig load(const config::Source& /*source*/, std::span<const std::string> /*overrides*/) {
  LoadedConfig loaded;
  loaded.daemon.bus.name = name;
  return loaded;
}
const config::Table& no_options() {
  static const config::Table none;
  return none;
}
constexpr config::DocumentHeads kBreadHeads = {"b", "b", "b"};
constexpr config::DocumentHeads kCakeHeads = {"c", "c", "c"};
constexpr ProtocolInfo kBread = {"bread", no_options, load<'b'>, &kBreadHeads};
constexpr ProtocolInfo kCake = {"cake-2", no_options, load<'c'>, &kCakeHeads};
constexpr std::array<const ProtocolInfo*, 2> kBakery = {&kBread, &kCake};

class ProtocolOfAFile : public testing::Test {
 protected:
  ProtocolOfAFile() {
    std::string name = (fs::temp_directory_path() / "cansyncd-test-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~ProtocolOfAFile() override {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }

  LoadedConfig load(const std::string& text, const std::vector<std::string>& overrides = {}) const {
    std::ofstream(folder_ / "f.toml") << text;
    return load_configuration((folder_ / "f.toml").string(), overrides, kBakery);
  }
  /// The problems, with the file's folder left out.
  std::string problems(const std::string& text, const std::vector<std::string>& overrides = {}) const {
    std::string out = config::problems_text(load(text, overrides).problems);
    const std::string folder = folder_.string() + "/";
    if (out.starts_with(folder)) out.erase(0, folder.size());
    return out;
  }

  fs::path folder_;
};

TEST_F(ProtocolOfAFile, IsTheFirstUnlessTheFileOrTheCommandLineNamesAnother) {
  EXPECT_EQ(load("").daemon.bus.name, "b");
  EXPECT_EQ(load("[bus]\nname = \"x\"\n[oven]\nheat = 3\n").daemon.bus.name, "b");
  EXPECT_EQ(load("[bus]\nprotocol = \"cake-2\"\n[oven]\nheat = 3\n").daemon.bus.name, "c");
  EXPECT_EQ(load("", {"bus.name=x", "bus.protocol=cake-2"}).daemon.bus.name, "c");
  EXPECT_EQ(load("[bus]\nprotocol = \"cake-2\"\n", {"bus.protocol=bread"}).daemon.bus.name, "b");
}

TEST_F(ProtocolOfAFile, OfAWrongNameTheErrorListsAll) {
  EXPECT_EQ(problems("[bus]\nprotocol = \"pie\"\n[oven]\nheat = 3\n"),
            "f.toml:2:12: bus.protocol: found \"pie\"; allowed: \"bread\" or \"cake-2\"\n");
  EXPECT_EQ(problems("[bus]\nprotocol = 3\n"),
            "f.toml:2:12: bus.protocol: found 3; allowed: \"bread\" or \"cake-2\"\n");
  EXPECT_EQ(problems("", {"bus.protocol=pie"}),
            "--set bus.protocol=pie: bus.protocol: found \"pie\"; allowed: \"bread\" or \"cake-2\"\n");
}

TEST_F(ProtocolOfAFile, ThatCannotBeReadIsToldByTheFirst) {
  EXPECT_EQ(load("[bus\n").daemon.bus.name, "b");
  EXPECT_EQ(load_configuration("/no/such/file", {}, kBakery).daemon.bus.name, "b");
}

/// What is wrong with two files together, each with the daemon's part given.
std::string together(const DaemonConfig& first, const DaemonConfig& second) {
  std::array<LoadedConfig, 2> files;
  files[0].path = "a.toml";
  files[0].daemon = first;
  files[1].path = "b.toml";
  files[1].daemon = second;
  return config::problems_text(check_together(files));
}

TEST(FilesOfOneProcess, HaveNothingTogetherThatOneBusCanHaveAlone) {
  DaemonConfig first;
  first.bus = {.name = "can0", .kind = BusKind::socketcan, .interface = "can0"};
  first.dds.partition = "can0";
  DaemonConfig second = first;
  second.bus.interface = "can1";
  EXPECT_EQ(together(first, second),
            "b.toml: bus.name: can0 in DDS domain 0 is that of a.toml, too; clients could not tell the two "
            "apart: each bus needs a name of its own\n");
  second.dds.domain = 3;
  EXPECT_EQ(together(first, second), "");
  second = first;
  second.dds.partition = "can1";
  EXPECT_EQ(together(first, second),
            "b.toml: bus.interface: can0 is that of a.toml, too; one interface is one bus, with one file\n");
  first.bus.kind = second.bus.kind = BusKind::simulated;
  EXPECT_EQ(together(first, second), "");
  first.metrics.file = second.metrics.file = "/m";
  first.sim.trace = second.sim.trace = "/t";
  EXPECT_EQ(together(first, second),
            "b.toml: metrics.file: /m is that of a.toml, too; each bus writes a file of its own\n"
            "b.toml: sim.trace: /t is that of a.toml, too; each bus writes a file of its own\n");
}

/// Several adapters of one kind may have one serial number.
TEST_F(ProtocolOfAFile, APinOfTwoAdaptersThatAreThereIsToldWithItsPlace) {
  const std::string path = (folder_ / "pin.toml").string();
  std::ofstream(path) << "[bus]\ninterface = \"can0\"\nadapter = \"serial=0001\"\n[[slave]]\nnumber = 0\n";
  const std::array<LoadedConfig, 1> files{load_configuration(path, {}, protocols())};
  EXPECT_EQ(config::problems_text(files.front().problems), "");
  can::Adapter adapter;
  adapter.serial = {'0', '0', '0', '1'};
  std::vector<can::InterfaceAdapter> there{{"can0", adapter}};
  EXPECT_EQ(config::problems_text(check_adapters(files, there)), "") << "one";
  there.push_back({"can1", adapter});
  EXPECT_EQ(config::problems_text(check_adapters(files, there)),
            path +
                ":3:11: bus.adapter: found \"serial=0001\", which the adapters of can0 and can1 have; "
                "allowed: what only one has, such as a channel or the path of its port, too\n");
  there.back().adapter.serial = {'2'};
  EXPECT_EQ(config::problems_text(check_adapters(files, there)), "") << "another one";
}

TEST(PrintedConfiguration, IsOfTheChosenProtocolAndOfAllInTheDocuments) {
  EXPECT_EQ(print_default_config({}, kBakery), "b");
  EXPECT_EQ(print_default_config(std::vector<std::string>{"bus.protocol=cake-2"}, kBakery), "c");
  EXPECT_THROW((void)print_default_config(std::vector<std::string>{"bus.protocol=pie"}, kBakery),
               std::runtime_error);
  EXPECT_EQ(print_options_markdown(kBakery), "bc");
  EXPECT_EQ(print_options_man(kBakery), "bc");
}

TEST(ShippedConfiguration, EveryFileIsValid) {
  for (const auto& entry : fs::directory_iterator(CANSYNC_SOURCE_DIR "/config")) {
    if (entry.path().extension() != ".toml") continue;
    EXPECT_EQ(problems_text(load_configuration(entry.path().string(), {}, protocols()).problems), "")
        << entry.path();
  }
}

TEST_F(ProtocolOfAFile, SectionsThatItDoesNotHaveAreRefusedWithTheirPlace) {
  for (const ProtocolInfo* protocol : protocols()) {
    const fs::path file = folder_ / "strange.toml";
    std::ofstream(file) << "[bus]\nprotocol = \"" << protocol->name << "\"\n[strange]\nthing = 1\n";
    EXPECT_TRUE(problems_text(load_configuration(file.string(), {}, protocols()).problems)
                    .starts_with(file.string() + ":3:2: strange: no such section; allowed: [bus], "))
        << protocol->name;
  }
}

TEST(ShippedConfiguration, EachProtocolHasItsNameAsTheFirstOption) {
  for (const ProtocolInfo* protocol : protocols()) {
    const config::Option& first = protocol->options().options().front();
    EXPECT_EQ(first.key, "bus.protocol");
    EXPECT_EQ(first.choices, protocol->name);
  }
}

/// Where a frame may lose the bus to another node's at any time, one-shot mode would lose it for good.
TEST_F(ProtocolOfAFile, OneShotModeIsAdvisedOnlyWhereFramesHaveTheirSlots) {
  can::LinkFacts facts;
  facts.present = facts.is_can = true;
  facts.one_shot = false;
  const auto advice = [&](const std::string& protocol) {
    const fs::path file = folder_ / "advice.toml";
    std::ofstream(file) << "[bus]\nprotocol = \"" << protocol << "\"\ninterface = \"can0\"\n";
    return one_shot_advice(load_configuration(file.string(), {}, protocols()).daemon.bus, facts);
  };
  EXPECT_NE(advice("cansync-master"), "");
  EXPECT_EQ(advice("j1939"), "");
  EXPECT_EQ(advice("layer2"), "");
}

TEST(ShippedConfiguration, TheDefaultFileIsWhatTheProgramPrints) {
  EXPECT_EQ(content(CANSYNC_SOURCE_DIR "/config/cansync.toml"), print_default_config({}, protocols()))
      << "run: cansyncd --print-default-config > config/cansync.toml";
}

TEST(ShippedConfiguration, TheOptionListIsWhatTheProgramPrints) {
  EXPECT_EQ(content(CANSYNC_SOURCE_DIR "/docs/configuration.md"), print_options_markdown(protocols()))
      << "run: cansyncd --print-options-markdown > docs/configuration.md";
}

TEST(ShippedConfiguration, TheOptionsOfTheManPageAreWhatTheProgramPrints) {
  EXPECT_EQ(content(CANSYNC_SOURCE_DIR "/docs/man/cansync.toml.5.d/50-options.mdoc"),
            print_options_man(protocols()))
      << "run: cansyncd --print-options-man > docs/man/cansync.toml.5.d/50-options.mdoc";
}

}  // namespace
}  // namespace cansyncd
