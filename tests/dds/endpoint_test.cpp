#include "dds/endpoint.h"

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "cansync/dds/convert.h"
#include "cansync/dds/topics.h"
#include "dds/guard/owner_guard.h"
#include "dds/incompatible.h"
#include "dds/newest.h"
#include "dds/owner_seen.h"
#include "dds/writer_identity.h"
#include "support/dds_places.h"

namespace cansync::dds {
namespace {

template <class T>
std::vector<T> take_all(Reader<T>& reader) {
  std::vector<T> all;
  EXPECT_GE(reader.take([&](const T& sample) { all.push_back(sample); }), 0);
  return all;
}

TEST(Endpoint, SampleCrossesTheLoopbackNetworkUnchanged) {
  const TwoPlaces places;
  const Participant daemon(places.here);
  const Participant client(places.there);
  DataSignal signal;
  Reader<cansync_SlaveStatus> reader(client, &signal);
  Writer<cansync_SlaveStatus> writer(daemon);

  cansync_SlaveStatus sent = {};
  sent.slave = 31;
  copy_text("unwinder", sent.name);
  sent.status_word = 0x8001;
  sent.last_response = -5;
  copy_text("1/min", sent.actual_value[7].unit_symbol);
  sent.actual_value[7].factor = 0.25;
  ASSERT_EQ(writer.write(sent), DDS_RETCODE_OK);  // transient local: also for readers that come later

  std::vector<cansync_SlaveStatus> got;
  ASSERT_TRUE(eventually(signal, [&] {
    got = take_all(reader);
    return !got.empty();
  }));
  ASSERT_EQ(got.size(), 1u);
  EXPECT_EQ(got[0].slave, 31);
  EXPECT_EQ(text(got[0].name), "unwinder");
  EXPECT_EQ(got[0].status_word, 0x8001);
  EXPECT_EQ(got[0].last_response, -5);
  EXPECT_EQ(text(got[0].actual_value[7].unit_symbol), "1/min");
  EXPECT_EQ(got[0].actual_value[7].factor, 0.25);
}

TEST(Endpoint, AReaderOfRepliesInThePartitionOfTheBusIsTheOneThatIsNamed) {
  const TwoPlaces places;
  const Participant daemon(places.here);
  const Participant client(places.there);
  DataSignal signal;
  const Writer<cansync_CommandReply> all(daemon, Partitions{every_reply_partition("testbus")}, &signal);
  const Writer<cansync_CommandReply> one(daemon, Partitions{reply_partition("testbus", {1})}, &signal);
  const Reader<cansync_CommandReply> right(client, Partitions{reply_partition("testbus", {2})}, &signal);
  const Reader<cansync_CommandReply> wrong(client);
  ASSERT_TRUE(eventually(signal, [&] { return all.matched() == 1; }));
  const auto found = [&](const Participant& looks) { return find_incompatible(looks, false, 10); };
  ASSERT_TRUE(eventually(signal, [&] { return found(daemon).size() == 1; }));
  EXPECT_EQ(found(daemon).front().policy, "partition");
  EXPECT_EQ(found(daemon).front().difference, "offered testbus/*, asked for testbus");
  EXPECT_TRUE(found(client).empty()) << "the writer of another client is nobody's mistake";
}

TEST(Endpoint, FinalTypesCrossTheNetworkAndMatchNoOthers) {
  TwoPlaces places;
  ParticipantOptions final_types = places.there;
  final_types.final_types = true;
  places.here.final_types = true;
  const Participant daemon(places.here);
  const Participant client(final_types);
  const Participant other(places.there);
  DataSignal signal;
  Writer<cansync_SlaveStatus> writer(daemon, 0, &signal);
  Reader<cansync_SlaveStatus> stranger(other, &signal);
  Reader<cansync_SlaveStatus> reader(client, &signal);
  cansync_SlaveStatus sent = {};
  sent.slave = 31;
  sent.last_response = -5;
  sent.actual_value[7].factor = 0.25;
  ASSERT_EQ(writer.write(sent), DDS_RETCODE_OK);
  std::vector<cansync_SlaveStatus> got;
  ASSERT_TRUE(eventually(signal, [&] {
    got = take_all(reader);
    return !got.empty();
  }));
  EXPECT_EQ(got[0].slave, 31);
  EXPECT_EQ(got[0].last_response, -5);
  EXPECT_EQ(got[0].actual_value[7].factor, 0.25);

  // The one with appendable types is known by then, and why it does not fit.
  ASSERT_TRUE(eventually(signal, [&] {
    signal.raise();
    return other.mismatches() != 0;
  }));
  EXPECT_EQ(stranger.matched(), 0u);
  const auto wrong = find_incompatible(other, false, 8);
  ASSERT_EQ(wrong.size(), 1u);
  EXPECT_NE(to_string(wrong[0]).find("a writer of topic SlaveStatus of "), std::string::npos);
  EXPECT_NE(to_string(wrong[0]).find("data representation (offered XCDR1, asked for XCDR2)"),
            std::string::npos)
      << to_string(wrong[0]);
}

TEST(Endpoint, AKeyWhoseWriterIsGoneIsToldAsGoneAlsoBehindDataThatNobodyHasTaken) {
  const TwoPlaces places;
  const Participant daemon(places.here);
  const Participant client(places.there);
  DataSignal signal;
  Reader<cansync_SlaveStatus> reader(client, &signal);
  Reader<cansync_SlaveStatus> beside(client, &signal);  // what it has got, the other one has
  Writer<cansync_SlaveStatus> stays(daemon);
  auto goes = std::make_unique<Writer<cansync_SlaveStatus>>(daemon);
  cansync_SlaveStatus sent = {};
  sent.slave = 1;
  ASSERT_EQ(stays.write(sent), DDS_RETCODE_OK);
  for (const std::uint8_t slave : {std::uint8_t{2}, std::uint8_t{3}}) {
    sent.slave = slave;
    ASSERT_EQ(goes->write(sent), DDS_RETCODE_OK);
  }
  std::size_t came = 0;
  ASSERT_TRUE(
      eventually(signal, [&] { return (came += take_all(beside).size()) == 3 && reader.matched() == 2; }));
  goes.reset();
  ASSERT_TRUE(eventually(signal, [&] { return reader.matched() == 1; }));
  std::set<int> data;
  std::set<int> gone;
  ASSERT_GE(reader.take([&](const cansync_SlaveStatus& sample) { data.insert(sample.slave); },
                        [&](const cansync_SlaveStatus& sample) { gone.insert(sample.slave); }),
            3);
  EXPECT_EQ(data, (std::set<int>{1, 2, 3}));
  EXPECT_EQ(gone, (std::set<int>{2, 3}));
}

/// A reader of a topic without keys, and what is known of it.
struct Known {
  const TwoPlaces places;
  const Participant daemon{places.here};
  const Participant client{places.there};
  DataSignal signal;
  Reader<cansync_MasterStatus> reader{client, &signal};
  Reader<cansync_MasterStatus> beside{client, &signal};  // what it has got, the other one has
  Newest<cansync_MasterStatus> newest;

