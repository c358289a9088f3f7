#include <gtest/gtest.h>
#include <unistd.h>

#include <string>

#include "cansync/dds/topics.h"
#include "daemon/cansync/gateway/gateway_references.h"
#include "support/gateway_rig.h"
#include "support/reference_writer.h"

/// What the gateway does when reference values stop coming, and who it says gives them.
namespace cansyncd {
namespace {

using cansync::Channel;
using std::chrono::milliseconds;

std::size_t count(GatewayRig& rig, std::string_view code) {
  const auto& events = rig.client.all<gateway_Event>();
  return static_cast<std::size_t>(std::count_if(
      events.begin(), events.end(), [&](const auto& e) { return gateway::dds::text(e.code) == code; }));
}

std::string text_of(const std::optional<gateway_Event>& event) {
  return event ? std::string(gateway::dds::text(event->text)) : "no such event";
}

/// ReferenceInput alone, at instants that the test makes up.
class InputRig {
 public:
  explicit InputRig(const Config& config)
      : exchange(ExchangeSizes{}),
        participant_(places.here),
        events_(participant_, journal_, "testbus"),
        input(participant_, signal_, events_, config, kTestDaemon, exchange) {}

  /// Takes what has come until a request is there.
  template <class T>
  std::optional<T> take(SteadyTime now) {
    Request request;
    const bool found = eventually(signal_, [&] {
      input.take_samples(now);
      input.push_stops();
      return exchange.requests.try_pop(request);
    });
    const T* typed = found ? std::get_if<T>(&request) : nullptr;
    return typed != nullptr ? std::optional(*typed) : std::nullopt;
  }

  gateway::dds::DataSignal& signal() { return signal_; }

  TwoPlaces places;
  Exchange exchange;

 private:
  gateway::dds::Participant participant_;
  gateway::dds::DataSignal signal_;
  KeptJournal journal_;
  EventPublisher events_;

 public:
  ReferenceInput input;
};

constexpr SteadyTime kStart{};

/// A writer that counts as dead until its next sample when it writes nothing for a while, although it stays
/// matched: what a stopped process looks like.
class MortalWriter {
 public:
  MortalWriter(TwoPlaces& places, std::int32_t strength) : participant_(places.there) {
    namespace dds = cansync::dds;
    const dds::TopicInfo& info = dds::topic_info<cansync_ReferenceValues>;
    const std::string name(info.name);
    topic_ = dds::Entity(dds_create_topic(participant_.handle(), info.type, name.c_str(), nullptr, nullptr));
    const dds::Qos qos = dds::writer_qos(info, strength);
    dds_qset_liveliness(qos.get(), DDS_LIVELINESS_MANUAL_BY_TOPIC, DDS_MSECS(300));
    dds_listener_t* const listener = dds_create_listener(&signal_);
    dds_lset_publication_matched(listener,
                                 [](dds_entity_t, const dds_publication_matched_status_t, void* signal) {
                                   static_cast<dds::DataSignal*>(signal)->raise();
                                 });
    writer_ = dds::Entity(dds_create_writer(participant_.publisher(), topic_.get(), qos.get(), listener));
    dds_delete_listener(listener);
    EXPECT_TRUE(
        eventually(signal_, [this] { return dds_get_matched_subscriptions(writer_.get(), nullptr, 0) > 0; }));
  }
  void write(const cansync_ReferenceValues& sample) {
    ASSERT_EQ(dds_write(writer_.get(), &sample), DDS_RETCODE_OK);
  }

