#include "dds/guard/key_guard.h"

#include <gtest/gtest.h>

#include <vector>

#include "cansync/dds/convert.h"
#include "cansync/dds/topics.h"
#include "dds/endpoint.h"
#include "support/dds_places.h"

namespace cansync::dds {
namespace {

constexpr std::uint8_t kElsewhere = 9;  // begins the identity of another daemon

template <class Sample>
KeyGuard::Content content_of(const void* sample) {
  const auto& request = *static_cast<const Sample*>(sample);
  KeyGuard::Content content{key_of(request), 0, request.daemon[0] == kElsewhere};
  if constexpr (requires { request.data; }) content.bytes = request.data._length;
  return content;
}

/// Waits until the reader of `writer` has everything.
template <class T>
bool arrived(Writer<T>& writer) {
  return dds_wait_for_acks(writer.handle(), DDS_SECS(20)) == DDS_RETCODE_OK;
}

TEST(KeyGuard, AClientWithTooManyRequestsHoldsUpNoOtherTopic) {
  const TwoPlaces places;
  const Participant daemon(places.here);
  const Participant client(places.there);
  DataSignal signal;
  DataSignal matched;
  KeyGuard guard(content_of<cansync_ParameterRequest>, signal);
  Reader<cansync_ParameterRequest> requests(daemon, &signal, &guard);
  Reader<cansync_Command> commands(daemon, &signal);
  Writer<cansync_ParameterRequest> writer(client, 0, &matched);
  Writer<cansync_Command> other(client, 0, &matched);
  ASSERT_TRUE(eventually(matched, [&] { return writer.matched() == 1 && other.matched() == 1; }));

  constexpr std::size_t kTooMany = 100;
  cansync_ParameterRequest request = {};
  for (std::size_t i = 0; i < kOpenRequests + kTooMany; ++i) {
    ++request.request;
    ASSERT_EQ(writer.write(request), DDS_RETCODE_OK);
  }
  // Nobody takes them, and yet everything gets through.
  EXPECT_TRUE(arrived(writer));
  cansync_Command command = {};
  command.request = 1;
  ASSERT_EQ(other.write(command), DDS_RETCODE_OK);
  EXPECT_TRUE(eventually(signal, [&] { return commands.take([](const cansync_Command&) {}) == 1; }));

  // Those that did not fit are known, in order; a few at a time.
  std::vector<KeyGuard::TurnedAway> refused = guard.take_turned_away(60);
  EXPECT_EQ(refused.size(), 60u);
  for (const auto& more : guard.take_turned_away(60)) refused.push_back(more);
  ASSERT_EQ(refused.size(), kTooMany);
  EXPECT_EQ(refused.front().key.request, kOpenRequests + 1);
  EXPECT_EQ(refused.back().key.request, kOpenRequests + kTooMany);
  EXPECT_NE(refused.front().writer, 0u);
  EXPECT_EQ(guard.take_forgotten(), 0u);

  // What is taken makes room.
  std::size_t taken = 0;
  (void)requests.take_batch([&](const cansync_ParameterRequest&, const dds_sample_info_t& info) {
    guard.taken(info.instance_handle, 0);
    ++taken;
  });
  EXPECT_EQ(taken, kOpenRequests);
  ++request.request;
  ASSERT_EQ(writer.write(request), DDS_RETCODE_OK);
  EXPECT_TRUE(eventually(signal, [&] { return requests.take([](const cansync_ParameterRequest&) {}) == 1; }));
  EXPECT_TRUE(guard.take_turned_away(1).empty());
}

TEST(KeyGuard, WhatIsMeantForAnotherDaemonIsDroppedAndCountedAlone) {
  const TwoPlaces places;
  const Participant daemon(places.here);
  const Participant client(places.there);
  DataSignal signal;
  DataSignal matched;
  KeyGuard guard(content_of<cansync_ParameterRequest>, signal);
  Reader<cansync_ParameterRequest> requests(daemon, &signal, &guard);
  Writer<cansync_ParameterRequest> writer(client, 0, &matched);
  ASSERT_TRUE(eventually(matched, [&] { return writer.matched() == 1; }));
  cansync_ParameterRequest request = {};
  request.daemon[0] = kElsewhere;
  // More than may wait, and with more keys than one writer may have.
  constexpr std::size_t kMany = kOpenRequests + 8;
  for (request.request = 1; request.request <= kMany; ++request.request) {
    request.client[0] = static_cast<std::uint8_t>(request.request);
    ASSERT_EQ(writer.write(request), DDS_RETCODE_OK);
  }
  request.client[0] = 1;
  request.daemon[0] = 0;
  ASSERT_EQ(writer.write(request), DDS_RETCODE_OK);
  EXPECT_TRUE(arrived(writer));
  std::vector<std::uint64_t> came;
  (void)requests.take([&](const cansync_ParameterRequest& sample) { came.push_back(sample.request); });
  EXPECT_EQ(came, std::vector<std::uint64_t>{kMany + 1});
  EXPECT_EQ(guard.take_elsewhere(), kMany);
  EXPECT_EQ(guard.take_elsewhere(), 0u);
  EXPECT_EQ(guard.take_dropped(), 0u);
  EXPECT_TRUE(guard.take_turned_away(1).empty());
}

TEST(KeyGuard, DataThatWaitsIsBoundedForEachClient) {
  const TwoPlaces places;
  const Participant daemon(places.here);
  const Participant client(places.there);
  DataSignal signal;
  DataSignal matched;
  KeyGuard guard(content_of<cansync_TransferRequest>, signal);
  const Reader<cansync_TransferRequest> requests(daemon, &signal, &guard);
  Writer<cansync_TransferRequest> writer(client, 0, &matched);
  ASSERT_TRUE(eventually(matched, [&] { return writer.matched() == 1; }));
  std::vector<std::uint8_t> data(KeyGuard::kBytesPerKey / 3 + 1);
  cansync_TransferRequest request = {};
  request.data._buffer = data.data();
  request.data._length = request.data._maximum = static_cast<std::uint32_t>(data.size());
  for (int i = 0; i < 3; ++i) {
    ++request.request;
    ASSERT_EQ(writer.write(request), DDS_RETCODE_OK);
    ASSERT_TRUE(arrived(writer));
  }
  const auto refused = guard.take_turned_away(10);
  ASSERT_EQ(refused.size(), 1u);
  EXPECT_EQ(refused.front().key.request, 3u);
}

}  // namespace
}  // namespace cansync::dds
