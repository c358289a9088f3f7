#include <cansync/signals.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

namespace cansync::client {
namespace {

/// What a file of this name with this text says; the file is gone after.
Signals signals_of(const std::string& name, const std::string& text) {
  struct File {
    std::string path;
    ~File() { std::filesystem::remove(path); }
  } file{testing::TempDir() + "/" + std::to_string(getpid()) + name};
  std::ofstream(file.path) << text;
  return Signals::read(file.path);
}

const std::string kTable = R"(
[[message]]
name = "Motor"
identifier = 0x123
length = 4
[[signal]]
message = "Motor"
name = "Speed"
start = 0
length = 16
factor = 0.5
unit = "rpm"
[[signal]]
message = "Motor"
name = "Mode"
start = 16
length = 4
chooses = true
values = ["1 run", "2 stop"]
[[signal]]
message = "Motor"
name = "Load"
start = 24
length = 8
chosen_by = 1
[[signal]]
message = "Motor"
name = "Brake"
start = 24
length = 8
chosen_by = 2
)";

const std::string kDbc =
    "BO_ 291 Motor: 4 X\n SG_ Speed : 0|16@1+ (0.5,0) [0|0] \"rpm\" X\n"
    "BO_ 2565866750 Engine: 8 X\n SG_ Rest : 0|8@1+ (1,0) [0|0] \"%\" X\n SG_ Ratio : 8|8@1+ (1,0) [0|0] \"\" X\n";

TEST(Signals, FramesAreNamedByATableAndByADbcFile) {
  const std::array<std::uint8_t, 4> data = {0x10, 0x01, 0x01, 0x07};  // 16#0110 * 0.5
  const auto table = signals_of("motor.toml", kTable).decode(0x123, false, data);
  ASSERT_TRUE(table);
  EXPECT_EQ(table->name, "Motor");
  ASSERT_EQ(table->signals.size(), 3u);
  EXPECT_EQ(table->signals[0].unit, "rpm");
  EXPECT_DOUBLE_EQ(table->signals[0].value, 136.0);
  EXPECT_EQ(table->signals[1].word, "run");
  EXPECT_EQ(table->signals[2].name, "Load");
  const Signals dbc = signals_of("motor.dbc", kDbc);
  EXPECT_DOUBLE_EQ(dbc.decode(0x123, false, data)->signals.at(0).value, 136.0);
  EXPECT_FALSE(dbc.decode(0x123, true, data));
}

TEST(Signals, AGroupOfAnySourceAndWhatIsNotAvailable) {
  const Signals names = signals_of("engine.dbc", kDbc);  // 16#18F004FE: group 16#F004 of source 254
  const std::array<std::uint8_t, 8> data = {0xFF, 12};
  const auto engine = names.decode_group(0xF004, 0x21, data);
  ASSERT_TRUE(engine);
  EXPECT_EQ(engine->signals.at(0).word, "not available");
  EXPECT_TRUE(std::isnan(engine->signals.at(0).value));
  EXPECT_DOUBLE_EQ(engine->signals.at(1).value, 12.0);
  EXPECT_FALSE(names.decode_group(0xF005, 0x21, data));
}

TEST(Signals, BytesOfNamesAndUnits) {
  const Signals names = signals_of("motor.toml", kTable);
  const EncodedMessage motor = names.encode("Motor", {{"Speed", 136.0}, {"Mode", "run"}, {"Load", 7.0}});
  EXPECT_EQ(motor.identifier, 0x123u);
  EXPECT_FALSE(motor.extended);
  EXPECT_EQ(motor.data, (std::vector<std::uint8_t>{0x10, 0x01, 0x01, 0x07}));
  EXPECT_EQ(names.encode("Motor", {{"Brake", 9.0}}, 0xFF).data,
            (std::vector<std::uint8_t>{0xFF, 0xFF, 0xF2, 9}))
      << "its multiplexor is set with it";
}

TEST(Signals, WhatTheFileDoesNotAllowIsRefused) {
  const Signals names = signals_of(
      "limits.dbc", "BO_ 1 A: 8 X\n SG_ S : 0|16@1- (0.1,0) [-100|100] \"V\" X\nVAL_ 1 S 3000 \"all\" ;\n");
  EXPECT_EQ(names.encode("A", {{"S", 100.0}}).data.at(0), 0xE8);
  EXPECT_EQ(names.encode("A", {{"S", "all"}}).data.at(0), 0xB8) << "a name of the file is allowed by it";
  for (const double value : {100.1, -100.1})
    EXPECT_THROW((void)names.encode("A", {{"S", value}}), SignalError) << value;
}

TEST(Signals, WhatIsLeftOutOfADbcFileIsSaid) {
  const Signals names =
      signals_of("part.dbc", "BO_ 1 A: 8 X\n SG_ S 0|8\n SG_ T : 0|8@1+ (1,0) [0|0] \"\" X\n");
  ASSERT_EQ(names.remarks().size(), 1u);
  EXPECT_NE(names.remarks()[0].find("part.dbc:2:8: "), std::string::npos) << names.remarks()[0];
  EXPECT_EQ(names.decode(1, false, std::vector<std::uint8_t>{7}).value().signals.at(0).name, "T");
  EXPECT_TRUE(signals_of("motor.toml", kTable).remarks().empty());
}

TEST(Signals, WhatCannotBeIsRefusedWithWhatIsAllowed) {
  const Signals names = signals_of("motor.toml", kTable);
  const auto refusal = [](auto&& act) {
    try {
      act();
    } catch (const SignalError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const auto of = [&](const std::string& message, const std::map<std::string, Signals::Setting>& settings) {
    return refusal([&] { (void)names.encode(message, settings); });
  };
  EXPECT_NE(of("Moter", {}).find("allowed: Motor"), std::string::npos);
  EXPECT_NE(of("Motor", {{"Sped", 1.0}}).find("Speed, Mode, Load, Brake"), std::string::npos);
  EXPECT_NE(of("Motor", {{"Speed", 40000.0}}).find("0..32767.5 rpm"), std::string::npos);
  EXPECT_NE(of("Motor", {{"Mode", "fly"}}).find("'run', 'stop'"), std::string::npos);
  EXPECT_NE(of("Motor", {{"Load", 1.0}, {"Brake", 1.0}}).find("with the others"), std::string::npos);
  EXPECT_NE(of("Motor", {{"Load", 1.0}, {"Mode", "stop"}}).find("with the others"), std::string::npos);
  EXPECT_NE(refusal([] { (void)Signals::read("/nowhere.dbc"); }).find("cannot be read"), std::string::npos);
  EXPECT_NE(refusal([] { (void)signals_of("bad.dbc", "SG_ S 0|8\n"); }).find("no message"),
            std::string::npos);
  EXPECT_NE(refusal([] { (void)signals_of("bad.toml", "[x]\n"); }).find("[[message]]"), std::string::npos);
}

}  // namespace
}  // namespace cansync::client
