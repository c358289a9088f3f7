#include <dds/ddsrt/log.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "cansync/dds/topics.h"
#include "flood_rig.h"
#include "look_alike.h"
#include "support/gateway_rig.h"
#include "support/heap.h"

namespace cansyncd {
namespace {

namespace dds = cansync::dds;

/// Writes a look-alike of `T` to its topic: a program that does not keep to the data model.
template <class T>
class Forger {
 public:
  Forger(const dds::Participant& participant, const dds_topic_descriptor_t& look_alike)
      : descriptor_(renamed(look_alike, dds::topic_info<T>.type->m_typename)) {
    const dds::TopicInfo& info = dds::topic_info<T>;
    topic_ = dds::Entity(dds_create_topic(participant.handle(), &descriptor_, std::string(info.name).c_str(),
                                          nullptr, nullptr));
    writer_ = dds::Entity(
        dds_create_writer(participant.publisher(), topic_.get(), dds::writer_qos(info).get(), nullptr));
    EXPECT_TRUE(topic_ && writer_);
  }

  template <class LookAlike>
  void write(const LookAlike& sample) {
    ASSERT_EQ(dds_write(writer_.get(), &sample), DDS_RETCODE_OK);
  }
  bool matched() const { return dds_get_matched_subscriptions(writer_.get(), nullptr, 0) > 0; }

 private:
  /// Without its type information, so that DDS compares the names alone.
  static dds_topic_descriptor_t renamed(const dds_topic_descriptor_t& from, const char* name) {
    return {.m_size = from.m_size,
            .m_align = from.m_align,
            .m_flagset = from.m_flagset & ~static_cast<std::uint32_t>(DDS_TOPIC_XTYPES_METADATA),
            .m_nkeys = from.m_nkeys,
            .m_typename = name,
            .m_keys = from.m_keys,
            .m_nops = from.m_nops,
            .m_ops = from.m_ops,
            .m_meta = from.m_meta};
  }

