// A participant that moves, as with an interface that comes, goes, and has another address.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "cansync/dds/topics.h"
#include "dds/endpoint.h"
#include "support/dds_places.h"
#include "support/long_wait.h"

namespace cansync::dds {
namespace {

cansync_SlaveStatus slave(std::uint8_t number, std::uint16_t word) {
  cansync_SlaveStatus status = {};
  status.slave = number;
  status.status_word = word;
  return status;
}

/// Status words of what a reader gets until it has `count`.
std::vector<unsigned> words(Reader<cansync_SlaveStatus>& reader, DataSignal& signal, std::size_t count) {
  std::vector<unsigned> found;
  EXPECT_TRUE(eventually(signal, [&] {
    (void)reader.take([&](const cansync_SlaveStatus& status) { found.push_back(status.status_word); });
    return found.size() >= count;
  }));
  return found;
}

TEST(MovedParticipant, TellsLateReadersWhatItHasTold) {
  const TwoPlaces places;
  const Participant daemon(places.here);
  Writer<cansync_SlaveStatus> writer(daemon);
  for (const auto& told : {slave(1, 10), slave(2, 20), slave(1, 11)})
    ASSERT_EQ(writer.write(told), DDS_RETCODE_OK);
  const dds_entity_t before = writer.handle();
  daemon.move_to("lo", "another address");
  EXPECT_NE(writer.handle(), before);
  const Participant client(places.there);
  DataSignal signal;
  Reader<cansync_SlaveStatus> reader(client, &signal);
  std::vector<unsigned> found = words(reader, signal, 2);
  std::sort(found.begin(), found.end());
  EXPECT_EQ(found, (std::vector<unsigned>{11, 20})) << "the newest of each key, once";
  ASSERT_EQ(writer.write(slave(2, 21)), DDS_RETCODE_OK);
  EXPECT_EQ(words(reader, signal, 1), (std::vector<unsigned>{21}));
}

TEST(MovedParticipant, ReadsWhatIsNewAndNothingTwice) {
  const TwoPlaces places;
  const Participant daemon(places.here);
  const Participant client(places.there);
  DataSignal signal;
  DataSignal matched;
  Reader<cansync_ReferenceValues> reader(daemon, &signal);
  Writer<cansync_ReferenceValues> writer(client, 0, &matched);
  std::vector<int> found;
  const auto take = [&] {
    (void)reader.take([&](const cansync_ReferenceValues& sample) { found.push_back(sample.value[0]); });
    return !found.empty();
  };
  cansync_ReferenceValues sample = {};
  sample.telegram = 1;
  sample.value[0] = 111;
  ASSERT_TRUE(eventually(matched, [&] { return writer.matched() == 1; }));
  ASSERT_EQ(writer.write(sample), DDS_RETCODE_OK);
  ASSERT_TRUE(eventually(signal, take));
  EXPECT_EQ(std::exchange(found, {}), (std::vector<int>{111}));
  daemon.move_to("lo", "another address");
  ASSERT_TRUE(eventually(signal, [&] { return reader.matched() == 1; }));
  sample.value[0] = 112;
  // What a writer has not found yet it does not write to.
  const auto end = std::chrono::steady_clock::now() + gateway::kLongWait;
  while (!take() && std::chrono::steady_clock::now() < end) {
    ASSERT_EQ(writer.write(sample), DDS_RETCODE_OK);
    (void)signal.wait(10);
  }
  EXPECT_FALSE(found.empty());
  for (const int value : found) EXPECT_EQ(value, 112);
}

TEST(MovedParticipant, StaysWhereItIsWhenTheInterfaceIsMissing) {
  const TwoPlaces places;
  const Participant daemon(places.here);
  Writer<cansync_SlaveStatus> writer(daemon);
  const dds_entity_t before = writer.handle();
  EXPECT_THROW(daemon.move_to("nosuch0", ""), SetupError);
  EXPECT_EQ(writer.handle(), before);
  EXPECT_EQ(daemon.options().interface, "lo");
  EXPECT_EQ(writer.write(slave(1, 1)), DDS_RETCODE_OK);
}

TEST(MovedParticipant, MovesAgainAndWithoutWhatHasEnded) {
  const TwoPlaces places;
  const Participant daemon(places.here);
  Writer<cansync_SlaveStatus> writer(daemon);
  for (const char* address : {"1", "2", "3"}) {
    const Writer<cansync_MasterStatus> short_lived(daemon);
    daemon.move_to("lo", address);
    EXPECT_GT(short_lived.handle(), 0);
  }
  EXPECT_EQ(daemon.options().link, "3");
  EXPECT_EQ(writer.write(slave(1, 1)), DDS_RETCODE_OK);
}

}  // namespace
}  // namespace cansync::dds
