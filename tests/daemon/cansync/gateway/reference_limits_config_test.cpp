// Limits of reference values: from the options in the value's unit to numbers, and what is wrong with them.
#include "cansync/config/config_text.h"
#include "cansync/config/reload.h"
#include "daemon/cansync/requests/gateway_requests.h"
#include "daemon/cansync/texts/limit_text.h"

namespace cansyncd {
namespace {

using cansync::ReferenceLimits;

/// A line of which slave 1 gives actual values also without reference values.
constexpr const char* kLine =
    "[process]\npoll_without_reference = true\n"
    "[[slave]]\nnumber = 1\nname = \"infeed\"\n"
    "[[slave.value]]\nnumber = 1\nname = \"place\"\nfactor = 0.5\noffset = 2.0\nunit = \"mm\"\n";

ReferenceLimits limits_of(const std::string& options) {
  return good(std::string(kLine) + "[[reference]]\nnumber = 0\n" + options)
      .master.process.reference_limits[0];
}
std::string problem_of(const std::string& options) {
  return problems_text(from_text("[[reference]]\nnumber = 0\n" + options + kLine).problems);
}

TEST(ReferenceLimitsConfig, WithoutOptionsThereIsNoLimit) {
  EXPECT_FALSE(limits_of("factor = 0.1\n").any());
}

TEST(ReferenceLimitsConfig, LimitsAreNumbersWithinTheScaledOnes) {
  const ReferenceLimits exact = limits_of("factor = 0.1\noffset = -3.0\nminimum = -100.0\nmaximum = 99.9\n");
  EXPECT_EQ(exact.minimum, -970);
  EXPECT_EQ(exact.maximum, 1029) << "(99.9 + 3) / 0.1 without the rest of the division";
  const ReferenceLimits between = limits_of("factor = 2.0\nminimum = -3\nmaximum = 3\nmax_step = 5\n");
  EXPECT_EQ(between.minimum, -1) << "-2 of the unit; -4 would be beyond";
  EXPECT_EQ(between.maximum, 1);
  EXPECT_EQ(between.max_step, 2);
}

TEST(ReferenceLimitsConfig, ANegativeFactorExchangesMinimumAndMaximum) {
  const ReferenceLimits limits =
      limits_of("factor = -0.5\nminimum = -10.0\nmaximum = 20.0\nmax_step = 1.0\n");
  EXPECT_EQ(limits.minimum, -40);
  EXPECT_EQ(limits.maximum, 20);
  EXPECT_EQ(limits.max_step, 2);
  const ReferenceLimits one = limits_of("factor = -0.5\nminimum = -10.0\n");
  EXPECT_EQ(one.minimum, -ReferenceLimits::kNone);
  EXPECT_EQ(one.maximum, 20);
}

TEST(ReferenceLimitsConfig, TheEndsOfTheWidthAreAllowed) {
  const ReferenceLimits all =
      limits_of("minimum = -2147483648\nmaximum = 2147483647\nmax_step = 4294967295\n");
  EXPECT_EQ(all.minimum, INT32_MIN);
  EXPECT_EQ(all.maximum, INT32_MAX);
  EXPECT_EQ(all.max_step, UINT32_MAX);
  EXPECT_EQ(limits_of("signed = false\nminimum = 0\nmaximum = 4294967295\n").maximum, UINT32_MAX);
}

TEST(ReferenceLimitsConfig, StartWithinNamesSlaveAndActualValueByNumberOrName) {
  for (const char* who : {"[1, 1, 0.75]", "[\"infeed\", \"place\", 0.75]"}) {
    const ReferenceLimits limits =
        limits_of("factor = 0.25\noffset = 1.0\nstart_within = " + std::string(who) + "\n");
    ASSERT_TRUE(limits.start_within.has_value());
    EXPECT_EQ(limits.start_within->slave.value(), 1);
    EXPECT_EQ(limits.start_within->value, 1);
    EXPECT_DOUBLE_EQ(limits.start_within->factor, 2.0);
    EXPECT_DOUBLE_EQ(limits.start_within->offset, 4.0);
    EXPECT_DOUBLE_EQ(limits.start_within->distance, 3.0);
  }
}

TEST(ReferenceLimitsConfig, WhatIsWrongHasItsPlaceAndWhatIsAllowed) {
  EXPECT_EQ(problem_of("minimum = 5\nmaximum = 4.5\n"),
            "test.toml:3:11: reference.0.minimum: found 5, and maximum is 4.5; allowed: a minimum up to the "
            "maximum, with a number of the factor between them\n");
  EXPECT_TRUE(
      problem_of("minimum = 0.2\nmaximum = 0.8\n").starts_with("test.toml:3:11: reference.0.minimum: "))
      << "no number between them";
  EXPECT_EQ(
      problem_of("maximum = 2147483648\n"),
      "test.toml:3:11: reference.0.maximum: found 2147483648; allowed: -2147483648..2147483647, which is "
      "what 32 bits with a sign hold with this factor and offset\n");
  EXPECT_EQ(
      problem_of("signed = false\nfactor = 0.5\nminimum = -0.5\n"),
      "test.toml:5:11: reference.0.minimum: found -0.5; allowed: 0..2147483647.5, which is what 32 bits "
      "without a sign hold with this factor and offset\n");
  for (const char* wrong : {"minimum = nan\n", "maximum = inf\n", "max_step = inf\n", "max_step = nan\n"})
    EXPECT_TRUE(problem_of(wrong).starts_with("test.toml:3:1")) << wrong;
  for (const char* wrong : {"max_step = -1\n", "max_step = 0.5\n", "max_step = 4294967296\n"}) {
    EXPECT_NE(problem_of(wrong).find("test.toml:3:12: reference.0.max_step: found "), std::string::npos);
    EXPECT_NE(problem_of(wrong).find("; allowed: 1..4294967295, from one number"), std::string::npos);
  }
}

TEST(ReferenceLimitsConfig, AWordHoldsLess) {
  const std::string word =
      "maximum = 40000\n[process]\npoll_without_reference = true\n"
      "reference_registers_1 = [0x01, 0, 0, 0]\n[[slave]]\nnumber = 1\n";
  const std::string head = "[[reference]]\nnumber = 0\n";
  EXPECT_NE(
      problems_text(from_text(head + word).problems).find("allowed: -32768..32767, which is what 16 bits"),
      std::string::npos);
  EXPECT_EQ(good(head + "signed = false\n" + word).master.process.reference_limits[0].maximum, 40'000);
}

TEST(ReferenceLimitsConfig, StartWithinOfWhatIsNotThereIsRefused) {
  const auto start = [](const char* list) {
    return problem_of("start_within = " + std::string(list) + "\n");
  };
  const std::string place = "test.toml:3:16: reference.0.start_within: found ";
  EXPECT_EQ(start("[2, 1, 5]"), place + "slave 2; allowed: number or name of a configured slave\n");
  EXPECT_EQ(start("[\"outfeed\", 1, 5]"),
            place + "slave \"outfeed\"; allowed: number or name of a configured slave\n");
  EXPECT_EQ(start("[1, \"speed\", 5]"),
            place + "actual value \"speed\"; allowed: 0..7 or the name of an actual value of slave 1\n");
  EXPECT_TRUE(start("[1, 8, 5]").starts_with(place + "actual value 8; allowed: "));
  EXPECT_TRUE(
      start("[1, 2, 5]").starts_with(place + "actual value 2, which the mapping of slave 1 does not "));
  for (const char* no_list : {"5", "[1, 1]", "[1, 1, -1]", "[1, 1, nan]", "[1, 1, \"5\"]", "[1.5, 1, 5]"})
    EXPECT_TRUE(start(no_list).starts_with("test.toml:3:")) << no_list;
}

TEST(ReferenceLimitsConfig, AnActualValueThatNeverComesBeforeAReleaseIsRefused) {
  const std::string reference = "[[reference]]\nnumber = 0\nstart_within = [1, 0, 5]\n";
  const std::string slaves = "[[slave]]\nnumber = 0\n[[slave]]\nnumber = 1\n";
  const auto found = [&](const std::string& process) {
    return problems_text(from_text(reference + slaves + process).problems);
  };
  EXPECT_NE(found("").find("test.toml:3:16: reference.0.start_within: found without "
                           "process.poll_without_reference = true"),
            std::string::npos);
  const std::string polled = "[process]\npoll_without_reference = true\n";
  EXPECT_EQ(found(polled), "");
  EXPECT_EQ(found(polled + "polling_1 = 1\n"), "");
  for (const char* others : {"polling_1 = 0\n", "polling_1 = \"nobody\"\n", "maximum_slave = 0\n"})
    EXPECT_NE(found(polled + others).find("which process.polling_1 does not ask"), std::string::npos)
        << others;
}

TEST(ReferenceLimitsConfig, AReloadGivesTheMasterWhatChanged) {
  const auto file = [](const std::string& options) {
    return from_text(std::string(kLine) + "[[reference]]\nnumber = 3\n" + options);
  };
  const ConfigFile before = file("maximum = 100\n");
  const ConfigReload plan = plan_reload(before, file("maximum = 100\nfactor = 0.5\nmax_step = 2\n"));
  EXPECT_EQ(plan.applied, (std::vector<std::string>{"reference.3.factor", "reference.3.max_step"}));
  EXPECT_TRUE(plan.needs_restart.empty());
  const auto requests = changes(before.config, plan.merged.config);
  ASSERT_EQ(requests.size(), 1U);
  const auto* set = std::get_if<SetReferenceLimits>(requests.data());
  ASSERT_NE(set, nullptr);
  EXPECT_EQ(set->value, 3);
  EXPECT_EQ(set->limits.maximum, 200) << "the same limit with another factor";
  EXPECT_EQ(set->limits.max_step, 4);
}

TEST(ReferenceLimitsConfig, AViolationIsShownInTheUnitWithItsLimit) {
  const Config config = good(
      std::string(kLine) +
      "[[reference]]\nnumber = 0\nname = \"place\"\nunit = \"mm\"\nfactor = -0.1\nminimum = -50\nmax_step = 2\n"
      "start_within = [\"infeed\", \"place\", 5]\n");
  using cansync::LimitKind;
  const auto text = [&](const cansync::LimitViolation& beyond) {
    return limit_denial(beyond, config).reason;
  };
  const auto& limits = config.master.process.reference_limits[0];
  EXPECT_EQ(text({LimitKind::maximum, 0, 510, 0, limits.maximum}),
            "reference value 0 'place': -51 mm is below its minimum -50 mm; write -50 mm or more");
  EXPECT_EQ(
      text({LimitKind::max_step, 0, 121, 100, limits.max_step}),
      "reference value 0 'place': -12.1 mm is more than max_step 2 mm from -10 mm, sent last; begin within "
      "max_step of it, or take the bus to setup and back to run");
  EXPECT_EQ(
      text({LimitKind::start_within, 0, 100, 10, 0}),
      "reference value 0 'place': a release must begin within 5 mm of actual value 1 'place' of slave 1 "
      "'infeed', which is 7 mm; found -10 mm");
  EXPECT_EQ(
      text({LimitKind::start_unknown, 0, 100, 0, 0}),
      "reference value 0 'place': start_within needs actual value 1 'place' of slave 1 'infeed', which has "
      "not been received lately; check that slave and its mapping, then write again");
}

}  // namespace
}  // namespace cansyncd
