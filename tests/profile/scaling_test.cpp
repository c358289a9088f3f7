// Raw values, values in engineering units, and what may be written.
#include "profile/scaling.h"

#include <gtest/gtest.h>

#include "profile_text.h"

namespace profile {
namespace {

std::string text_of(const std::variant<std::uint32_t, Refused>& result) {
  const auto* refused = std::get_if<Refused>(&result);
  return refused != nullptr ? refused->text : std::to_string(std::get<std::uint32_t>(result));
}

TEST(ProfileScaling, ShowsAsManyDecimalsAsAStepHas) {
  const Parameter tenths = parameter_of(one_parameter("signed = true\nfactor = 0.1\nunit = \"%\"\n"));
  EXPECT_EQ(scaled_text(tenths, 3), "0.3");
  EXPECT_EQ(scaled_text(tenths, -1000), "-100.0");
  EXPECT_EQ(scaled_text(tenths, 0), "0.0");
  EXPECT_EQ(scaled_text(parameter_of(one_parameter("factor = 10\n")), 42), "420");
  EXPECT_EQ(scaled_text(parameter_of(one_parameter("offset = 0.25\n")), 1), "1.25");
  EXPECT_EQ(scaled_text(parameter_of(one_parameter("factor = -0.1\n")), 0), "0.0");
}

TEST(ProfileScaling, EveryTextGivesItsRawValueBack) {
  for (const char* scaling : {"factor = 0.1\n", "factor = 1.52587890625e-05\n", "factor = 0.333333333333\n",
                              "factor = -7.1\noffset = 273.15\n", "factor = 1e9\n"}) {
    const Parameter parameter =
        parameter_of(one_parameter(std::string("signed = true\n") + scaling, "doubleword"));
    for (const std::int64_t number : {0L, 1L, -1L, 99L, 65535L, -123456789L, 2147483647L, -2147483648L}) {
      const std::string text = scaled_text(parameter, number);
      const auto raw = to_raw(parameter, text);
      ASSERT_TRUE(std::holds_alternative<std::uint32_t>(raw)) << scaling << text;
      EXPECT_EQ(raw_number(parameter, std::get<std::uint32_t>(raw)), number) << scaling << text;
    }
  }
}

TEST(ProfileScaling, RawNumbersAreSignedWhenTheProfileSaysSo) {
  EXPECT_EQ(raw_number(parameter_of(one_parameter("")), 0xFFFF), 65535);
  EXPECT_EQ(raw_number(parameter_of(one_parameter("signed = true\n")), 0xFFFF), -1);
  EXPECT_EQ(raw_number(parameter_of(one_parameter("", "doubleword")), 0xFFFFFFFF), 4294967295);
  EXPECT_EQ(raw_number(parameter_of(one_parameter("signed = true\n", "doubleword")), 0x80000000),
            -2147483648);
}

TEST(ProfileScaling, TakesTheNearestRawValue) {
  const Parameter tenths = parameter_of(one_parameter("signed = true\nfactor = 0.1\nunit = \"%\"\n"));
  EXPECT_EQ(text_of(to_raw(tenths, "1.26")), "13");
  EXPECT_EQ(text_of(to_raw(tenths, "-0.1")), "65535");
  EXPECT_EQ(text_of(to_raw(tenths, "+1e2")), "1000");
}

TEST(ProfileScaling, RefusesWhatIsNoNumberOrDoesNotFit) {
  const Parameter tenths = parameter_of(one_parameter("signed = true\nfactor = 0.1\nunit = \"%\"\n"));
  for (const char* text : {"", "x", "1,5", "0x10", "1.5%", "nan", "inf"}) {
    EXPECT_EQ(text_of(to_raw(tenths, text)), "speed-limit (parameter 12): found '" + std::string(text) +
                                                 "'; allowed: a number in %, such as 12.5 or -3e2");
  }
  EXPECT_EQ(text_of(to_raw(tenths, "3276.8")),
            "speed-limit (parameter 12): found 3276.8 %; allowed: -3276.8..3276.7 % (all that a word holds)");
}

TEST(ProfileScaling, LimitsAreCheckedBeforeAWrite) {
  const Parameter limited =
      parameter_of(one_parameter("factor = 0.1\nunit = \"ms\"\nminimum = 1\nmaximum = 1000\n"));
  EXPECT_EQ(limits_text(limited), "1.0..1000.0");
  EXPECT_FALSE(write_problem(limited, 10));
  EXPECT_FALSE(write_problem(limited, 10000));
  EXPECT_EQ(write_problem(limited, 9)->text,
            "speed-limit (parameter 12): found 0.9 ms (raw 9); allowed: 1.0..1000.0 ms");
  EXPECT_EQ(write_problem(limited, 10001)->text,
            "speed-limit (parameter 12): found 1000.1 ms (raw 10001); allowed: 1.0..1000.0 ms");
  EXPECT_EQ(write_problem(limited, 65536)->text,
            "speed-limit (parameter 12): found raw value 65536; allowed: 0..65535, it is a word");
  EXPECT_EQ(limits_text(parameter_of(one_parameter(""))), "");
}

TEST(ProfileScaling, AccessIsCheckedBeforeAWrite) {
  Parameter parameter = parameter_of(one_parameter(""));
  EXPECT_FALSE(read_problem(parameter));
  parameter.access = Access::read_only;
  EXPECT_EQ(write_problem(parameter, 1)->text,
            "speed-limit (parameter 12): read-only by the profile; it cannot be written");
  EXPECT_FALSE(read_problem(parameter));
  parameter.access = Access::none;
  EXPECT_EQ(write_problem(parameter, 1)->text, read_problem(parameter)->text);
}

}  // namespace
}  // namespace profile
