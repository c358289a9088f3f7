// Differences of passports, their identity, and what a restore would write.
#include "cli/cansync/passport_compare.h"

#include <gtest/gtest.h>

namespace cansync::cli {
namespace {

using Action = PlanStep::Action;
using profile::Access;
using profile::Identity;

profile::Parameter parameter(std::uint16_t number, Access access = Access::read_write) {
  profile::Parameter made;
  made.number = number;
  made.name = "p" + std::to_string(number);
  made.minimum = 0;
  made.maximum = 100;
  made.limited = true;
  made.access = access;
  return made;
}

/// Parameters 1 and 2 may be written, 3 is read-only, 4 volatile, 5 and 6 are type and serial number.
profile::Profile drive_profile() {
  profile::Profile profile;
  profile.name = "drive";
  profile.hash = "h";
  profile.parameters = {parameter(1),
                        parameter(2),
                        parameter(3, Access::read_only),
                        parameter(4),
                        parameter(5, Access::read_only),
                        parameter(6, Access::read_only)};
  profile.parameters[3].is_volatile = true;
  profile.parameters[4].identity = Identity::type;
  profile.parameters[5].identity = Identity::unit;
  return profile;
}

Passport passport(const std::vector<std::optional<std::uint32_t>>& values) {
  Passport made;
  made.bus = "b";
  made.slave = 1;
  const profile::Profile profile = drive_profile();
  made.profile = profile.name;
  made.profile_hash = profile.hash;
  for (std::size_t i = 0; i < values.size(); ++i) {
    made.entries.push_back(passport_entry(profile.parameters[i], values[i]));
  }
  return made;
}

TEST(PassportDifferences, AreThoseOfWhatIsCompared) {
  const Passport a = passport({1, 2, 3, 4, 5, 6});
  EXPECT_TRUE(differences(a, a).empty());
  EXPECT_TRUE(differences(a, passport({1, 2, 3, 9, 5, 9})).empty()) << "volatile, serial number";
  const Passport b = passport({1, 7, 8, 4, 9, 6});
  const auto found = differences(a, b);
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[0].a->raw, 2U);
  EXPECT_EQ(found[0].b->raw, 7U);
  EXPECT_EQ(found[1].any().number, 3);
  EXPECT_EQ(found[2].any().number, 5);
}

TEST(PassportDifferences, AMissingParameterAndAMissingValueAreSome) {
  const Passport a = passport({1, 2});
  const Passport b = passport({std::nullopt, 2, 3});
  const auto found = differences(a, b);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_FALSE(found[0].b->raw);
  EXPECT_EQ(found[1].a, nullptr);
}

TEST(PassportIdentity, IsBusSlaveProfileAndType) {
  const Passport file = passport({1, 2, 3, 4, 5, 6});
  Passport drive = passport({7, 7, 7, 7, 5, 7});
  EXPECT_TRUE(identity_problems(file, drive).empty());
  drive.bus = "c";
  drive.slave = 2;
  drive.profile = "other";
  drive.entries[4] = passport_entry(drive_profile().parameters[4], 50);
  EXPECT_EQ(identity_problems(file, drive),
            (std::vector<std::string>{"bus: b in the file, c here", "slave: 1 in the file, 2 here",
                                      "profile: drive in the file, other here",
                                      "p5 (parameter 5): 5 in the file, 50 here"}));
  drive = passport({1, 2, 3, 4});
  EXPECT_EQ(identity_problems(file, drive),
            (std::vector<std::string>{"p5 (parameter 5): 5 in the file, unknown here"}));
}

TEST(RestorePlan, WritesWhatDiffersAndSkipsWhatCannotBeWritten) {
  const Passport file = passport({1, 2, 3, 4, 5, 6});
  const Passport drive = passport({1, 9, 9, 9, 5, 7});
  const RestorePlan plan = plan_restore(file, drive, drive_profile());
  EXPECT_TRUE(plan.problems.empty());
  ASSERT_EQ(plan.steps.size(), 4U) << "1 to 4; not what tells the drive";
  EXPECT_EQ(plan.steps[0].action, Action::right);
  EXPECT_EQ(plan.steps[1].action, Action::write);
  EXPECT_EQ(plan.steps[2].why, "read-only");
  EXPECT_EQ(plan.steps[3].why, "volatile");
  EXPECT_EQ(plan.count(Action::skip), 2U);
}

TEST(RestorePlan, SaysWhatTheFileOrTheProfileDoesNotHave) {
  Passport file = passport({std::nullopt});
  file.entries.push_back(passport_entry(parameter(9), 1));
  const RestorePlan plan = plan_restore(file, passport({1, 2}), drive_profile());
  EXPECT_TRUE(plan.problems.empty());
  ASSERT_EQ(plan.steps.size(), 3U);
  EXPECT_EQ(plan.steps[0].why, "without a value in the file: it could not be read then");
  EXPECT_EQ(plan.steps[1].why, "not in the file");
  EXPECT_EQ(plan.steps[2].why, "not in the profile");
}

TEST(RestorePlan, AnythingWrongIsAProblemBeforeTheFirstWrite) {
  const auto problems = [](const Passport& file, const Passport& drive) {
    return plan_restore(file, drive, drive_profile()).problems;
  };
  const Passport drive = passport({1, 2, 3, 4, 5, 6});
  EXPECT_EQ(problems(passport({1, 101}), drive),
            (std::vector<std::string>{"p2 (parameter 2): found 101 (raw 101); allowed: 0..100"}));
  Passport file = passport({7});
  file.entries[0].name = "other";
  EXPECT_EQ(
      problems(file, drive),
      (std::vector<std::string>{"other (parameter 1) is a word in the file; the profile says: p1, word"}));
  file = passport({7});
  file.entries[0].format = profile::Format::doubleword;
  EXPECT_EQ(problems(file, drive).size(), 1U);
  file = passport({7});
  file.entries[0].value = "8";
  EXPECT_EQ(problems(file, drive),
            (std::vector<std::string>{
                "p1 (parameter 1): found value 8 beside raw 7, which is 7; allowed: both the same"}));
  file.profile_hash = "older";  // its scaling may have been another
  EXPECT_TRUE(problems(file, drive).empty());
  EXPECT_EQ(problems(passport({1, 2}), passport({std::nullopt, 2})),
            (std::vector<std::string>{"p1 (parameter 1) could not be read from the drive"}));
}

}  // namespace
}  // namespace cansync::cli
