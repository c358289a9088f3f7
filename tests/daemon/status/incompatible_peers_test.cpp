#include "daemon/status/incompatible_peers.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "cansync/dds/topics.h"
#include "dds/bounded_text.h"
#include "look_alike.h"
#include "support/dds_places.h"
#include "support/kept_journal.h"
#include "support/long_wait.h"

/// Programs that are on the bus's topics and match nothing of them.
namespace cansyncd {
namespace {

namespace dds = cansync::dds;

/// A writer of another program, made of nothing but Cyclone DDS.
class RawWriter {
 public:
  RawWriter(const dds::ParticipantOptions& place, const dds::TopicInfo& info,
            const dds_topic_descriptor_t& type, const std::function<void(dds_qos_t*)>& change)
      : participant_(place) {
    topic_ = dds::Entity(
        dds_create_topic(participant_.handle(), &type, std::string(info.name).c_str(), nullptr, nullptr));
    const dds::Qos qos = dds::writer_qos(info);
    change(qos.get());
    writer_ = dds::Entity(dds_create_writer(participant_.publisher(), topic_.get(), qos.get(), nullptr));
    EXPECT_TRUE(topic_ && writer_);
  }
  std::string participant() const {
    dds_guid_t guid = {};
    EXPECT_EQ(dds_get_guid(participant_.handle(), &guid), DDS_RETCODE_OK);
    std::string digits;
    for (const unsigned byte : guid.v) digits += fmt::format("{:02x}", byte);
    return digits;
  }

 private:
  dds::Participant participant_;
  dds::Entity topic_;
  dds::Entity writer_;
};

/// The daemon's readers of two topics, and its look at what does not match, at instants that the test makes
/// up.
class IncompatibleRig {
 public:
  IncompatibleRig()
      : participant_(places.here),
        references_(participant_),
        commands_(participant_),
        events_(participant_, journal, "testbus"),
        peers(participant_, events_) {}

  /// Goes through time until so many programs are told; false when they are not in 20 s.
  bool until(std::uint32_t programs) {
    const auto end = std::chrono::steady_clock::now() + gateway::kLongWait;
    do {
      now_ += IncompatiblePeers::kAgain;
      (void)peers.step(now_);
      if (peers.count() == programs) return true;
      std::this_thread::yield();
    } while (std::chrono::steady_clock::now() < end);
    return false;
  }

  /// What was told so far.
  std::vector<std::string> told() const {
    std::vector<std::string> texts;
    for (const auto& entry : journal.with("EVENT", "dds_incompatible")) texts.push_back(entry.message);
    return texts;
  }
  /// The event that told of this participant, once it is here.
  std::optional<gateway_Event> event_of(const std::string& participant) {
    std::optional<gateway_Event> found;
    EXPECT_TRUE(eventually(signal_, [&] {
      event_reader_.take([&](const gateway_Event& event) {
        if (dds::text(event.participant) == participant) found = event;
      });
      return found.has_value();
    })) << participant;
    return found;
  }

  TwoPlaces places;
  KeptJournal journal;

 private:
  dds::Participant participant_;
  dds::Reader<cansync_ReferenceValues> references_;
  dds::Reader<cansync_Command> commands_;
  EventPublisher events_;
  SteadyTime now_;
  dds::DataSignal signal_;
  dds::Participant listener_{places.there};
  dds::Reader<gateway_Event> event_reader_{listener_, &signal_};

