#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <string_view>
#include <thread>
#include <variant>

#include "support/reference_writer.h"

namespace cansyncd {
namespace {

using cansync::Channel;

TEST(GatewayReferences, ReachTheRealtimeThread) {
  GatewayRig rig;
  ReferenceWriter writer(rig, 0);
  auto sample = values(2, -100);
  sample.from_interval = 1234;
  writer.write(sample);
  const auto update = rig.expect_request<cansync::ReferenceUpdate>();
  EXPECT_EQ(update.channel, Channel::two);
  EXPECT_EQ(update.value[0], static_cast<std::uint32_t>(-100));
  EXPECT_EQ(update.value[3], static_cast<std::uint32_t>(-4));
  EXPECT_EQ(update.valid_mask, 0b1001);
  EXPECT_EQ(update.from_interval, 1234u);
  EXPECT_EQ(update.release_intervals, 20u);
}

TEST(GatewayReferences, AWeakerWriterChangesNothingUntilTheStrongerIsGone) {
  GatewayRig rig;
  auto strong = std::make_optional<ReferenceWriter>(rig, 10);
  strong->write(values(1, 111));
  EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 111u);

  ReferenceWriter weak(rig, 5);
  weak.deliver(values(1, 222));
  // What the stronger one writes after the weaker one's values were delivered is the next that comes through.
  strong->write(values(1, 112));
  EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 112u);

  strong.reset();
  EXPECT_EQ(rig.expect_request<StopRelease>().channel, Channel::one);
  ASSERT_TRUE(event(rig, "reference_writer_lost"));
  weak.write(values(1, 333));
  EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 333u);
}

TEST(GatewayReferences, ReleaseStopsForTheTelegramsOfTheWriterThatLeft) {
  GatewayRig rig;
  ReferenceWriter other(rig, 0);
  other.write(values(2, 1));
  EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().channel, Channel::two);
  {
    ReferenceWriter writer(rig, 0);
    writer.write(values(1, 1));
    EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().channel, Channel::one);
  }
  EXPECT_EQ(rig.expect_request<StopRelease>().channel, Channel::one);
  const auto lost = event(rig, "reference_writer_lost");
  ASSERT_TRUE(lost);
  EXPECT_EQ(lost->severity, gateway_SEVERITY_WARNING);
  EXPECT_NE(gateway::dds::text(lost->text).find("telegram 1"), std::string_view::npos);
  // Telegram 2 goes on.
  other.write(values(2, 2));
  EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 2u);
}

TEST(GatewayReferences, AChangeOfTheNetworkIsALossAndReleasesNothingTwice) {
  GatewayRig rig;
  ReferenceWriter writer(rig, 0);
  writer.write(values(1, 1));
  EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 1u);
  rig.gateway->set_surroundings({"", {"lo", "another address", ""}});
  EXPECT_EQ(rig.expect_request<StopRelease>().channel, Channel::one);
  ASSERT_TRUE(event(rig, "network_joined"));
  ASSERT_TRUE(event(rig, "reference_writer_lost"));
  // The writer finds the new reader in its own time.
  Request request;
  while (!rig.exchange.requests.try_pop(request)) {
    writer.write(values(1, 2));
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  const auto* next = std::get_if<cansync::ReferenceUpdate>(&request);
  ASSERT_NE(next, nullptr);
  EXPECT_EQ(next->value[0], 2u) << "never what was written before";
}

TEST(GatewayReferences, ANetworkThatCannotBeJoinedIsSaidAndEndsNothing) {
  GatewayRig rig;
  ReferenceWriter writer(rig, 0);
  writer.write(values(1, 1));
  EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 1u);
  rig.gateway->set_surroundings({"", {"nosuch0", "7", ""}});
  const auto said = event(rig, "network_lost");
  ASSERT_TRUE(said);
  EXPECT_NE(gateway::dds::text(said->text).find("network interface 'nosuch0' does not exist"),
            std::string_view::npos)
      << said->text;
  EXPECT_TRUE(rig.client.wait_for<gateway_GatewayStatus>([](const auto& status) {
    return gateway::dds::text(status.dds_interface) == "lo" && status.network_reason[0] != 0;
  }));
  writer.write(values(1, 2));
  EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 2u);
}

TEST(GatewayReferences, AWriterThatGivesATelegramUpStopsIt) {
  GatewayRig rig;
  ReferenceWriter writer(rig, 0);
  writer.write(values(1, 1));
  rig.expect_request<cansync::ReferenceUpdate>();
  writer.unregister(values(1, 0));
  EXPECT_EQ(rig.expect_request<StopRelease>().channel, Channel::one);
  // The same writer may take it again.
  writer.write(values(1, 2));
  EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 2u);
}