  /// A writer that has told `number`, if it is one.
  std::unique_ptr<Writer<cansync_MasterStatus>> writer(std::uint32_t number) {
    auto made = std::make_unique<Writer<cansync_MasterStatus>>(daemon);
    tell(*made, number);
    return made;
  }
  static void tell(Writer<cansync_MasterStatus>& to, std::uint32_t number) {
    cansync_MasterStatus status = {};
    status.mapping_number = number;
    EXPECT_EQ(to.write(status), DDS_RETCODE_OK);
  }
  bool becomes(std::optional<std::uint32_t> number) {
    return eventually(signal, [&] {
      const auto& told = newest.take(reader);
      return told.has_value() == number.has_value() && (!told || told->mapping_number == *number);
    });
  }
};

TEST(Newest, WhatADaemonToldIsForgottenWithIt) {
  Known known;
  EXPECT_FALSE(known.newest.take(known.reader));
  auto one = known.writer(1);
  ASSERT_TRUE(known.becomes(1));
  one.reset();
  EXPECT_TRUE(known.becomes(std::nullopt));
  one = known.writer(2);
  EXPECT_TRUE(known.becomes(2));
}

TEST(Newest, WhatWasToldLastAndNeverTakenIsForgottenToo) {
  Known known;
  auto one = known.writer(1);
  ASSERT_TRUE(known.becomes(1));
  Known::tell(*one, 2);
  ASSERT_TRUE(eventually(known.signal, [&] {
    const auto came = take_all(known.beside);
    return !came.empty() && came.back().mapping_number == 2;
  }));
  one.reset();
  ASSERT_TRUE(eventually(known.signal, [&] { return known.reader.matched() == 0; }));
  EXPECT_FALSE(known.newest.take(known.reader));
}

TEST(Newest, OfTwoDaemonsTheOneThatStaysIsKnownWhenItTellsAgain) {
  Known known;
  auto stays = known.writer(1);
  ASSERT_TRUE(known.becomes(1));
  auto goes = known.writer(2);
  ASSERT_TRUE(known.becomes(2));
  goes.reset();
  EXPECT_TRUE(known.becomes(std::nullopt));
  Known::tell(*stays, 3);
  EXPECT_TRUE(known.becomes(3));
  goes = known.writer(4);
  ASSERT_TRUE(known.becomes(4));
  Known::tell(*stays, 5);
  ASSERT_TRUE(known.becomes(5));
}

TEST(Endpoint, LateReaderGetsTheLastHundredEvents) {
  const TwoPlaces places;
  const Participant daemon(places.here);
  const Participant client(places.there);
  Writer<gateway_Event> writer(daemon);
  gateway_Event event = {};
  for (event.number = 1; event.number <= 150; ++event.number) ASSERT_EQ(writer.write(event), DDS_RETCODE_OK);

  DataSignal signal;
  Reader<gateway_Event> reader(client, &signal);
  std::vector<gateway_Event> got;
  ASSERT_TRUE(eventually(signal, [&] {
    for (const gateway_Event& sample : take_all(reader)) got.push_back(sample);
    return got.size() >= 100;
  }));
  ASSERT_EQ(got.size(), 100u);
  EXPECT_EQ(got.front().number, 51u);
  EXPECT_EQ(got.back().number, 150u);
}

TEST(Endpoint, OtherPartitionsDoNotHearEachOther) {
  TwoPlaces places;
  ParticipantOptions other = places.there;
  other.partition = "otherbus";
  const Participant daemon(places.here);
  const Participant client(places.there);
  const Participant stranger(other);
  DataSignal signal;
  Reader<cansync_MasterStatus> reader(client, &signal);
  Reader<cansync_MasterStatus> stranger_reader(stranger, &signal);
  Writer<cansync_MasterStatus> writer(daemon);
  ASSERT_EQ(writer.write(cansync_MasterStatus{}), DDS_RETCODE_OK);
  ASSERT_TRUE(eventually(signal, [&] { return take_all(reader).size() == 1; }));
  EXPECT_EQ(stranger_reader.matched(), 0u);
  EXPECT_EQ(writer.matched(), 1u);
}

/// Two writers of reference values in one place, one reader in the other.
class Ownership : public ::testing::Test {
 protected:
  static cansync_ReferenceValues values(std::int32_t first) {
    cansync_ReferenceValues sample = {};
    sample.telegram = 1;
    sample.value[0] = first;
    sample.valid = 1;
    return sample;
  }