  dds_topic_descriptor_t descriptor_;
  dds::Entity topic_;
  dds::Entity writer_;
};

/// The gateway goes on as if nothing had come.
void expect_served(GatewayRig& rig, std::uint64_t number) {
  EXPECT_EQ(rig.exchange.requests.size(), 0u);
  rig.client.write(good_read(number));
  rig.answer(ParameterDone{rig.expect_request<cansync::ParameterRequest>().id, {}});
  const auto reply = rig.client.reply<cansync_ParameterReply>(number);
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->code, gateway_REPLY_DONE);
}

bool eventually_rejected(GatewayRig& rig, const std::function<bool(const gateway_GatewayStatus&)>& fits) {
  return rig.client.wait_for<gateway_GatewayStatus>(fits).has_value();
}

template <class Sample>
Sample forged(std::uint64_t number) {
  Sample sample = {};
  sample.client[0] = 7;
  sample.request = number;
  sample.slave = 1;
  gateway::dds::set_daemon(kTestDaemon, sample);
  return sample;
}

TEST(GatewayBadSamples, UnknownEnumeratorsAreDroppedByDdsAndCounted) {
  GatewayRig rig;
  Forger<cansync_ParameterRequest> parameters(rig.client.participant(), look_alike_ParameterRequest_desc);
  Forger<cansync_TransferRequest> transfers(rig.client.participant(), look_alike_TransferRequest_desc);
  Forger<cansync_Command> commands(rig.client.participant(), look_alike_Command_desc);
  ASSERT_TRUE(eventually(rig.client.signal(),
                         [&] { return parameters.matched() && transfers.matched() && commands.matched(); }));
  auto parameter = forged<look_alike_ParameterRequest>(1);
  parameter.format = cansync_FORMAT_AS_SLAVE_SAYS + 1;
  parameters.write(parameter);
  parameter.format = 0xFFFFFFFF;
  parameters.write(parameter);
  auto transfer = forged<look_alike_TransferRequest>(2);
  transfer.direction = cansync_DIRECTION_DOWNLOAD + 1;
  transfers.write(transfer);
  auto command = forged<look_alike_Command>(3);
  command.kind = cansync_COMMAND_RELEASE + 1;  // the first that is none
  commands.write(command);
  command.kind = cansync_COMMAND_MODE;
  command.mode = cansync_MODE_RESTART + 1;
  commands.write(command);
  EXPECT_TRUE(eventually_rejected(rig, [](const auto& status) { return status.rejected_malformed == 5; }));
  const auto told = rig.client.wait_for<gateway_Event>(
      [](const auto& event) { return std::string_view(event.code) == "requests_rejected"; });
  ASSERT_TRUE(told);
  EXPECT_NE(std::string_view(told->text).find("DDS could not read"), std::string_view::npos) << told->text;
  expect_served(rig, 1);
}

/// The look-alike does reach the gateway, so what is dropped above is dropped for its enumerators alone.
TEST(GatewayBadSamples, AGoodLookAlikeIsServed) {
  GatewayRig rig;
  Forger<cansync_ParameterRequest> parameters(rig.client.participant(), look_alike_ParameterRequest_desc);
  ASSERT_TRUE(eventually(rig.client.signal(), [&] { return parameters.matched(); }));
  auto parameter = forged<look_alike_ParameterRequest>(1);
  parameter.number = 301;
  parameter.element = 7;
  parameter.format = cansync_FORMAT_DOUBLEWORD;
  parameters.write(parameter);
  EXPECT_EQ(rig.expect_request<cansync::ParameterRequest>().format, cansync::ParameterFormat::doubleword);
}

TEST(GatewayBadSamples, ASequenceOverItsBoundIsDroppedAndCounted) {
  GatewayRig rig;
  Forger<cansync_TransferRequest> transfers(rig.client.participant(), look_alike_TransferRequest_desc);
  ASSERT_TRUE(eventually(rig.client.signal(), [&] { return transfers.matched(); }));
  std::vector<std::uint8_t> data(cansync_MAXIMUM_TRANSFER + 1);
  auto transfer = forged<look_alike_TransferRequest>(1);
  transfer.direction = cansync_DIRECTION_DOWNLOAD;
  transfer.address = 0x1000;
  transfer.length = cansync_MAXIMUM_TRANSFER;
  transfer.data = {static_cast<std::uint32_t>(data.size()), static_cast<std::uint32_t>(data.size()),
                   data.data(), false};
  transfers.write(transfer);
  EXPECT_TRUE(eventually_rejected(rig, [](const auto& status) { return status.rejected_malformed == 1; }));
  expect_served(rig, 1);
}

TEST(GatewayBadSamples, ANameOverItsBoundIsDroppedAndCounted) {
  GatewayRig rig;
  Forger<cansync_ParameterRequest> parameters(rig.client.participant(), look_alike_ParameterRequest_desc);
  ASSERT_TRUE(eventually(rig.client.signal(), [&] { return parameters.matched(); }));
  std::string name(100'000, 'x');
  auto parameter = forged<look_alike_ParameterRequest>(1);
  parameter.client_name = name.data();
  parameters.write(parameter);
  EXPECT_TRUE(eventually_rejected(rig, [](const auto& status) { return status.rejected_malformed == 1; }));
  expect_served(rig, 1);
}

/// DDS must not wait for whoever reads standard error.
TEST(GatewayBadSamples, WhatElseDdsLogsIsAnEvent) {
  GatewayRig rig;
  dds_log(DDS_LC_WARNING, __FILE__, __LINE__, __func__, "out of paper\n");
  const auto told = rig.client.wait_for<gateway_Event>(
      [](const auto& event) { return std::string_view(event.code) == "dds_message"; });
  ASSERT_TRUE(told);
  EXPECT_EQ(std::string_view(told->text), "DDS says: out of paper");
  EXPECT_EQ(rig.journal.wait_for("EVENT", "dds_message").size(), 1u);
}

/// A program that invents an identity for every request would fill the reader with keys, and so hold up
/// everybody.
TEST(GatewayBadSamples, AProgramWithEndlesslyManyIdentitiesIsCutOff) {
  GatewayRig rig;
  constexpr std::uint64_t kIdentities = 2000;
  for (std::uint64_t i = 0; i < kIdentities; ++i) {
    auto request = good_read(1, 0xEE);
    std::memcpy(&request.client[1], &i, sizeof i);
    request.slave = 9;  // refused at once
    rig.client.write(request);
  }
  EXPECT_TRUE(eventually_rejected(rig, [](const auto& status) {
    return status.rejected_identities == kIdentities - dds::KeyGuard::kKeysPerWriter &&
           status.rejected_values == dds::KeyGuard::kKeysPerWriter && status.clients <= 16;
  }));
  // Other programs are served.
  TestClient other(rig.places().there);
  ASSERT_TRUE(other.wait_for_gateway());
  other.write(good_read(1, 2));
  rig.answer(ParameterDone{rig.expect_request<cansync::ParameterRequest>().id, {}});
  EXPECT_TRUE(other.reply<cansync_ParameterReply>(1, TestClient::identity(2)));
}

/// The least growth of the heap over five calls of `round` in a row, after five that are not counted. What is
/// kept of each request grows in every five; buffers grow once, at no round that could be named, and DDS
/// takes and gives back packet buffers of 1 MiB. So it goes on until five in a row grew by at most `limit`,
/// for eight such rows.
template <class Round>
std::size_t growth_over_five_rounds(std::size_t limit, Round&& round) {
  constexpr std::size_t kRow = 5;
  constexpr std::size_t kRows = 8;
  // The least of the last three: what stands at the end of a round differs by what is on its way.
  const auto after_a_row = [&] {
    std::size_t least = std::numeric_limits<std::size_t>::max();
    for (std::size_t i = 0; i < kRow && !testing::Test::HasFatalFailure(); ++i) {
      round();
      if (i + 3 >= kRow) least = std::min(least, support::heap_in_use());
    }
    return least;
  };
  std::size_t before = after_a_row();
  std::size_t least_growth = std::numeric_limits<std::size_t>::max();
  for (std::size_t row = 0; row < kRows && least_growth > limit; ++row) {
    const std::size_t after = after_a_row();
    if (testing::Test::HasFatalFailure()) break;
    least_growth = std::min(least_growth, after > before ? after - before : 0);
    before = after;
  }
  testing::Test::RecordProperty("growth", std::to_string(least_growth));
  return least_growth;
}

/// One program writes without a rest; the other is served, each request is answered once, nothing is kept.
TEST(GatewayBadSamples, AFloodKeepsNobodyElseWaitingAndTakesNoMemory) {
  FloodRig rig;
  // Of 10,000 requests, nearly all refused; 300 bytes kept of each are too many.
  constexpr std::size_t kLimit = 3'000'000;
  const std::size_t growth = growth_over_five_rounds(kLimit, [&] {
    ASSERT_TRUE(rig.run(1'000));
    ASSERT_EQ(rig.answered(), rig.written());
  });
  EXPECT_GT(rig.journal_entries(), 0u);
  EXPECT_LE(growth, kLimit);
}

/// Nothing is kept of requests that were taken and answered, either.
TEST(GatewayBadSamples, AnsweredRequestsTakeNoMemory) {
  CountedJournal journal;
  GatewayRig rig(gateway_config(), {}, {}, {}, &journal);
  std::uint64_t number = 0;
  // Together fewer than a client may have open.
  constexpr std::size_t kWindow = 25;
  const auto ask = [&] {
    for (std::size_t i = 0; i < kWindow; ++i) {
      rig.client.write(good_read(++number));
      auto mode = TestClient::request<cansync_Command>(++number);
      mode.kind = cansync_COMMAND_MODE;
      rig.client.write(mode);
    }
    for (std::size_t i = 0; i < 2 * kWindow; ++i) {
      const auto request = rig.next_request();
      ASSERT_TRUE(request);
      if (const auto* read = std::get_if<cansync::ParameterRequest>(&*request)) {
        rig.answer(ParameterDone{read->id, {}});
      } else {
        rig.answer(CommandDone{std::get<ModeRequest>(*request).id, cansync::Outcome::done});
      }
    }
    auto& reads = rig.client.all<cansync_ParameterReply>();
    auto& commands = rig.client.all<cansync_CommandReply>();
    ASSERT_TRUE(eventually(rig.client.signal(), [&] {
      (void)rig.client.all<cansync_ParameterReply>();
      (void)rig.client.all<cansync_CommandReply>();
      return reads.size() + commands.size() == 2 * kWindow;
    }));
    reads.clear();
    commands.clear();
  };
  // Of 25,000 requests; 60 bytes kept of each are too many.
  constexpr std::size_t kLimit = 1'500'000;
  const std::size_t growth = growth_over_five_rounds(kLimit, [&] {
    for (unsigned i = 0; i < 100 && !testing::Test::HasFatalFailure(); ++i) ask();
  });
  EXPECT_LE(growth, kLimit);
}

}  // namespace
}  // namespace cansyncd