// Writers of one participant have GUIDs in the order in which they were made.
TEST(GatewayReferences, OfEqualWritersTheFirstKeepsTheTelegramInEveryOrderOfGuids) {
  GatewayRig rig;
  const gateway::dds::Participant participant(rig.places().there);
  std::array<std::unique_ptr<ReferenceWriter>, 3> writers;
  for (auto& writer : writers) writer = std::make_unique<ReferenceWriter>(participant, 1);
  std::array<std::size_t, 3> order = {0, 1, 2};
  do {
    SCOPED_TRACE(testing::PrintToString(order));
    ReferenceWriter& first = *writers[order[0]];
    ReferenceWriter& second = *writers[order[1]];
    ReferenceWriter& third = *writers[order[2]];
    first.write(values(1, 1));
    EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 1u);
    second.deliver(values(1, 2));
    third.deliver(values(1, 3));
    first.write(values(1, 4));
    EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 4u) << "nothing of those that wait";
    first.give_up(1);
    EXPECT_EQ(rig.expect_request<StopRelease>().channel, Channel::one);
    third.write(values(1, 5));
    const auto next = rig.expect_request<cansync::ReferenceUpdate>();
    EXPECT_EQ(next.value[0], 5u) << "whose own next sample comes first, nothing that was written before";
    EXPECT_FALSE(next.takes_over);
    second.deliver(values(1, 6));
    first.deliver(values(1, 7));
    third.write(values(1, 8));
    EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 8u);
    first.give_up(1);
    second.give_up(1);
    third.give_up(1);
    EXPECT_EQ(rig.expect_request<StopRelease>().channel, Channel::one);
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST(GatewayReferences, AnEqualWriterIsToldOfAndSeenInTheStatus) {
  GatewayRig rig;
  ReferenceWriter first(rig.places(), 1, "conveyor");
  first.write(values(1, 1));
  rig.expect_request<cansync::ReferenceUpdate>();
  ReferenceWriter second(rig.places(), 1, "laptop");
  second.write(values(1, 2));
  const auto waits = event(rig, "writer_waits");
  ASSERT_TRUE(waits);
  EXPECT_NE(gateway::dds::text(waits->text).find("'laptop'"), std::string_view::npos) << waits->text;
  const auto status = rig.client.wait_for<cansync_MasterStatus>([](const auto& s) {
    return gateway::dds::text(s.reference_release[0].waiting_writer).find("'laptop'") !=
           std::string_view::npos;
  });
  ASSERT_TRUE(status);
  const cansync_ReferenceRelease& release = status->reference_release[0];
  EXPECT_EQ(release.refused, 1u);
  EXPECT_NE(gateway::dds::text(release.refused_reason).find("'conveyor'"), std::string_view::npos);
  const auto guid = first.guid();
  EXPECT_TRUE(std::equal(guid.begin(), guid.end(), std::begin(release.writer_guid)));
  EXPECT_EQ(rig.exchange.requests.size(), 0u);
}

// Each writer has a key of its own.
TEST(GatewayReferences, AnOwnerThatOnlyUnregistersIsLostAlsoWhileAnotherWaits) {
  GatewayRig rig;
  ReferenceWriter owner(rig, 2);
  owner.write(values(1, 1));
  rig.expect_request<cansync::ReferenceUpdate>();
  ReferenceWriter waiting(rig, 2);
  waiting.deliver(values(1, 2));
  owner.unregister(values(1, 0));
  EXPECT_EQ(rig.expect_request<StopRelease>().channel, Channel::one);
  waiting.write(values(1, 3));
  EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 3u);
}

TEST(GatewayReferences, AWriterThatWaitsAndLeavesTakesNothingFromTheOwner) {
  GatewayRig rig;
  ReferenceWriter owner(rig, 1);
  owner.write(values(1, 1));
  rig.expect_request<cansync::ReferenceUpdate>();
  {
    ReferenceWriter one(rig, 1);
    one.deliver(values(1, 2));
    ReferenceWriter two(rig, 0);
    two.deliver(values(1, 3));
    ASSERT_TRUE(event(rig, "writer_waits"));
  }
  ASSERT_TRUE(rig.client.wait_for<cansync_MasterStatus>([](const auto& s) {
    return s.reference_release[0].refused == 2 && s.reference_release[0].waiting_writer[0] == '\0';
  }));
  owner.write(values(1, 4));
  EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 4u);
}

