#include "daemon/cansync/gateway/failsafe_commands.h"

#include <gtest/gtest.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "cansync/channel/job_ids.h"
#include "support/gateway_rig.h"

/// The rounds of control words that go out when reference values are missing.
namespace cansyncd {
namespace {

constexpr SteadyTime kStart{};

/// Four slaves get the word.
Config with_control_word() {
  Config config = gateway_config();
  config.failsafe.reaction = LossReaction::control_word;
  config.failsafe.control_word = 0x0104;
  return config;
}

/// FailsafeCommands alone, with the realtime side played by the test.
class RoundRig {
 public:
  explicit RoundRig(std::size_t room = ExchangeSizes{}.requests)
      : exchange({.requests = room}),
        participant_(places_.here),
        events_(participant_, journal, "testbus"),
        trail_(journal, events_, "testbus", cansync::kSlaves),
        audit_(trail_, config),
        commands(events_, audit_, config) {}

  void push() { next = commands.push(exchange, kStart); }
  /// The slaves whose control words were handed on, in their order, and those that are to be withdrawn.
  std::vector<unsigned> handed_on() {
    std::vector<unsigned> slaves;
    Request request;
    while (exchange.requests.try_pop(request)) {
      if (const auto* cancel = std::get_if<Cancel>(&request)) cancels.push_back(cancel->id);
      const auto* word = std::get_if<cansync::ControlWordRequest>(&request);
      if (word == nullptr) continue;
      EXPECT_TRUE(word->failsafe);
      slaves.push_back(word->slave.value());
      ids[word->slave.value()] = word->id;
    }
    return slaves;
  }
  void end(cansync::JobId id, cansync::Outcome outcome = cansync::Outcome::done) {
    EXPECT_TRUE(commands.finish(CommandDone{id, outcome}, config, {}, kStart));
  }
  /// Texts of the events that tell how rounds ended.
  std::vector<std::string> ends() {
    std::vector<std::string> texts;
    for (const auto& entry : journal.with("EVENT", "failsafe_control_word_ended"))
      texts.push_back(entry.message);
    return texts;
  }

  const Config config = with_control_word();
  KeptJournal journal;
  Exchange exchange;
  std::array<cansync::JobId, cansync::kSlaves> ids = {};
  std::vector<cansync::JobId> cancels;
  std::optional<SteadyTime> next;

 private:
  TwoPlaces places_;
  gateway::dds::Participant participant_;
  EventPublisher events_;
  AuditTrail trail_;
  RequestAudit audit_;

 public:
  FailsafeCommands commands;
};

using Numbers = std::vector<unsigned>;

TEST(GatewayFailsafe, ControlWordsWaitForRoomAndBothTelegramsLostAtOnceAreOneRound) {
  RoundRig rig(2);
  rig.commands.start(0, rig.config, kStart);
  rig.commands.start(1, rig.config, kStart);
  Numbers slaves;
  for (int i = 0; i < 2; ++i) {
    rig.push();
    EXPECT_EQ(rig.next.has_value(), i == 0);
    for (const unsigned number : rig.handed_on()) {
      slaves.push_back(number);
      rig.end(rig.ids[number]);
    }
  }
  EXPECT_EQ(slaves, (Numbers{0, 1, 2, 3}));
  EXPECT_EQ(rig.ends().size(), 1u);
  EXPECT_FALSE(rig.commands.finish(CommandDone{17}, rig.config, {}, kStart)) << "a client's";
}

/// Beside the gateway of a cluster, which cancels its own jobs by their ids.
TEST(GatewayFailsafe, ControlWordsHaveIdsThatNoOtherJobOfTheMasterHas) {
  RoundRig rig;
  for (int round = 0; round < 3; ++round) {
    rig.commands.start(0, rig.config, kStart);
    rig.push();
    for (const unsigned number : rig.handed_on()) {
      EXPECT_GE(rig.ids[number], cansync::kFailsafeJobs);
      EXPECT_LT(rig.ids[number], cansync::kGatewayJobs);
      rig.end(rig.ids[number]);
    }
    rig.commands.values_back(0, rig.config, kStart);
  }
}

TEST(GatewayFailsafe, NewValuesWithdrawWhatWasNotSentAndItIsTold) {
  RoundRig rig(2);
  rig.commands.start(0, rig.config, kStart);
  rig.commands.start(1, rig.config, kStart);
  rig.push();
  EXPECT_EQ(rig.handed_on(), (Numbers{0, 1}));
  rig.commands.values_back(1, rig.config, kStart);
  rig.push();
  EXPECT_EQ(rig.handed_on(), (Numbers{2, 3})) << "those of telegram 1 are still missing";
  rig.commands.values_back(0, rig.config, kStart);
  rig.end(rig.ids[0]);
  rig.push();
  (void)rig.handed_on();
  rig.push();
  EXPECT_TRUE(rig.handed_on().empty());
  EXPECT_EQ(rig.cancels, (std::vector{rig.ids[1], rig.ids[2], rig.ids[3]}));
  rig.end(rig.ids[1]);  // it was on its way
  for (const unsigned number : {2u, 3u}) rig.end(rig.ids[number], cansync::Outcome::cancelled);
  ASSERT_EQ(rig.ends().size(), 1u);
  const std::string told = rig.ends()[0];
  EXPECT_NE(told.find("slave 1 'feeder'; not to slave 2 'cutter', slave 3 'rewinder'"), std::string::npos)
      << told;
  EXPECT_NE(told.find("new reference values came first"), std::string::npos) << told;
}

TEST(GatewayFailsafe, ANewLossBeginsANewRoundWhileAnOldOneIsOpen) {
  RoundRig rig;
  rig.commands.start(0, rig.config, kStart);
  rig.push();
  EXPECT_EQ(rig.handed_on(), (Numbers{0, 1, 2, 3}));
  rig.end(rig.ids[0]);
  const auto before = rig.ids;
  rig.commands.values_back(0, rig.config, kStart);
  rig.commands.start(0, rig.config, kStart);
  rig.push();
  EXPECT_EQ(rig.handed_on(), (Numbers{0, 1, 2, 3})) << "slave 0 may have got another word since";
  EXPECT_TRUE(rig.cancels.empty()) << "the new words replace the old ones";
  for (const unsigned number : {1u, 2u, 3u}) rig.end(before[number], cansync::Outcome::replaced);
  EXPECT_EQ(rig.ends().size(), 1u);
  for (const unsigned number : {0u, 1u, 2u}) rig.end(rig.ids[number]);
  rig.end(rig.ids[3], cansync::Outcome::no_answer);
  ASSERT_EQ(rig.ends().size(), 2u);
  EXPECT_NE(rig.ends()[0].find("not yet to slave 1 'feeder'"), std::string::npos) << rig.ends()[0];
  EXPECT_NE(rig.ends()[1].find("not seen on the bus"), std::string::npos) << rig.ends()[1];
}

}  // namespace
}  // namespace cansyncd
