// The invariants can fail: each broken variant of the product is seen by the invariant that is there for it.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "course.h"
#include "invariants.h"
#include "mutants.h"
#include "small/small_course.h"

namespace cansyncd::campaign {
namespace {

constexpr std::uint64_t kMostSchedules = 60;

class BrokenVariant : public testing::TestWithParam<Mutant> {};

TEST_P(BrokenVariant, IsCaught) {
  const Mutant& mutant = GetParam();
  std::string seen;
  for (std::uint64_t seed = 1; seed <= kMostSchedules; ++seed) {
    const Plan plan = draw_plan(seed, 200);
    const std::unique_ptr<Tamper> tamper = mutant.make(plan);
    const Verdict verdict = Course(plan, tamper.get(), {}).run();
    if (!verdict.violation) continue;
    if (verdict.violation->invariant == mutant.caught_by) return;
    seen += " " + std::to_string(seed) + ": " + verdict.violation->invariant + ": " +
            verdict.violation->what + "\n";
  }
  FAIL() << mutant.name << " is not seen by " << mutant.caught_by << " in " << kMostSchedules
         << " schedules; others that saw it:\n"
         << seen;
}

template <class Kind>
std::string name_of(const testing::TestParamInfo<Kind>& mutant) {
  std::string name = mutant.param.name;
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}
INSTANTIATE_TEST_SUITE_P(All, BrokenVariant, testing::ValuesIn(mutants().begin(), mutants().end()),
                         name_of<Mutant>);

TEST(Invariants, EachIsShownToFailByABrokenVariant) {
  for (const Invariant& invariant : invariants()) {
    EXPECT_TRUE(std::any_of(mutants().begin(), mutants().end(), [&](const Mutant& mutant) {
      return std::string(mutant.caught_by) == invariant.name;
    })) << invariant.name;
  }
}

class BrokenVariantOfSmall : public testing::TestWithParam<SmallMutant> {};

TEST_P(BrokenVariantOfSmall, IsCaught) {
  const SmallMutant& mutant = GetParam();
  std::string seen;
  for (std::uint64_t seed = 1; seed <= kMostSchedules; ++seed) {
    const std::unique_ptr<Tamper> tamper = mutant.make();
    const SmallVerdict verdict = mutant.course->play(seed, tamper.get(), {});
    if (!verdict.violation) continue;
    if (verdict.violation->invariant == mutant.caught_by) return;
    seen += " " + std::to_string(seed) + ": " + verdict.violation->invariant + ": " +
            verdict.violation->what + "\n";
  }
  FAIL() << mutant.name << " is not seen by " << mutant.caught_by << " in " << kMostSchedules
         << " schedules; others that saw it:\n"
         << seen;
}

INSTANTIATE_TEST_SUITE_P(All, BrokenVariantOfSmall,
                         testing::ValuesIn(small_mutants().begin(), small_mutants().end()),
                         name_of<SmallMutant>);

TEST(Invariants, OfSmallCoursesEachIsShownToFailByABrokenVariant) {
  for (const SmallCourse* course : small_courses()) {
    for (const char* invariant : course->invariants) {
      EXPECT_TRUE(std::any_of(small_mutants().begin(), small_mutants().end(), [&](const SmallMutant& mutant) {
        return mutant.course == course && std::string(mutant.caught_by) == invariant;
      })) << invariant;
    }
  }
}

TEST(Campaign, TheSameSeedGivesTheSameCourseToTheBit) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Plan plan = draw_plan(seed, 0);
    const Verdict first = Course(plan, nullptr, {}).run();
    const Verdict second = Course(plan, nullptr, [](const std::string&) {}).run();
    EXPECT_EQ(first.digest, second.digest) << seed;
    EXPECT_EQ(first.intervals, second.intervals) << seed;
  }
}

}  // namespace
}  // namespace cansyncd::campaign