  /// Takes what is there; true when the newest value is `first`.
  bool newest_is(std::int32_t first) {
    (void)reader_.take([&](const cansync_ReferenceValues& sample) { seen_.push_back(sample.value[0]); },
                       [&](const cansync_ReferenceValues& key) {
                         gone_ = true;
                         EXPECT_EQ(key.telegram, 1);
                       });
    return !seen_.empty() && seen_.back() == first;
  }

  TwoPlaces places_;
  Participant daemon_{places_.here};
  Participant client_{places_.there};
  DataSignal signal_;
  Reader<cansync_ReferenceValues> reader_{daemon_, &signal_};
  DataSignal matched_;
  std::vector<std::int32_t> seen_;
  bool gone_ = false;
};

TEST_F(Ownership, EveryWriterIsHeardWhateverItsStrengthWhichIsKnown) {
  Writer<cansync_ReferenceValues> strong(client_, 10, &matched_);
  Writer<cansync_ReferenceValues> weak(client_, 1, &matched_);
  ASSERT_TRUE(eventually(matched_, [&] { return strong.matched() == 1 && weak.matched() == 1; }));
  ASSERT_EQ(strong.write(values(100)), DDS_RETCODE_OK);
  ASSERT_TRUE(eventually(signal_, [&] { return newest_is(100); }));
  ASSERT_EQ(weak.write(values(1)), DDS_RETCODE_OK);
  dds_instance_handle_t of = 0;
  ASSERT_TRUE(eventually(signal_, [&] {
    (void)reader_.take_batch(
        [&](const cansync_ReferenceValues&, const dds_sample_info_t& info) { of = info.publication_handle; });
    return of != 0;
  }));
  const auto identity = identify_writer(daemon_, reader_.handle(), of);
  ASSERT_TRUE(identity);
  EXPECT_EQ(identity->strength, 1) << "it travels though ownership is shared";
  EXPECT_EQ(identity->guid, guid_of(weak));
}

// Each writer has a key of its own: the end of one is told while another goes on.
TEST_F(Ownership, TheEndOfOneWriterIsToldWhileAnotherLives) {
  std::optional<Writer<cansync_ReferenceValues>> one(std::in_place, client_, 1, &matched_);
  Writer<cansync_ReferenceValues> other(client_, 1, &matched_);
  ASSERT_TRUE(eventually(matched_, [&] { return one->matched() == 1 && other.matched() == 1; }));
  cansync_ReferenceValues sample = values(7);
  set_writer(*one, sample);
  ASSERT_EQ(one->write(sample), DDS_RETCODE_OK);
  set_writer(other, sample);
  ASSERT_EQ(other.write(sample), DDS_RETCODE_OK);
  ASSERT_TRUE(eventually(signal_, [&] { return newest_is(7) && seen_.size() == 2; }));
  EXPECT_FALSE(gone_);
  one.reset();
  EXPECT_TRUE(eventually(signal_, [&] {
    (void)newest_is(7);
    return gone_;
  }));
}

TEST_F(Ownership, AProgramThatChangesItsKeyAllTheTimeFillsNothing) {
  DataSignal signal;
  OwnerGuard guard(signal);
  Reader<cansync_ReferenceValues> guarded(daemon_, &signal, &guard);
  Writer<cansync_ReferenceValues> writer(client_, 1, &matched_);
  ASSERT_TRUE(eventually(matched_, [&] { return writer.matched() == 2; }));
  constexpr std::size_t kFlood = 1000;
  cansync_ReferenceValues sample = values(7);
  for (std::size_t i = 0; i < kFlood; ++i) {
    sample.writer[0] = static_cast<std::uint8_t>(i);
    sample.writer[1] = static_cast<std::uint8_t>(i >> 8);
    ASSERT_EQ(writer.write(sample), DDS_RETCODE_OK);
  }
  std::size_t taken = 0;
  std::uint64_t dropped = 0;
  ASSERT_TRUE(eventually(signal, [&] {
    (void)guarded.take([&](const cansync_ReferenceValues&) { ++taken; });
    dropped += guard.take_dropped();
    return taken + dropped == kFlood;
  }));
  EXPECT_EQ(taken, OwnerGuard::kKeysPerWriter);
}

TEST_F(Ownership, LossOfTheLastWriterIsTold) {
  std::optional<Writer<cansync_ReferenceValues>> only(std::in_place, client_, 0, &matched_);
  ASSERT_TRUE(eventually(matched_, [&] { return only->matched() == 1; }));
  ASSERT_EQ(only->write(values(7)), DDS_RETCODE_OK);
  ASSERT_TRUE(eventually(signal_, [&] { return newest_is(7); }));
  EXPECT_FALSE(gone_);
  only.reset();
  EXPECT_TRUE(eventually(signal_, [&] {
    (void)newest_is(7);
    return gone_;
  }));
}

TEST(Endpoint, ReaderHoldsNoMoreRequestsThanTheTableAllows) {
  const TwoPlaces places;
  const Participant daemon(places.here);
  const Participant client(places.there);
  DataSignal signal;
  DataSignal matched;
  Reader<cansync_Command> reader(daemon, &signal);
  Writer<cansync_Command> writer(client, 0, &matched);
  ASSERT_TRUE(eventually(matched, [&] { return writer.matched() == 1; }));
  const std::uint64_t limit =
      static_cast<std::uint64_t>(topic_info<cansync_Command>.qos.max_samples_per_instance);

  // A reader that never takes: the flood must end at a writer that is told to wait, not in memory.
  cansync_Command command = {};
  bool refused = false;
  std::uint64_t written = 0;
  for (; written < 100 * limit && !refused; ++written) {
    command.request = written + 1;
    refused = writer.write(command) == DDS_RETCODE_TIMEOUT;
  }
  EXPECT_TRUE(refused);

  // Nothing of what was accepted is lost or out of order; no take gives more than the table allows at once.
  std::uint64_t expected = 1;
  const std::uint64_t accepted = written - 1;
  ASSERT_TRUE(eventually(signal, [&] {
    const dds_return_t taken = reader.take([&](const cansync_Command& sample) {
      EXPECT_EQ(sample.request, expected);
      ++expected;
    });
    EXPECT_GE(taken, 0);
    return expected > accepted;
  }));
}

TEST(Participant, WrongOptionsAreRefusedByName) {
  const auto message = [](const ParticipantOptions& options) -> std::string {
    try {
      const Participant participant(options);
    } catch (const SetupError& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(message({.domain = 231, .partition = "can0"}), "DDS domain 231 is out of range; allowed: 0..230");
  EXPECT_NE(message({.partition = ""}).find("1 to 63 characters"), std::string::npos);
  EXPECT_NE(message({.partition = "can*"}).find("'can*' is no bus name"), std::string::npos);
  const std::string interface = message({.domain = 3, .partition = "can0", .interface = "nosuch0"});
  EXPECT_NE(interface.find("'nosuch0' does not exist (DDS domain 3, partition can0)"), std::string::npos);
}

TEST(Participant, OneProcessSharesADomainButNotWithAnotherConfiguration) {
  const TwoPlaces places;
  const Participant first(places.here);
  const Participant second(places.here);
  ParticipantOptions other = places.here;
  other.xml = places.there.xml;
  EXPECT_THROW(Participant{other}, SetupError);
}

TEST(Participant, DomainCanBeOpenedAgainWithAnotherConfiguration) {
  const TwoPlaces places;
  { const Participant first(places.here); }
  ParticipantOptions other = places.here;
  other.xml = places.there.xml;
  const Participant second(other);
  EXPECT_NE(second.place().find("partition testbus"), std::string::npos);
}

}  // namespace
}  // namespace cansync::dds