 private:
  gateway::dds::Participant participant_;
  gateway::dds::DataSignal signal_;
  gateway::dds::Entity topic_;
  gateway::dds::Entity writer_;
};

TEST(GatewayFailsafe, AMissedDeadlineStopsTheReleaseOnceAndNewValuesEndIt) {
  Config config = gateway_config();
  config.failsafe.reference_deadline = milliseconds(100);
  InputRig rig(config);
  ReferenceWriter writer(rig.places, 0);
  writer.write(values(1, 1));
  ASSERT_TRUE(rig.take<cansync::ReferenceUpdate>(kStart));

  EXPECT_EQ(rig.input.tick(kStart + milliseconds(99)), kStart + milliseconds(100));
  EXPECT_FALSE(rig.input.take_reaction(0));
  rig.input.push_stops();
  EXPECT_EQ(rig.exchange.requests.size(), 0u);

  EXPECT_EQ(rig.input.tick(kStart + milliseconds(100)), std::nullopt);
  EXPECT_TRUE(rig.input.take_reaction(0));
  EXPECT_FALSE(rig.input.take_reaction(0)) << "once";
  EXPECT_FALSE(rig.input.take_reaction(1)) << "that telegram has no writer";
  EXPECT_EQ(rig.input.givers()[0].loss, Loss::deadline_missed);
  const auto stop = rig.take<StopRelease>(kStart + milliseconds(100));
  ASSERT_TRUE(stop);
  EXPECT_EQ(stop->channel, Channel::one);
  EXPECT_EQ(rig.input.tick(kStart + milliseconds(1000)), std::nullopt) << "told on the edge alone";

  writer.write(values(1, 2));
  ASSERT_TRUE(rig.take<cansync::ReferenceUpdate>(kStart + milliseconds(2000)));
  EXPECT_EQ(rig.input.givers()[0].loss, Loss::none);
  EXPECT_EQ(rig.input.tick(kStart + milliseconds(2001)), kStart + milliseconds(2100));
  (void)rig.input.tick(kStart + milliseconds(2100));
  EXPECT_TRUE(rig.input.take_reaction(0)) << "lost again";
}

TEST(GatewayFailsafe, RefusedValuesDoNotKeepTheDeadline) {
  Config config = gateway_config();
  config.failsafe.reference_deadline = milliseconds(100);
  config.failsafe.reference_max_age = milliseconds(500);
  InputRig rig(config);
  ReferenceWriter writer(rig.places, 0);
  writer.write(values(1, 1));
  ASSERT_TRUE(rig.take<cansync::ReferenceUpdate>(kStart));
  writer.write_late(values(1, 2), DDS_SECS(5));
  writer.write(values(2, 3));
  // The second telegram's values come after the stale ones.
  const auto next = rig.take<cansync::ReferenceUpdate>(kStart + milliseconds(90));
  ASSERT_TRUE(next);
  EXPECT_EQ(next->channel, Channel::two);
  (void)rig.input.tick(kStart + milliseconds(100));
  EXPECT_EQ(rig.input.givers()[0].loss, Loss::deadline_missed);
  EXPECT_EQ(rig.input.givers()[1].loss, Loss::none);
}

TEST(GatewayFailsafe, TheReactionRunsOnceForEveryCauseOfOneOutage) {
  Config config = gateway_config();
  config.failsafe.reference_deadline = milliseconds(100);
  InputRig rig(config);
  auto writer = std::make_optional<ReferenceWriter>(rig.places, 0);
  writer->write(values(1, 1));
  ASSERT_TRUE(rig.take<cansync::ReferenceUpdate>(kStart));
  std::array<cansync::ReleaseStatus, cansync::kChannels> release = {};
  release[0].too_old = 1;
  rig.input.watch(release, kStart);
  EXPECT_EQ(rig.input.givers()[0].loss, Loss::too_old);
  EXPECT_TRUE(rig.input.take_reaction(0));
  (void)rig.input.tick(kStart + milliseconds(100));
  EXPECT_EQ(rig.input.givers()[0].loss, Loss::deadline_missed);
  writer.reset();
  ASSERT_TRUE(rig.take<StopRelease>(kStart + milliseconds(200)));
  ASSERT_TRUE(eventually(rig.signal(), [&] {
    rig.input.take_samples(kStart + milliseconds(200));
    return rig.input.givers()[0].loss == Loss::writer_lost;
  }));
  rig.input.watch(release, kStart);
  EXPECT_FALSE(rig.input.take_reaction(0));
  EXPECT_EQ(rig.input.givers()[0].who, "");
}

TEST(GatewayFailsafe, AStrongerWriterIsAnnouncedAndTheWeakerWhenItResumes) {
  GatewayRig rig;
  ReferenceWriter weak(rig.places(), 5, "conveyor");
  weak.write(values(1, 1));
  EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 1u);
  const auto began = text_of(event(rig, "reference_writer_began"));
  EXPECT_NE(began.find("'conveyor'"), std::string::npos) << began;
  EXPECT_NE(began.find("process " + std::to_string(::getpid())), std::string::npos) << began;
  EXPECT_NE(began.find("strength 5"), std::string::npos) << began;
  EXPECT_NE(began.find("telegram 1"), std::string::npos) << began;
  {
    ReferenceWriter strong(rig.places(), 9, "hand wheel");
    strong.write(values(1, 2));
    EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 2u);
    const auto taken = text_of(event(rig, "reference_writer_taken_over"));
    EXPECT_NE(taken.find("'hand wheel'"), std::string::npos) << taken;
    EXPECT_NE(taken.find("from 'conveyor'"), std::string::npos) << taken;
    weak.deliver(values(1, 3));  // written while the other one rules: never released
  }
  EXPECT_EQ(rig.expect_request<StopRelease>().channel, Channel::one);
  weak.write(values(1, 4));
  EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 4u);
  ASSERT_TRUE(event(rig, "reference_writer_lost"));
  ASSERT_TRUE(eventually(rig.client.signal(), [&] { return count(rig, "reference_writer_began") == 2; }));
  EXPECT_EQ(count(rig, "reference_writer_lost"), 1u);
  const auto status = rig.client.wait_for<cansync_MasterStatus>([](const auto& s) {
    return gateway::dds::text(s.reference_release[0].writer).find("conveyor") != std::string_view::npos;
  });
  ASSERT_TRUE(status);
  EXPECT_EQ(status->reference_release[0].strength, 5);
  EXPECT_EQ(gateway::dds::text(status->reference_release[1].writer), "");
}

