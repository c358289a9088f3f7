#include "cli/cansync/reference_effect.h"

#include <gtest/gtest.h>

#include <cstdio>

namespace cansync::cli {
namespace {

constexpr const char* kOwnProcess = "process 12 on host cab";
constexpr const char* kOwnWriter = "'cansync' (cansync, process 12 on host cab)";
constexpr const char* kOtherWriter = "'plc' (plc, process 123 on host cab)";

template <std::size_t N>
void put_chars(char (&out)[N], const char* text) {
  std::snprintf(out, N, "%s", text);
}

client::MasterStatus given_by(const char* writer, std::int32_t strength,
                              std::uint16_t state = kActiveMaster) {
  client::MasterStatus status{};
  status.option_status = state;
  put_chars(status.reference_release[0].writer, writer);
  status.reference_release[0].strength = strength;
  status.reference_release[0].writer_guid[0] = 1;
  return status;
}

client::Event writer_event(const char* code, const std::string& text) {
  client::Event event{};
  put_chars(event.code, code);
  put_chars(event.text, text.c_str());
  return event;
}

Telegrams first_telegram() {
  Telegrams telegrams{};
  telegrams[0].valid = 1;
  return telegrams;
}

TEST(ReferenceEffect, AnotherWriterIsNamedOnceWithTheStrengthThatTakesOver) {
  const Telegrams telegrams = first_telegram();
  ReferenceEffect effect(telegrams, 1, kOwnProcess);
  const std::string told = effect.look(given_by(kOtherWriter, 1));
  EXPECT_NE(told.find(kOtherWriter), std::string::npos) << told;
  EXPECT_NE(told.find("have no effect while it gives them; --take-over or --strength 2 takes over"),
            std::string::npos)
      << told;
  EXPECT_EQ(effect.look(given_by(kOtherWriter, 1)), "") << "told already";
  EXPECT_NE(effect.without_effect().find(kOtherWriter), std::string::npos) << effect.without_effect();
}

TEST(GivenByAnother, AnEqualOrStrongerWriterKeepsItAndAStrongerOneOfOursDoesNot) {
  const client::MasterStatus status = given_by(kOtherWriter, 3);
  for (const std::int32_t strength : {1, 3}) {
    const std::string told = given_by_another(0, status, strength, "nothing is given");
    EXPECT_NE(told.find("nothing is given; --take-over or --strength 4 takes over"), std::string::npos)
        << told;
  }
  EXPECT_EQ(given_by_another(0, status, 4, "nothing is given"), "");
  EXPECT_EQ(given_by_another(1, status, 1, "nothing is given"), "") << "nobody has the other telegram";
  EXPECT_EQ(strength_to_take_over(first_telegram(), status, 1), 4);
  EXPECT_EQ(strength_to_take_over(first_telegram(), status, 9), 9);
}

// No strength takes over from the lead axis of a cluster.
TEST(GivenByAnother, WhatNoProgramMayGiveIsRefusedWithoutAStrength) {
  client::MasterStatus status = given_by("the lead axis", 0);
  status.reference_release[0].writer_guid[0] = 0;
  const std::string told = given_by_another(0, status, 100, "nothing is given");
  EXPECT_NE(told.find("no program may"), std::string::npos) << told;
  EXPECT_EQ(told.find("--strength"), std::string::npos) << told;
}

TEST(ReferenceEffect, TheOwnWriterHasAnEffectInActiveOperationAlone) {
  const Telegrams telegrams = first_telegram();
  ReferenceEffect effect(telegrams, 1, kOwnProcess);
  EXPECT_EQ(effect.look(given_by(kOwnWriter, 1, 0x0003)), "");
  EXPECT_NE(effect.without_effect().find("not in run"), std::string::npos) << effect.without_effect();
  EXPECT_EQ(effect.look(given_by(kOwnWriter, 1)), "");
  EXPECT_TRUE(effect.heard());
  EXPECT_EQ(effect.without_effect(), "");
}

TEST(ReferenceEffect, AnEventThatNamesThisProcessFirstIsEnough) {
  const Telegrams telegrams = first_telegram();
  const std::string own = kOwnWriter;
  for (const char* code : {"reference_writer_began", "reference_writer_taken_over"}) {
    ReferenceEffect effect(telegrams, 1, kOwnProcess);
    effect.take(writer_event(code, own + " (strength 1) gives the reference values of telegram 1"));
    EXPECT_EQ(effect.look(given_by(kOtherWriter, 1)), "") << "the status is older";
    EXPECT_TRUE(effect.heard());
    EXPECT_EQ(effect.without_effect(), "");
  }
  ReferenceEffect effect(telegrams, 1, kOwnProcess);
  effect.take(
      writer_event("reference_writer_taken_over",
                   std::string(kOtherWriter) + " (strength 3) has taken over from " + own + " (strength 1)"));
  effect.take(writer_event("reference_writer_lost", own + " (strength 1) is gone"));
  static_cast<void>(effect.look(given_by(kOtherWriter, 3)));
  EXPECT_FALSE(effect.heard());
  EXPECT_NE(effect.without_effect(), "");
}

// A script that gives values for a moment must not be told that they had none because the daemon's word was
// late.
TEST(ReferenceEffect, WhatIsNotKnownIsNoFailure) {
  const Telegrams telegrams = first_telegram();
  ReferenceEffect effect(telegrams, 1, kOwnProcess);
  EXPECT_EQ(effect.look(given_by("", 0)), "");
  EXPECT_FALSE(effect.heard());
  EXPECT_EQ(effect.without_effect(), "");
}

TEST(ReferenceEffect, EachTelegramIsLookedAtForItself) {
  Telegrams telegrams = first_telegram();
  telegrams[1].valid = 1;
  ReferenceEffect effect(telegrams, 1, kOwnProcess);
  client::MasterStatus status = given_by(kOwnWriter, 1);
  put_chars(status.reference_release[1].writer, kOtherWriter);
  status.reference_release[1].strength = 5;
  status.reference_release[1].writer_guid[0] = 1;
  const std::string told = effect.look(status);
  EXPECT_EQ(told.find("telegram 1"), std::string::npos) << told;
  EXPECT_NE(told.find("telegram 2 is given by"), std::string::npos) << told;
  EXPECT_NE(effect.without_effect().find("telegram 2"), std::string::npos);
}

TEST(ReferenceEffect, ARefusalIsTheReason) {
  const Telegrams telegrams = first_telegram();
  ReferenceEffect effect(telegrams, 1, kOwnProcess);
  const std::string refused = "reference values of telegram 1 are refused: read-only";
  effect.take(writer_event("reference_refused", refused));
  static_cast<void>(effect.look(given_by("", 0)));
  EXPECT_EQ(effect.without_effect(), refused);
}

TEST(ReferenceEffect, TelegramsThatAreNotGivenAreNotLookedAt) {
  Telegrams telegrams{};
  telegrams[1].valid = 1;
  ReferenceEffect effect(telegrams, 1, kOwnProcess);
  EXPECT_EQ(effect.look(given_by(kOtherWriter, 1)), "");
}

}  // namespace
}  // namespace cansync::cli
