#include "dds/ask/daemon_choice.h"

#include <gtest/gtest.h>

#include <chrono>
#include <vector>

namespace gateway::dds {
namespace {

using std::chrono::milliseconds;
using View = DaemonChoice::View;

constexpr DaemonChoice::Place kHere = 11;
constexpr DaemonChoice::Place kThere = 12;
constexpr DaemonIdentity kOne = {1};
constexpr DaemonIdentity kTwo = {2};

/// A choice in virtual time.
class Choice : public ::testing::Test {
 protected:
  void look(milliseconds later = milliseconds(0)) {
    now_ += later;
    choice.look(now_, matched);
  }
  /// So long nobody but `speakers` is heard, each once a second.
  void pass(milliseconds time, const std::vector<std::pair<DaemonChoice::Place, DaemonIdentity>>& speakers) {
    constexpr milliseconds kStep(500);
    for (milliseconds gone(0); gone < time; gone += kStep) {
      for (const auto& [place, identity] : speakers) choice.heard(place, identity);
      look(kStep);
    }
  }
  void connect() {
    matched = {kHere};
    choice.heard(kHere, kOne);
    look();
  }

  DaemonChoice choice;
  std::vector<DaemonChoice::Place> matched;
  DaemonChoice::Clock::time_point now_;
};

TEST_F(Choice, NobodyIsAskedBeforeADaemonToldItsIdentity) {
  look();
  EXPECT_EQ(choice.view(), View::none);
  matched = {kHere};
  look();
  EXPECT_EQ(choice.view(), View::none);
  choice.heard(kHere, kOne);
  look();
  EXPECT_EQ(choice.view(), View::one);
  EXPECT_EQ(choice.daemon(), kOne);
  EXPECT_TRUE(choice.may_answer(kOne));
  EXPECT_FALSE(choice.to_be_told());
}

TEST_F(Choice, OneThatIsAloneMayBeSilentAsLongAsItIsThere) {
  connect();
  for (int i = 0; i < 20; ++i) look(milliseconds(500));
  EXPECT_EQ(choice.view(), View::one);
  matched = {};
  look();
  EXPECT_EQ(choice.view(), View::none);
  EXPECT_FALSE(choice.may_answer(kOne));
  EXPECT_EQ(choice.daemon(), kOne) << "whom requests were for";
}

TEST_F(Choice, OneThatWasKilledIsFollowedByItsNextStartWhenItHasBeenSilent) {
  connect();
  matched = {kHere, kThere};  // its death is not known yet
  choice.heard(kThere, kTwo);
  look(milliseconds(500));
  EXPECT_EQ(choice.view(), View::unsure);
  EXPECT_TRUE(choice.may_answer(kOne));
  pass(milliseconds(1500), {{kThere, kTwo}});
  EXPECT_EQ(choice.view(), View::unsure) << "2 s since it was heard";
  pass(milliseconds(500), {{kThere, kTwo}});
  EXPECT_EQ(choice.view(), View::one);
  EXPECT_EQ(choice.daemon(), kTwo);
  EXPECT_FALSE(choice.may_answer(kOne));
  EXPECT_TRUE(choice.to_be_told());
  choice.program_told();
  EXPECT_FALSE(choice.to_be_told());
}

TEST_F(Choice, OneThatHasLeftIsFollowedAtOnce) {
  connect();
  matched = {kThere};
  choice.heard(kThere, kTwo);
  look();
  EXPECT_EQ(choice.view(), View::one);
  EXPECT_EQ(choice.daemon(), kTwo);
  EXPECT_TRUE(choice.to_be_told());
}

// A line that is set up anew: another start behind the same participant.
TEST_F(Choice, AnotherStartAtTheSamePlaceAnswersNothingThatWasForTheOneBefore) {
  connect();
  choice.heard(kHere, kTwo);
  look();
  EXPECT_EQ(choice.view(), View::one);
  EXPECT_EQ(choice.daemon(), kTwo);
  EXPECT_TRUE(choice.may_answer(kTwo));
  EXPECT_FALSE(choice.may_answer(kOne));
  EXPECT_TRUE(choice.to_be_told());
}

TEST_F(Choice, TwoLiveWhenTheOneBeforeIsHeardAgain) {
  connect();
  matched = {kHere, kThere};
  choice.heard(kThere, kTwo);
  choice.heard(kHere, kOne);
  look();
  EXPECT_EQ(choice.view(), View::several);
  EXPECT_EQ(choice.living(), (std::vector<DaemonChoice::Place>{kHere, kThere}));
  EXPECT_TRUE(choice.may_answer(kOne));
  // One of them dies: the other one is silent for nobody.
  pass(milliseconds(2000), {{kHere, kOne}});
  EXPECT_EQ(choice.view(), View::several);
  pass(milliseconds(1000), {{kHere, kOne}});
  EXPECT_EQ(choice.view(), View::one);
  EXPECT_EQ(choice.daemon(), kOne);
  EXPECT_FALSE(choice.to_be_told()) << "it is the one that was asked before";
}

TEST_F(Choice, OneThatCountedAsDeadIsHeardAgain) {
  connect();
  matched = {kHere, kThere};
  pass(milliseconds(3000), {{kThere, kTwo}});
  ASSERT_EQ(choice.daemon(), kTwo);
  choice.heard(kHere, kOne);
  look();
  EXPECT_EQ(choice.view(), View::several);
}

TEST_F(Choice, WhoWasSuspendedHasHeardNobody) {
  connect();
  matched = {kHere, kThere};
  choice.heard(kThere, kTwo);
  look(std::chrono::hours(1));
  EXPECT_EQ(choice.view(), View::unsure);
}

TEST_F(Choice, WhenNobodyIsHeardNobodyCountsAsDead) {
  connect();
  matched = {kHere, kThere};
  choice.heard(kThere, kTwo);
  choice.heard(kHere, kOne);
  for (int i = 0; i < 20; ++i) look(milliseconds(500));
  EXPECT_EQ(choice.view(), View::several);
}

TEST_F(Choice, WhatTheProgramWasToldHoldsForTheNextStartAlone) {
  connect();
  matched = {};
  look();
  choice.program_told();  // nobody is there
  matched = {kThere};
  choice.heard(kThere, kTwo);
  look();
  EXPECT_FALSE(choice.to_be_told());
  matched = {kHere};
  choice.heard(kHere, kOne);
  look();
  EXPECT_TRUE(choice.to_be_told());
  // Another one, of which it hears before it is chosen.
  choice.program_told_of({3});
  matched = {kThere};
  choice.heard(kThere, {3});
  look();
  EXPECT_FALSE(choice.to_be_told());
}

TEST_F(Choice, AProgramThatHeardOfAnotherStartIsToldThatItIsTheFormerAfterAll) {
  connect();
  choice.program_told_of(kTwo);
  matched = {kHere, kThere};
  choice.heard(kThere, kTwo);
  look();
  matched = {kHere};
  look();
  EXPECT_EQ(choice.daemon(), kOne);
  EXPECT_TRUE(choice.to_be_told());
  choice.program_told();
  EXPECT_FALSE(choice.to_be_told());
}

TEST_F(Choice, WhatWasNotToldIsToldAlsoAfterTheNextDaemonHasGoneForAWhile) {
  connect();
  matched = {kThere};
  choice.heard(kThere, kTwo);
  look();
  matched = {};
  look();
  EXPECT_FALSE(choice.to_be_told()) << "there is nobody to tell of";
  matched = {kThere};
  choice.heard(kThere, kTwo);
  look();
  EXPECT_TRUE(choice.to_be_told());
}

TEST(Addressee, ARequestIsForTheStartThatItNames) {
  EXPECT_EQ(addressee(kOne, kOne), Addressee::this_daemon);
  EXPECT_EQ(addressee(kTwo, kOne), Addressee::another_daemon);
  EXPECT_EQ(addressee({}, kOne), Addressee::nobody);
}

}  // namespace
}  // namespace gateway::dds