 public:
  IncompatiblePeers peers;
};

const dds::TopicInfo& references() {
  return dds::topic_info<cansync_ReferenceValues>;
}

void exclusive(dds_qos_t* qos) {
  dds_qset_ownership(qos, DDS_OWNERSHIP_EXCLUSIVE);
}

void as_it_is(dds_qos_t* /*qos*/) {}

TEST(IncompatiblePeers, ThePolicyTheTopicAndTheProgramAreToldOnce) {
  IncompatibleRig rig;
  std::optional<RawWriter> writer;
  writer.emplace(rig.places.there, references(), *references().type, exclusive);
  ASSERT_TRUE(rig.until(1));
  const auto event = rig.event_of(writer->participant());
  ASSERT_TRUE(event);
  EXPECT_EQ(dds::text(event->code), "dds_incompatible");
  EXPECT_EQ(event->severity, gateway_SEVERITY_WARNING);
  const std::string text(dds::text(event->text));
  EXPECT_NE(text.find("a writer of topic ReferenceValues of "), std::string::npos) << text;
  EXPECT_NE(text.find("does not match: ownership (offered exclusive, asked for shared)"), std::string::npos)
      << text;
  EXPECT_NE(text.find(fmt::format("process {}", getpid())), std::string::npos) << text;

  // Another program with another fault, told beside the first one, which is not told again.
  const RawWriter other(rig.places.there, references(), *references().type, [](dds_qos_t* qos) {
    dds_qset_liveliness(qos, DDS_LIVELINESS_AUTOMATIC, DDS_INFINITY);
  });
  ASSERT_TRUE(rig.until(2));
  const auto second = rig.event_of(other.participant());
  ASSERT_TRUE(second);
  EXPECT_NE(dds::text(second->text).find("liveliness (lease offered infinite, asked for 1000 ms)"),
            std::string::npos)
      << dds::text(second->text);
  EXPECT_EQ(rig.told().size(), 2u);

  writer.reset();
  EXPECT_TRUE(rig.until(1)) << "it has gone";
  EXPECT_EQ(rig.told().size(), 2u);
}

TEST(IncompatiblePeers, AProgramWithTheOtherRepresentationIsNamed) {
  IncompatibleRig rig;
  const RawWriter writer(rig.places.there, references(), *references().final_type, [](dds_qos_t* qos) {
    constexpr dds_data_representation_id_t kRepresentation = DDS_DATA_REPRESENTATION_XCDR1;
    dds_qset_data_representation(qos, 1, &kRepresentation);
  });
  ASSERT_TRUE(rig.until(1));
  const auto event = rig.event_of(writer.participant());
  ASSERT_TRUE(event);
  EXPECT_NE(dds::text(event->text).find("data representation (offered XCDR1, asked for XCDR2)"),
            std::string::npos)
      << dds::text(event->text);
}

TEST(IncompatiblePeers, AProgramOfAnotherDataModelIsNamed) {
  IncompatibleRig rig;
  // The type's name is the same, and so is the QoS.
  const dds_topic_descriptor_t& from = look_alike_Command_desc;
  const dds_topic_descriptor_t command = {.m_size = from.m_size,
                                          .m_align = from.m_align,
                                          .m_flagset = from.m_flagset,
                                          .m_nkeys = from.m_nkeys,
                                          .m_typename = cansync_Command_desc.m_typename,
                                          .m_keys = from.m_keys,
                                          .m_nops = from.m_nops,
                                          .m_ops = from.m_ops,
                                          .m_meta = from.m_meta,
                                          .type_information = from.type_information,
                                          .type_mapping = from.type_mapping,
                                          .restrict_data_representation = from.restrict_data_representation};
  const RawWriter writer(rig.places.there, dds::topic_info<cansync_Command>, command, as_it_is);
  ASSERT_TRUE(rig.until(1));
  const auto event = rig.event_of(writer.participant());
  ASSERT_TRUE(event);
  EXPECT_NE(dds::text(event->text).find("a writer of topic Command of "), std::string::npos)
      << dds::text(event->text);
  EXPECT_NE(dds::text(event->text).find("does not match: type (other members)"), std::string::npos)
      << dds::text(event->text);
}

TEST(IncompatiblePeers, ProgramsOfAnotherBusAreNoneOfOurs) {
  IncompatibleRig rig;
  auto elsewhere = rig.places.there;
  elsewhere.partition = "otherbus";
  const RawWriter stranger(elsewhere, references(), *references().type, exclusive);
  const RawWriter writer(rig.places.there, references(), *references().type, exclusive);
  ASSERT_TRUE(rig.until(1));
  ASSERT_TRUE(rig.event_of(writer.participant()));
  EXPECT_EQ(rig.told().size(), 1u);
}

TEST(IncompatiblePeers, WhoFitsIsNotTold) {
  IncompatibleRig rig;
  const RawWriter fits(rig.places.there, references(), *references().type, as_it_is);
  const RawWriter writer(rig.places.there, references(), *references().type, exclusive);
  ASSERT_TRUE(rig.until(1));
  ASSERT_TRUE(rig.event_of(writer.participant()));
  EXPECT_EQ(rig.told().size(), 1u);
}

}  // namespace
}  // namespace cansyncd