TEST(GatewayFailsafe, AWriterThatDiesIsLostAlsoWhileAWeakerOneIsSilent) {
  GatewayRig rig;
  ReferenceWriter weak(rig.places(), 1);
  weak.write(values(1, 1));
  rig.expect_request<cansync::ReferenceUpdate>();
  // Its signs of life come with what it writes alone, as if its process were stopped afterwards.
  MortalWriter strong(rig.places(), 2);
  strong.write(values(1, 2));
  EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 2u);
  EXPECT_EQ(rig.expect_request<StopRelease>().channel, Channel::one);
  ASSERT_TRUE(event(rig, "reference_writer_lost"));
  weak.write(values(1, 3));
  EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 3u);
  // When it lives again, it takes over again.
  strong.write(values(1, 4));
  EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 4u);
}

Config with_control_word(std::optional<cansync::SlaveMask> slaves = std::nullopt) {
  Config config = gateway_config();
  config.failsafe.reaction = LossReaction::control_word;
  config.failsafe.control_word = 0x0104;
  config.failsafe.control_word_slaves = slaves;
  return config;
}

TEST(GatewayFailsafe, TheControlWordGoesToTheNamedSlavesAndItsOutcomeIsTold) {
  cansync::SlaveMask slaves;
  slaves.set(slave(1));
  slaves.set(slave(3));
  GatewayRig rig(with_control_word(slaves));
  {
    ReferenceWriter writer(rig, 0);
    writer.write(values(2, 1));
    rig.expect_request<cansync::ReferenceUpdate>();
  }
  EXPECT_EQ(rig.expect_request<StopRelease>().channel, Channel::two) << "the release stops first";
  const auto first = rig.expect_request<cansync::ControlWordRequest>();
  const auto second = rig.expect_request<cansync::ControlWordRequest>();
  EXPECT_EQ(first.slave, slave(1));
  EXPECT_EQ(second.slave, slave(3));
  EXPECT_EQ(first.control_word, 0x0104);
  const auto begun = text_of(event(rig, "failsafe_control_word"));
  EXPECT_NE(begun.find("0x0104"), std::string::npos) << begun;
  EXPECT_NE(begun.find("'feeder'"), std::string::npos) << begun;
  EXPECT_NE(begun.find("telegram 2"), std::string::npos) << begun;
  rig.answer(CommandDone{first.id});
  rig.answer(Refused{second.id, cansync::Refusal::queue_full});
  const auto ended = event(rig, "failsafe_control_word_ended");
  EXPECT_NE(text_of(ended).find("sent to slave 1 'feeder'; not to slave 3 'rewinder': "), std::string::npos)
      << text_of(ended);
  EXPECT_EQ(ended->severity, gateway_SEVERITY_ERROR);
  const auto recorded = rig.journal.wait_for("CLIENT", "failsafe reaction", 2);
  ASSERT_EQ(recorded.size(), 2u);
  EXPECT_EQ(recorded[0].field("CANSYNC_ACTION"), "control_word");
  EXPECT_EQ(recorded[0].field("SLAVE"), "1");
  EXPECT_EQ(recorded[0].field("CANSYNC_NEW"), "0x0104");
  EXPECT_EQ(recorded[0].field("CANSYNC_RESULT"), "done");
  EXPECT_EQ(recorded[1].field("SLAVE"), "3");
  EXPECT_EQ(recorded[1].field("CANSYNC_RESULT").rfind("refused: ", 0), 0u) << "it never reached the bus";
}