TEST(GatewayReferences, AStrongWriterThatGivesUpStopsItAlsoWhileAWeakerOneLives) {
  GatewayRig rig;
  ReferenceWriter weak(rig, 1);
  weak.write(values(1, 1));
  EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 1u);
  ReferenceWriter strong(rig, 2);
  strong.write(values(1, 2));
  EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 2u);
  weak.deliver(values(1, 3));
  strong.give_up(1);
  const auto stop = rig.expect_request<StopRelease>();
  EXPECT_EQ(stop.channel, Channel::one);
  EXPECT_EQ(stop.hold, 0u);
  ASSERT_TRUE(event(rig, "reference_given_up"));
  EXPECT_TRUE(rig.client.wait_for<cansync_MasterStatus>(
      [](const auto& s) { return gateway::dds::text(s.reference_release[0].cause) == "given_up"; }));
  weak.write(values(1, 4));
  const auto next = rig.expect_request<cansync::ReferenceUpdate>();
  EXPECT_EQ(next.value[0], 4u) << "never one it wrote before";
  EXPECT_FALSE(next.takes_over);
}

TEST(GatewayReferences, AWeakerWriterThatGivesUpChangesNothing) {
  GatewayRig rig;
  ReferenceWriter weak(rig, 1);
  weak.write(values(1, 1));
  EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 1u);
  ReferenceWriter strong(rig, 2);
  strong.write(values(1, 2));
  EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 2u);
  weak.give_up(1);
  strong.write(values(1, 3));
  EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 3u);
}

TEST(GatewayReferences, ThoseForAnotherStartOfTheDaemonAreRefused) {
  GatewayRig rig;
  const auto status = rig.client.wait_for<cansync_MasterStatus>([](const auto&) { return true; });
  ASSERT_TRUE(status);
  EXPECT_TRUE(std::equal(kTestDaemon.begin(), kTestDaemon.end(), std::begin(status->daemon)));
  EXPECT_EQ(status->mapping_number, 1u);
  ReferenceWriter writer(rig, 0);
  auto old = values(1, 1);
  old.daemon[0] = 0x77;
  writer.write(old);
  const auto refused = event(rig, "reference_refused");
  ASSERT_TRUE(refused);
  EXPECT_NE(gateway::dds::text(refused->text).find("another start of the daemon"), std::string_view::npos)
      << refused->text;
  EXPECT_EQ(rig.exchange.requests.size(), 0u);
  writer.write(values(1, 2));
  EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 2u);
}

// Whoever has the reply can give values for the new mapping.
TEST(GatewayReferences, TheNumberOfAChangedMappingIsToldBeforeItsReply) {
  GatewayRig rig;
  // Readers of different topics are matched at different times.
  ASSERT_TRUE(rig.client.wait_for<cansync_MasterStatus>([](const auto&) { return true; }));
  auto command = TestClient::request<cansync_Command>(1);
  command.kind = cansync_COMMAND_REFERENCE_MAPPING;
  rig.client.write(command);
  const auto request = rig.expect_request<SetReferenceMapping>();
  SettingsSnapshot settings;
  settings.mapping_number = 2;
  rig.exchange.settings.write(settings);
  rig.answer(CommandDone{request.id});
  ASSERT_TRUE(rig.client.reply<cansync_CommandReply>(1));
  const auto& told = rig.client.all<cansync_MasterStatus>();
  ASSERT_FALSE(told.empty());
  EXPECT_EQ(told.back().mapping_number, 2u);
}

TEST(GatewayReferences, BadOnesAreToldAsAnEvent) {
  struct Case {
    void (*spoil)(cansync_ReferenceValues&);
    std::string_view field;
    std::string_view allowed;
  };
  const Case cases[] = {
      {[](auto& v) { v.telegram = 0; }, "telegram 0", "1..2"},
      {[](auto& v) { v.telegram = 3; }, "telegram 3", "1..2"},
      {[](auto& v) { v.valid = 0; }, "valid 0", "1..15"},
      {[](auto& v) { v.valid = 16; }, "valid 16", "1..15"},
      {[](auto& v) { v.release_intervals = 1001; }, "release_intervals 1001", "0..1000"},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.field);
    GatewayRig rig;
    ReferenceWriter writer(rig, 0);
    auto bad = values(1, 1);
    c.spoil(bad);
    writer.write(bad);
    const auto refused = event(rig, "reference_refused");
    ASSERT_TRUE(refused);
    const auto text = gateway::dds::text(refused->text);
    EXPECT_NE(text.find("telegram " + std::to_string(bad.telegram)), std::string_view::npos) << text;
    EXPECT_NE(text.find(c.field), std::string_view::npos) << text;
    EXPECT_NE(text.find(c.allowed), std::string_view::npos) << text;
    EXPECT_EQ(rig.exchange.requests.size(), 0u);
  }
}

