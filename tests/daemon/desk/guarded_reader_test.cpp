#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "daemon/desk/request_topic.h"
#include "j1939.h"
#include "j1939/dds/topics.h"
#include "support/dds_places.h"

namespace cansyncd {
namespace {

namespace dds = gateway::dds;

/// All of it is memory of the daemon until it is taken, whichever of its sequences carries it.
TEST(GuardedReader, LongDataThatWaitsIsBoundedForEachClient) {
  const TwoPlaces places;
  const dds::Participant daemon(places.here);
  const dds::Participant client(places.there);
  dds::DataSignal signal;
  dds::DataSignal matched;
  RequestReaders readers;
  const TopicSetup setup{daemon, signal, readers};
  GuardedReader<j1939_MessageRequest> requests(setup, dds::topic_info<j1939_MessageRequest>, Right::operate);
  dds::Writer<j1939_MessageRequest> writer(client, 0, &matched);
  ASSERT_TRUE(eventually(matched, [&] { return writer.matched() == 1; }));

  std::vector<std::uint8_t> data(j1939_LONG_MESSAGE_BYTES);
  j1939_MessageRequest request = {};
  request.long_data._buffer = data.data();
  request.long_data._length = request.long_data._maximum = static_cast<std::uint32_t>(data.size());
  constexpr std::size_t kFitting = dds::KeyGuard::kBytesPerKey / j1939_LONG_MESSAGE_BYTES;
  for (std::size_t i = 0; i <= kFitting; ++i) {
    ++request.request;
    ASSERT_EQ(writer.write(request), DDS_RETCODE_OK);
    ASSERT_EQ(dds_wait_for_acks(writer.handle(), DDS_SECS(20)), DDS_RETCODE_OK);
  }

  PlaceFinder finder;
  std::vector<std::uint64_t> refused;
  const auto refuse = [&](const dds::RequestKey& key, const Place&) { refused.push_back(key.request); };
  (void)requests.take_turned_away(finder, refuse);
  EXPECT_EQ(refused, std::vector<std::uint64_t>{kFitting + 1});

  // What is taken makes room.
  std::size_t taken = 0;
  const auto take = [&](const j1939_MessageRequest&, const Place&, std::int64_t) { ++taken; };
  (void)requests.take(finder, take);
  EXPECT_EQ(taken, kFitting);
  ++request.request;
  ASSERT_EQ(writer.write(request), DDS_RETCODE_OK);
  EXPECT_TRUE(eventually(signal, [&] {
    (void)requests.take(finder, take);
    return taken == kFitting + 1;
  }));
}

}  // namespace
}  // namespace cansyncd
