#include "cansync/config/dbc.h"

#include <gtest/gtest.h>

#include "cansync/config/dbc_names.h"

namespace cansyncd {
namespace {

TEST(DbcNames, AreIdentifiersOfTheFormat) {
  DbcNames names;
  EXPECT_EQ(names.take("speed"), "speed");
  EXPECT_EQ(names.take("motor speed"), "motor_speed");
  EXPECT_EQ(names.take("2nd"), "_2nd");
  EXPECT_EQ(names.take("\xC3\x96l"), "_l") << "one mark for a character of two bytes";
  EXPECT_EQ(names.take(""), "_");
}

TEST(DbcNames, AreUniqueAndShort) {
  DbcNames names;
  EXPECT_EQ(names.take("a b"), "a_b");
  EXPECT_EQ(names.take("a-b"), "a_b_2");
  EXPECT_EQ(names.take("a_b"), "a_b_3");
  const std::string wanted(40, 'x');
  EXPECT_EQ(names.take(wanted), std::string(32, 'x'));
  EXPECT_EQ(names.take(wanted), std::string(30, 'x') + "_2");
}

TEST(DbcString, IsLatinAndEndsWhereItShould) {
  EXPECT_EQ(dbc_string("mm/s"), "mm/s");
  EXPECT_EQ(dbc_string("\xC2\xB0"
                       "C"),
            "\xB0"
            "C");
  EXPECT_EQ(dbc_string("\xE2\x84\xA6"), "?") << "an ohm sign is not in the character set";
  EXPECT_EQ(dbc_string("a\"b\\c\n"), "a'b/c?");
  EXPECT_EQ(dbc_string("\xC2"), "?") << "broken off";
}

/// A line with one slave, called "drive".
Config one_slave() {
  Config config;
  config.master.slaves[5].configured = true;
  config.master.process.maximum_slave = *cansync::SlaveNumber::from(0);
  config.slaves[5].name = "drive";
  return config;
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Dbc, TelegramsAreAsLongAsTheirMapping) {
  Config config = one_slave();
  config.master.process.full_length = false;
  config.master.process.reference_mapping[0].word = {{{true, false, 0}, {true, true, 0}}};
  config.master.slaves[5].actual_mapping[1] = {};
  const std::string text = dbc_text(config);
  EXPECT_TRUE(has(text, "BO_ 261 WRC1_drive: 4 master\n SG_ value0 : 0|32@1- (1,0)")) << text;
  EXPECT_TRUE(has(text, "BO_ 901 RDC2_drive: 0 drive\n\n")) << "nothing is mapped\n" << text;
}

TEST(Dbc, AWordThatIsSentTwiceHasTwoNames) {
  Config config = one_slave();
  config.master.slaves[5].actual_mapping[0].word = {{{true, false, 2}, {true, false, 2}}};
  const std::string text = dbc_text(config);
  EXPECT_TRUE(has(text, " SG_ value2_low : 0|16@1- ")) << text;
  EXPECT_TRUE(has(text, " SG_ value2_low_2 : 16|16@1- ")) << text;
}

TEST(Dbc, AWordHasASignUnlessTheConfigurationSaysOtherwise) {
  Config config = one_slave();
  config.master.slaves[5].actual_mapping[0].word = {{{true, false, 0}, {true, true, 1}, {true, false, 2}}};
  config.master.slaves[5].actual_mapping[1].word = {
      {{true, true, 5}, {true, false, 5}, {true, false, 6}, {true, true, 6}}};
  config.slaves[5].actual[0] = {"torque", "%", 0.01, 0.0};
  config.slaves[5].actual[2] = {"bits", "", 1.0, 0.0, false};
  config.slaves[5].actual[6].is_signed = false;
  const std::string text = dbc_text(config);
  EXPECT_TRUE(has(text, " SG_ torque_low : 0|16@1- (0.01,0) [-327.68|327.67] ")) << text;
  EXPECT_TRUE(has(text, " SG_ value1_high : 16|16@1- (65536,0) ")) << text;
  EXPECT_TRUE(has(text, " SG_ bits_low : 32|16@1+ (1,0) [0|65535] ")) << text;
  EXPECT_TRUE(has(text, " SG_ value5_high : 0|16@1- ")) << text;
  EXPECT_TRUE(has(text, " SG_ value5_low : 16|16@1+ ")) << "the sign is in the high word\n" << text;
  EXPECT_TRUE(has(text, " SG_ value6 : 32|32@1+ (1,0) [0|4294967295] ")) << text;
}

TEST(Dbc, OfNoSlavesIsStillAFile) {
  const std::string text = dbc_text(Config{});
  EXPECT_TRUE(has(text, "BU_: master\n")) << text;
  EXPECT_TRUE(has(text, " SG_ command : 32|8@1+ (1,0) [0|255] \"\" Vector__XXX\n")) << text;
}

TEST(Dbc, NegativeFactorsHaveTheirRangeInOrder) {
  Config config = one_slave();
  config.slaves[5].actual[0].factor = -1.0;
  EXPECT_TRUE(has(dbc_text(config), "(-1,0) [-2147483647|2147483648]"));
}

}  // namespace
}  // namespace cansyncd