TEST(GatewayReferences, ThoseTheMasterRefusesAreToldOnceAndCounted) {
  GatewayRig rig;
  MasterSnapshot master;
  master.state = cansync::State::setting_up_master;
  rig.tell(master);
  ReferenceWriter writer(rig, 0);
  writer.write(values(2, 1));
  rig.expect_request<cansync::ReferenceUpdate>();
  for (cansync::IntervalNumber n = 50; n < 53; ++n) {
    ASSERT_TRUE(rig.exchange.reports.try_push(
        ReferenceRefused{moment(n), Channel::two, cansync::Refusal::wrong_state}));
  }
  rig.exchange.gateway_wake.signal();
  const auto over = event(rig, "reference_refusals_over");
  ASSERT_TRUE(over);
  EXPECT_NE(gateway::dds::text(over->text).find("3 were before"), std::string_view::npos) << over->text;
  const auto events = rig.client.events(over->number);
  const auto is_refusal = [](const auto& e) { return gateway::dds::text(e.code) == "reference_refused"; };
  ASSERT_EQ(std::count_if(events.begin(), events.end(), is_refusal), 1);
  const auto refused = std::find_if(events.begin(), events.end(), is_refusal);
  EXPECT_EQ(refused->interval, 50u);
  const auto text = gateway::dds::text(refused->text);
  EXPECT_NE(text.find("telegram 2"), std::string_view::npos) << text;
  EXPECT_NE(text.find("0x0043"), std::string_view::npos) << text;
  EXPECT_NE(text.find("mode run"), std::string_view::npos) << text;
}

TEST(GatewayReferences, AHoldIsAskedForWhenTheWriterLeaves) {
  Config config = gateway_config();
  config.failsafe.reaction = LossReaction::hold;
  config.failsafe.hold_intervals = 70;
  GatewayRig rig(config);
  {
    ReferenceWriter writer(rig, 0);
    writer.write(values(1, 1));
    rig.expect_request<cansync::ReferenceUpdate>();
  }
  EXPECT_EQ(rig.expect_request<StopRelease>().hold, 70u);
}

TEST(GatewayReferences, AStrongerWriterReplacesWhatTheWeakerGaveForLater) {
  GatewayRig rig;
  ReferenceWriter weak(rig, 1);
  weak.write(values(1, 1));
  EXPECT_FALSE(rig.expect_request<cansync::ReferenceUpdate>().takes_over);
  weak.write(values(1, 2));
  EXPECT_FALSE(rig.expect_request<cansync::ReferenceUpdate>().takes_over);
  ReferenceWriter strong(rig, 2);
  strong.write(values(1, 3));
  EXPECT_TRUE(rig.expect_request<cansync::ReferenceUpdate>().takes_over);
}

TEST(GatewayReferences, StaleOnesAreRefusedByDefault) {
  Config config = gateway_config();
  config.failsafe = {};
  GatewayRig rig(config);
  ReferenceWriter writer(rig, 0);
  writer.write_late(values(1, 1), DDS_SECS(5));
  const auto refused = event(rig, "reference_refused");
  ASSERT_TRUE(refused);
  EXPECT_NE(gateway::dds::text(refused->text).find("at most 500 ms"), std::string_view::npos)
      << refused->text;
  EXPECT_EQ(rig.exchange.requests.size(), 0u);
}

TEST(GatewayReferences, ThoseOfAClockThatIsAheadAreRefused) {
  Config config = gateway_config();
  config.failsafe = {};
  GatewayRig rig(config);
  ReferenceWriter writer(rig, 0);
  writer.write_late(values(1, 1), -DDS_SECS(3600));
  const auto refused = event(rig, "reference_refused");
  ASSERT_TRUE(refused);
  EXPECT_NE(gateway::dds::text(refused->text).find("in the future"), std::string_view::npos) << refused->text;
  EXPECT_EQ(rig.exchange.requests.size(), 0u);
}

}  // namespace
}  // namespace cansyncd
