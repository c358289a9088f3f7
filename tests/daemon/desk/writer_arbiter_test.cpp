#include "daemon/desk/writer_arbiter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace cansyncd {
namespace {

using Claim = WriterArbiter::Claim;

TopicWriter writer(WriterHandle handle, std::int32_t strength, std::uint8_t key = 0) {
  TopicWriter out{handle, {}, {"writer " + std::to_string(handle), strength}};
  out.key.fill(key);
  return out;
}

/// What happens to one of the programs.
enum class Step { writes, ends };

constexpr std::size_t kPrograms = 3;
using Strengths = std::array<std::int32_t, kPrograms>;
using Handles = std::array<WriterHandle, kPrograms>;

struct Happens {
  Step step;
  std::size_t program;
};

/// Whose samples were taken, one for each step: the program, or -1.
using Taken = std::vector<int>;

/// As a gate does it.
Taken play(const std::vector<Happens>& steps, const Strengths& strengths, const Handles& handles) {
  WriterArbiter arbiter("it");
  Taken taken;
  for (const Happens& happens : steps) {
    const TopicWriter who = writer(handles[happens.program], strengths[happens.program]);
    taken.push_back(-1);
    if (happens.step == Step::ends) {
      arbiter.forget(who.handle);
      if (arbiter.owner().handle == who.handle) arbiter.free();
      continue;
    }
    const Claim claim = arbiter.claim(who.handle, who.identity.strength);
    if (claim == Claim::waits) {
      (void)arbiter.refuse(who);
      continue;
    }
    if (claim != Claim::keeps) arbiter.give(who);
    taken.back() = static_cast<int>(happens.program);
  }
  return taken;
}

/// What the rule says, without a thought of handles: it is written once more from the words of the document.
Taken expected(const std::vector<Happens>& steps, const Strengths& strengths) {
  int owner = -1;
  Taken taken;
  for (const Happens& happens : steps) {
    const int who = static_cast<int>(happens.program);
    taken.push_back(-1);
    if (happens.step == Step::ends) {
      if (owner == who) owner = -1;
    } else if (owner == -1 || strengths[happens.program] > strengths[static_cast<std::size_t>(owner)]) {
      owner = who;
    }
    if (happens.step == Step::writes && owner == who) taken.back() = who;
  }
  return taken;
}

/// Every course of so many steps.
template <class Visit>
void every_course(std::size_t length, std::vector<Happens>& course, const Visit& visit) {
  if (course.size() == length) return visit(course);
  for (std::size_t program = 0; program < kPrograms; ++program) {
    for (const Step step : {Step::writes, Step::ends}) {
      course.push_back({step, program});
      every_course(length, course, visit);
      course.pop_back();
    }
  }
}

// 6 orders of handles, 5 relations of strengths, 7776 courses of 5 steps.
TEST(WriterArbiter, EveryOrderOfHandlesAndOfSamplesComesToTheSame) {
  constexpr std::size_t kSteps = 5;
  const Strengths relations[] = {{1, 1, 1}, {1, 1, 2}, {1, 2, 2}, {2, 1, 1}, {1, 2, 3}};
  Handles handles = {1, 2, 3};
  std::size_t courses = 0;
  do {
    for (const Strengths& strengths : relations) {
      std::vector<Happens> course;
      every_course(kSteps, course, [&](const std::vector<Happens>& steps) {
        ++courses;
        ASSERT_EQ(play(steps, strengths, handles), expected(steps, strengths));
      });
    }
  } while (std::next_permutation(handles.begin(), handles.end()));
  EXPECT_EQ(courses, 6u * 5u * 7776u);
}

TEST(WriterArbiter, AnEqualWriterIsToldOfOnceAndCounted) {
  WriterArbiter arbiter("the reference values of telegram 1");
  arbiter.give(writer(7, 1));
  const std::string told = arbiter.refuse(writer(2, 1));
  EXPECT_NE(told.find("writer 2 (strength 1) waits for the reference values of telegram 1"),
            std::string::npos)
      << told;
  EXPECT_NE(told.find("writer 7 (strength 1) has"), std::string::npos) << told;
  EXPECT_EQ(arbiter.refuse(writer(2, 1)), "");
  EXPECT_EQ(arbiter.refused(), 2u);
  EXPECT_EQ(arbiter.waiting(), "writer 2");
  EXPECT_NE(arbiter.refused_reason().find("writer 7 has the reference values of telegram 1 with strength 1"),
            std::string::npos)
      << arbiter.refused_reason();
  // It has given up: it waits no more, and is told of when it comes again.
  arbiter.forget(2);
  EXPECT_EQ(arbiter.waiting(), "");
  EXPECT_NE(arbiter.refuse(writer(2, 1)), "");
}

TEST(WriterArbiter, OneWhoHasItDoesNotWaitForIt) {
  WriterArbiter arbiter("it");
  arbiter.give(writer(1, 1));
  (void)arbiter.refuse(writer(2, 1));
  arbiter.free();
  ASSERT_EQ(arbiter.claim(2, 1), Claim::begins);
  arbiter.give(writer(2, 1));
  EXPECT_EQ(arbiter.waiting(), "");
  EXPECT_EQ(arbiter.claim(1, 1), Claim::waits) << "also for the one before";
}

TEST(WriterArbiter, WritersThatWaitAreBoundedAndThoseBeyondWaitTheSame) {
  WriterArbiter arbiter("it");
  arbiter.give(writer(1, 5));
  std::size_t told = 0;
  constexpr std::size_t kFlood = 1000;
  for (WriterHandle handle = 2; handle < 2 + kFlood; ++handle) {
    EXPECT_EQ(arbiter.claim(handle, 5), Claim::waits);
    if (!arbiter.refuse(writer(handle, 5)).empty()) ++told;
  }
  EXPECT_EQ(told, WriterArbiter::kMostWaiting + 1) << "those that are named, and once that there are more";
  EXPECT_EQ(arbiter.refused(), kFlood);
  arbiter.forget_if([](WriterHandle handle) { return handle == 2; });
  EXPECT_NE(arbiter.refuse(writer(9000, 5)).find("writer 9000"), std::string::npos) << "there is room again";
}

TEST(WriterArbiter, AKeyThatNobodyWritesAnyMoreEndsItsWaitingAlone) {
  WriterArbiter arbiter("it");
  arbiter.give(writer(1, 1, 1));
  (void)arbiter.refuse(writer(2, 1, 2));
  (void)arbiter.refuse(writer(3, 1, 3));
  arbiter.forget_key(writer(2, 1, 2).key);
  EXPECT_EQ(arbiter.waiting(), "writer 3");
  EXPECT_EQ(arbiter.owner().handle, 1u);
}

}  // namespace
}  // namespace cansyncd