TEST(GatewayFailsafe, ValuesThatTheRealtimeThreadFoundTooOldBringTheControlWordToEverySlave) {
  GatewayRig rig(with_control_word());
  ReferenceWriter writer(rig, 0);
  writer.write(values(1, 1));
  rig.expect_request<cansync::ReferenceUpdate>();
  MasterSnapshot master;
  master.state = cansync::State::active_master;
  master.release[0].too_old = 1;
  rig.tell(master);
  for (std::uint8_t n = 0; n < 4; ++n) {
    const auto word = rig.expect_request<cansync::ControlWordRequest>();
    EXPECT_EQ(word.slave, slave(n));
    rig.answer(CommandDone{word.id});
  }
  const auto ended = event(rig, "failsafe_control_word_ended");
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->severity, gateway_SEVERITY_INFO);
  // New values take the release back, and the next outage brings the word again.
  writer.write(values(1, 2));
  EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 2u);
  master.release[0].too_old = 2;
  rig.tell(master);
  EXPECT_EQ(rig.expect_request<cansync::ControlWordRequest>().slave, slave(0));
}

TEST(GatewayFailsafe, ValuesThatComeBackAreToldOnceAndALossAfterThemAgain) {
  Config config = gateway_config();
  config.failsafe.reference_deadline = milliseconds(100);
  InputRig rig(config);
  ReferenceWriter writer(rig.places, 0);
  writer.write(values(1, 1));
  ASSERT_TRUE(rig.take<cansync::ReferenceUpdate>(kStart));
  EXPECT_FALSE(rig.input.take_return(0)) << "nothing was lost";
  (void)rig.input.tick(kStart + milliseconds(100));
  ASSERT_TRUE(rig.take<StopRelease>(kStart + milliseconds(100)));
  EXPECT_FALSE(rig.input.take_return(0));
  writer.write(values(1, 2));
  ASSERT_TRUE(rig.take<cansync::ReferenceUpdate>(kStart + milliseconds(150)));
  EXPECT_FALSE(rig.input.take_return(1));
  EXPECT_TRUE(rig.input.take_return(0));
  EXPECT_FALSE(rig.input.take_return(0)) << "once";
}

TEST(GatewayFailsafe, WithoutThatReactionNoControlWordIsSent) {
  GatewayRig rig;
  {
    ReferenceWriter writer(rig, 0);
    writer.write(values(1, 1));
    rig.expect_request<cansync::ReferenceUpdate>();
  }
  rig.expect_request<StopRelease>();
  ReferenceWriter other(rig, 0);
  other.write(values(1, 2));
  EXPECT_EQ(rig.expect_request<cansync::ReferenceUpdate>().value[0], 2u);
}

}  // namespace
}  // namespace cansyncd
