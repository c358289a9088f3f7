// Limits of parameters against each other, the format and the scaling.
#include <gtest/gtest.h>

#include "profile_text.h"

namespace profile {
namespace {

TEST(ProfileLimits, AreTheFormatsWithoutAny) {
  EXPECT_EQ(parameter_of(one_parameter("")).maximum, 65535);
  EXPECT_EQ(parameter_of(one_parameter("signed = true\n")).minimum, -32768);
  EXPECT_EQ(parameter_of(one_parameter("signed = true\n", "doubleword")).maximum, 2147483647);
  EXPECT_FALSE(parameter_of(one_parameter("")).limited);
}

TEST(ProfileLimits, OneAloneIsEnough) {
  const Parameter parameter = parameter_of(one_parameter("minimum = 5\n"));
  EXPECT_TRUE(parameter.limited);
  EXPECT_EQ(parameter.minimum, 5);
  EXPECT_EQ(parameter.maximum, 65535);
}

TEST(ProfileLimits, AreInTheUnit) {
  const Parameter parameter =
      parameter_of(one_parameter("factor = 0.1\noffset = -20\nminimum = -20\nmaximum = 80.5\n"));
  EXPECT_EQ(parameter.minimum, 0);
  EXPECT_EQ(parameter.maximum, 1005);
}

TEST(ProfileLimits, ThatLieBetweenTwoStepsKeepInside) {
  const Parameter parameter = parameter_of(one_parameter("factor = 3\nminimum = 4\nmaximum = 10\n"));
  EXPECT_EQ(parameter.minimum, 2);
  EXPECT_EQ(parameter.maximum, 3);
}

TEST(ProfileLimits, ANegativeFactorTurnsThemAround) {
  const Parameter parameter =
      parameter_of(one_parameter("signed = true\nfactor = -0.5\nminimum = -10\nmaximum = 100\n"));
  EXPECT_EQ(parameter.minimum, -200);
  EXPECT_EQ(parameter.maximum, 20);
}

TEST(ProfileLimits, AgainstEachOther) {
  EXPECT_EQ(problems_of(one_parameter("minimum = 5\nmaximum = 4\n")),
            "f:7:11: parameter.minimum: found 5, over the maximum 4; allowed: at most the maximum\n");
  EXPECT_EQ(problems_of(one_parameter("factor = 10\nminimum = 1\nmaximum = 9\n")),
            "f:8:11: parameter.minimum: no value lies between 1 and 9 with factor 10 and offset 0\n");
}

TEST(ProfileLimits, AgainstTheFormat) {
  EXPECT_EQ(problems_of(one_parameter("factor = 0.1\nmaximum = 6553.6\n")),
            "f:8:11: parameter.maximum: found 6553.6, which is raw 65536; allowed with format \"word\": "
            "0.0..6553.5\n");
  EXPECT_EQ(problems_of(one_parameter("minimum = -1\n", "doubleword")),
            "f:7:11: parameter.minimum: found -1, which is raw -1; allowed with format \"doubleword\": "
            "0..4294967295\n");
  EXPECT_EQ(problems_of(one_parameter("signed = true\nminimum = -32769\n")),
            "f:8:11: parameter.minimum: found -32769, which is raw -32769; allowed with format \"word\", "
            "signed: -32768..32767\n");
}

}  // namespace
}  // namespace profile
