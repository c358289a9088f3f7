// Address claiming after SAE J1939-81: claims, keeps, loses, takes another, cannot; all cases.
#include <gtest/gtest.h>

#include "j1939/node_rig.h"

namespace j1939::test {
namespace {

const can::Frame kAskAll = frame(0x18EAFFFE, {0x00, 0xEE, 0x00});
/// "Cannot claim": the claim with the null address.
const can::Frame kCannot = own_claim(254);

NodeSettings fixed() {
  NodeSettings settings = settings_at(kOwn);
  NameFields fields = kFields;
  fields.arbitrary_address = false;
  settings.claim.name = compose(fields);
  return settings;
}
can::Frame fixed_claim(Address address) {
  can::Frame claim = own_claim(address);
  claim.data[7] = 0;
  return claim;
}

TEST(AddressClaim, AsksAllThenClaimsAndHasTheAddressAfter250Ms) {
  NodeRig rig;
  EXPECT_EQ(rig.pump(), (std::vector{kAskAll, own_claim(kOwn)}));
  EXPECT_EQ(rig.node.claim().state(), ClaimState::claiming);
  EXPECT_EQ(rig.node.next_deadline(), rig.now + milliseconds(250));
  EXPECT_TRUE(rig.run(milliseconds(250) - Time{1}).empty());
  EXPECT_FALSE(rig.node.claim().address());
  (void)rig.run(Time{1});
  EXPECT_EQ(rig.node.claim().state(), ClaimState::claimed);
  EXPECT_EQ(rig.node.claim().address(), kOwn);
  EXPECT_EQ(rig.node.next_deadline(), Time::max());
}

TEST(AddressClaim, The250MsCountFromTheClaimOnTheBus) {
  NodeRig rig;
  rig.echoes = false;
  (void)rig.pump();
  (void)rig.run(std::chrono::seconds(10));
  EXPECT_EQ(rig.node.claim().state(), ClaimState::claiming) << "nobody acknowledged it";
  rig.node.echo(kAskAll, rig.now);
  rig.node.echo(own_claim(kOwn), rig.now);
  (void)rig.run(milliseconds(250));
  EXPECT_EQ(rig.node.claim().state(), ClaimState::claimed);
}

NodeSettings asking() {
  NodeSettings settings = settings_at(kOwn);
  settings.claim.ask_time = milliseconds(250);
  settings.claim.first_other = 0x80;
  settings.claim.last_other = 0x83;
  return settings;
}

TEST(AddressClaim, BegunAnewTheAddressOfANodeThatHasLeftIsFree) {
  NodeSettings settings = asking();
  settings.claim.name = fixed().claim.name;
  NodeRig rig(settings);
  EXPECT_EQ(rig.pump(), std::vector{kAskAll});
  (void)rig.hear_claim(kOwn, kWeaker);
  EXPECT_EQ(rig.run(milliseconds(403)), std::vector{fixed_claim(254)});
  EXPECT_EQ(rig.node.claim().state(), ClaimState::cannot_claim);
  rig.node.controller_emptied();
  EXPECT_EQ(rig.pump(), std::vector{kAskAll});
  EXPECT_EQ(rig.run(milliseconds(250)), std::vector{fixed_claim(kOwn)});
}

TEST(AddressClaim, BegunAnewAfterAnotherOfItsNameHasLeft) {
  NodeRig rig(asking());
  (void)rig.pump();
  (void)rig.hear_claim(0x90, settings_at(kOwn).claim.name);
  (void)rig.run(milliseconds(403));
  EXPECT_TRUE(rig.node.claim().name_twice());
  rig.node.controller_emptied();
  (void)rig.pump();
  EXPECT_EQ(rig.run(milliseconds(250)), std::vector{own_claim(kOwn)});
  EXPECT_FALSE(rig.node.claim().name_twice());
}

TEST(AddressClaim, AsksFirstAndClaimsWhatNobodyAnswersFor) {
  NodeRig rig(asking());
  EXPECT_EQ(rig.pump(), std::vector{kAskAll});
  EXPECT_FALSE(rig.node.claim().wanted());
  EXPECT_EQ(rig.node.next_deadline(), rig.now + milliseconds(250));
  EXPECT_TRUE(rig.run(milliseconds(250) - Time{1}).empty());
  EXPECT_EQ(rig.run(Time{1}), std::vector{own_claim(kOwn)});
  (void)rig.run(milliseconds(250));
  EXPECT_EQ(rig.node.claim().address(), kOwn);
}

TEST(AddressClaim, LeavesItsAddressToWhoAnswersHoweverWeak) {
  NodeRig rig(asking());
  (void)rig.pump();
  EXPECT_TRUE(rig.hear_claim(kOwn, kWeaker).empty());
  EXPECT_EQ(rig.run(milliseconds(250)), std::vector{own_claim(0x81)});
  (void)rig.run(milliseconds(250));
  EXPECT_EQ(rig.node.claim().address(), 0x81);
  EXPECT_EQ(rig.node.claim().losses(), 0u);
}

TEST(AddressClaim, WithoutAnotherAddressItCannotClaimWhatAnotherHas) {
  NodeSettings settings = fixed();
  settings.claim.ask_time = milliseconds(250);
  NodeRig rig(settings);
  (void)rig.pump();
  (void)rig.hear_claim(kOwn, kWeaker);
  EXPECT_EQ(rig.run(milliseconds(500)), std::vector{fixed_claim(254)});
  EXPECT_EQ(rig.node.claim().state(), ClaimState::cannot_claim);
}

TEST(AddressClaim, WhileItAsksItAnswersNoRequestAndKnowsANodeOfItsOwnName) {
  NodeRig rig(asking());
  (void)rig.pump();
  EXPECT_TRUE(rig.hear(kAskAll).empty());
  (void)rig.hear_claim(0x99, compose(kFields));
  EXPECT_EQ(rig.run(milliseconds(500)), std::vector{kCannot});
  EXPECT_TRUE(rig.node.claim().name_twice());
}

TEST(AddressClaim, TheTimeToAskCountsFromTheRequestOnTheBus) {
  NodeRig rig(asking());
  rig.echoes = false;
  EXPECT_EQ(rig.pump(), std::vector{kAskAll});
  EXPECT_TRUE(rig.run(std::chrono::seconds(10)).empty());
  rig.node.echo(kAskAll, rig.now);
  EXPECT_EQ(rig.run(milliseconds(250)), std::vector{own_claim(kOwn)});
}

TEST(AddressClaim, WithoutAnAddressItOnlyListens) {
  NodeSettings settings = settings_at(kOwn);
  settings.claim.preferred.reset();
  NodeRig rig(settings);
  EXPECT_TRUE(rig.run(std::chrono::seconds(1)).empty());
  EXPECT_EQ(rig.node.claim().state(), ClaimState::listening);
  rig.node.controller_emptied();
  EXPECT_TRUE(rig.run(std::chrono::seconds(1)).empty());
  EXPECT_TRUE(rig.hear(frame(0x18EAFF21, {0x00, 0xEE, 0x00})).empty());
  EXPECT_EQ(rig.node.submit({.id = 1, .number = 0xFEF1, .timeout = milliseconds(5)}, rig.now),
            Refusal::no_address);
}

TEST(AddressClaim, KeepsItAgainstAWeakerName) {
  for (const bool early : {true, false}) {
    NodeRig rig;
    if (early) {
      (void)rig.pump();
    } else {
      rig.claimed();
    }
    EXPECT_EQ(rig.hear_claim(kOwn, kWeaker), std::vector{own_claim(kOwn)});
    (void)rig.run(milliseconds(250));
    EXPECT_EQ(rig.node.claim().address(), kOwn);
    EXPECT_EQ(rig.node.claim().losses(), 0u);
  }
}

TEST(AddressClaim, LosesItToAStrongerNameAndTakesAnotherThatIsFree) {
  NodeSettings settings = settings_at(kOwn);
  settings.claim.first_other = 0x80;
  settings.claim.last_other = 0x83;
  NodeRig rig(settings);
  rig.claimed();
  (void)rig.hear_claim(0x81, 0x20);
  EXPECT_EQ(rig.hear_claim(kOwn, kStronger), std::vector{own_claim(0x82)});
  EXPECT_EQ(rig.node.claim().state(), ClaimState::claiming);
  EXPECT_FALSE(rig.node.claim().address());
  (void)rig.run(milliseconds(250));
  EXPECT_EQ(rig.node.claim().address(), 0x82);
  EXPECT_EQ(rig.node.claim().losses(), 1u);
  // And when all are taken, it says that it cannot.
  EXPECT_EQ(rig.hear_claim(0x82, 0x21), std::vector{own_claim(0x83)});
  (void)rig.hear_claim(0x83, 0x22);
  EXPECT_EQ(rig.node.claim().state(), ClaimState::cannot_claim);
  EXPECT_EQ(rig.run(milliseconds(153)), std::vector{kCannot});
}

TEST(AddressClaim, WithoutArbitraryAddressALossMeansThatItCannot) {
  NodeRig rig(fixed());
  rig.claimed();
  const Time lost = rig.now;
  EXPECT_TRUE(rig.hear_claim(kOwn, kStronger).empty()) << "not in the same instant as all others";
  EXPECT_EQ(rig.node.claim().state(), ClaimState::cannot_claim);
  EXPECT_GT(rig.node.next_deadline(), lost);
  EXPECT_LE(rig.node.next_deadline(), lost + milliseconds(153));
  EXPECT_EQ(rig.run(milliseconds(153)), std::vector{fixed_claim(254)});
  EXPECT_EQ(rig.node.submit({.id = 1, .number = 0xFEF1, .timeout = milliseconds(5)}, rig.now),
            Refusal::no_address);
}

TEST(AddressClaim, AnswersARequestForTheAddressClaimed) {
  NodeRig rig;
  rig.claimed();
  EXPECT_EQ(rig.hear(frame(0x18EAFF21, {0x00, 0xEE, 0x00})), std::vector{own_claim(kOwn)});
  EXPECT_EQ(rig.hear(frame(0x18EA8021, {0x00, 0xEE, 0x00})), std::vector{own_claim(kOwn)});
  EXPECT_EQ(rig.hear(frame(0x18EAFFFE, {0x00, 0xEE, 0x00})), std::vector{own_claim(kOwn)});
  EXPECT_TRUE(rig.hear(frame(0x18EA7021, {0x00, 0xEE, 0x00})).empty()) << "another is meant";
}

TEST(AddressClaim, WhoCannotClaimAnswersSoAfterItsDelay) {
  NodeRig rig(fixed());
  rig.claimed();
  (void)rig.hear_claim(kOwn, kStronger);
  (void)rig.run(std::chrono::seconds(1));
  EXPECT_TRUE(rig.hear(frame(0x18EAFF21, {0x00, 0xEE, 0x00})).empty());
  EXPECT_EQ(rig.run(milliseconds(153)), std::vector{fixed_claim(254)});
}

TEST(AddressClaim, ManyRequestsAndClaimsAtOnceGetOneAnswer) {
  NodeRig rig;
  rig.claimed();
  for (int i = 0; i < 100; ++i) {
    (void)rig.node.receive(frame(0x18EAFF21, {0x00, 0xEE, 0x00}), rig.now);
    (void)rig.node.receive(frame(0x18EEFF80, {255, 255, 255, 255, 255, 255, 255, 255}), rig.now);
  }
  EXPECT_EQ(rig.pump(), std::vector{own_claim(kOwn)});
}

TEST(AddressClaim, ACommandMovesItToAnotherAddress) {
  NodeRig rig;
  rig.claimed();
  // Commanded address: NAME and new address, nine bytes, as a broadcast of two packets.
  (void)rig.hear(frame(0x18ECFF21, {32, 9, 0, 2, 255, 0xD8, 0xFE, 0x00}));
  (void)rig.hear(frame(0x18EBFF21, {1, 0x45, 0x23, 0xE1, 0x00, 0x00, 0x80, 0x00}));
  EXPECT_EQ(rig.hear(frame(0x18EBFF21, {2, 0x80, 0x90, 255, 255, 255, 255, 255})),
            std::vector{own_claim(0x90)});
  (void)rig.run(milliseconds(250));
  EXPECT_EQ(rig.node.claim().address(), 0x90);
}

TEST(AddressClaim, ACommandForAnotherNameOrOneThatIsNotAllowedDoesNothing) {
  for (const bool other_name : {true, false}) {
    NodeSettings settings = settings_at(kOwn);
    settings.claim.takes_commands = other_name;
    NodeRig rig(settings);
    rig.claimed();
    (void)rig.hear(frame(0x18ECFF21, {32, 9, 0, 2, 255, 0xD8, 0xFE, 0x00}));
    (void)rig.hear(frame(0x18EBFF21, {1, other_name ? 0x46 : 0x45, 0x23, 0xE1, 0x00, 0x00, 0x80, 0x00}));
    EXPECT_TRUE(rig.hear(frame(0x18EBFF21, {2, 0x80, 0x90, 255, 255, 255, 255, 255})).empty());
    EXPECT_EQ(rig.node.claim().address(), kOwn);
  }
}

TEST(AddressClaim, ACommandGivesOneThatCannotClaimAnAddress) {
  NodeRig rig(fixed());
  rig.claimed();
  (void)rig.hear_claim(kOwn, kStronger);
  (void)rig.hear(frame(0x18ECFF21, {32, 9, 0, 2, 255, 0xD8, 0xFE, 0x00}));
  (void)rig.hear(frame(0x18EBFF21, {1, 0x45, 0x23, 0xE1, 0x00, 0x00, 0x80, 0x00}));
  EXPECT_EQ(rig.hear(frame(0x18EBFF21, {2, 0x00, 0x90, 255, 255, 255, 255, 255})),
            std::vector{fixed_claim(0x90)});
}

TEST(AddressClaim, AnotherWithTheSameNameEndsTheClaimInsteadOfADuelWithoutEnd) {
  NodeRig rig;
  rig.claimed();
  EXPECT_TRUE(rig.hear_claim(kOwn, compose(kFields)).empty());
  EXPECT_TRUE(rig.node.claim().name_twice());
  EXPECT_EQ(rig.node.claim().state(), ClaimState::cannot_claim);
  EXPECT_EQ(rig.run(milliseconds(153)), std::vector{kCannot});
  EXPECT_TRUE(rig.hear_claim(kOwn, compose(kFields)).empty());
  // Started again with an identity of its own, both have an address.
  NodeSettings settings = settings_at(kOwn);
  NameFields fields = kFields;
  ++fields.identity;
  settings.claim.name = compose(fields);
  settings.claim.first_other = settings.claim.last_other = 0x90;
  NodeRig again(settings);
  again.claimed();
  (void)again.hear_claim(kOwn, compose(kFields));
  (void)again.run(milliseconds(250));
  EXPECT_FALSE(again.node.claim().name_twice());
  EXPECT_EQ(again.node.claim().address(), 0x90) << "the lower identity keeps the address that both want";
}

TEST(AddressClaim, AnotherWithTheSameNameThatCannotClaimTakesNothingAway) {
  NodeRig rig;
  rig.claimed();
  EXPECT_TRUE(rig.hear_claim(254, compose(kFields)).empty());
  EXPECT_EQ(rig.node.claim().state(), ClaimState::claimed);
}

TEST(AddressClaim, WhoSendsWithItsAddressIsAnsweredByTheClaimAtMostEvery5S) {
  NodeRig rig;
  rig.claimed();
  EXPECT_EQ(rig.hear(frame(0x18FEF180, {1})), std::vector{own_claim(kOwn)});
  EXPECT_TRUE(rig.hear(frame(0x18FEF180, {1})).empty());
  (void)rig.run(std::chrono::seconds(5));
  EXPECT_EQ(rig.hear(frame(0x18FEF180, {1})), std::vector{own_claim(kOwn)});
  EXPECT_EQ(rig.node.claim().intruders(), 3u);
  (void)rig.run(std::chrono::seconds(5));
  EXPECT_TRUE(rig.hear(frame(0x18FEF121, {1})).empty()) << "it has an address of its own now";
  EXPECT_EQ(rig.node.claim().intruders(), 3u);
}

TEST(AddressClaim, AfterTheControllerWasEmptiedItClaimsTheSameAddressAnew) {
  NodeRig rig;
  rig.claimed();
  (void)rig.hear_claim(kOwn, kStronger);  // now at 0x81... or another
  (void)rig.run(milliseconds(250));
  const auto address = rig.node.claim().address();
  ASSERT_TRUE(address);
  rig.node.controller_emptied();
  EXPECT_FALSE(rig.node.claim().address());
  EXPECT_EQ(rig.pump(), (std::vector{kAskAll, own_claim(*address)}));
}

TEST(ClaimTable, ANameStandsAtOneAddress) {
  ClaimTable table;
  table.claimed(5, 77);
  EXPECT_EQ(table.at(5), Name{77});
  const auto revision = table.revision();
  table.claimed(5, 77);
  EXPECT_EQ(table.revision(), revision) << "nothing new";
  table.claimed(6, 77);
  EXPECT_FALSE(table.at(5));
  EXPECT_EQ(table.at(6), Name{77});
  table.claimed(254, 77);
  EXPECT_FALSE(table.at(6));
  EXPECT_GT(table.revision(), revision);
  EXPECT_FALSE(table.at(255));
}

}  // namespace
}  // namespace j1939::test
