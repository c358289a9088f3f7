#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <fstream>
#include <thread>

#include "dds/topics.h"
#include "gateway_rig.h"
#include "look_alike.h"

namespace cansyncd {
namespace {

namespace dds = cansync::dds;

cansync_ParameterRequest good_read(std::uint64_t number, std::uint8_t client = 1) {
  auto request = TestClient::request<cansync_ParameterRequest>(number, TestClient::identity(client));
  request.slave = 1;
  request.number = 301;
  request.element = 7;
  request.format = cansync_FORMAT_AS_SLAVE_SAYS;
  return request;
}

/// Writes a look-alike of `T` to its topic: a program that does not keep to the data model.
template <class T>
class Forger {
 public:
  Forger(const dds::Participant& participant, const dds_topic_descriptor_t& look_alike)
      : descriptor_(renamed(look_alike, dds::topic_info<T>().type->m_typename)) {
    const dds::TopicInfo& info = dds::topic_info<T>();
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
  EXPECT_EQ(reply->code, cansync_REPLY_DONE);
}

bool eventually_rejected(GatewayRig& rig, const std::function<bool(const cansync_MasterStatus&)>& fits) {
  return rig.client.wait_for<cansync_MasterStatus>(fits).has_value();
}

template <class Sample>
Sample forged(std::uint64_t number) {
  Sample sample = {};
  sample.client[0] = 7;
  sample.request = number;
  sample.slave = 1;
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
  const auto told = rig.client.wait_for<cansync_Event>(
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

/// Resident memory of this process in bytes.
std::size_t resident() {
  std::ifstream file("/proc/self/statm");
  std::size_t size = 0;
  std::size_t pages = 0;
  file >> size >> pages;
  return pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

/// One program writes without a rest; the other is served, each request is answered, and nothing grows.
TEST(GatewayBadSamples, AFloodKeepsNobodyElseWaitingAndTakesNoMemory) {
  GatewayRig rig;
  TestClient other(rig.places().there);
  ASSERT_TRUE(other.wait_for_gateway());
  std::atomic<bool> stop{false};
  std::atomic<std::uint64_t> written{0};
  std::thread flood([&] {
    dds::Writer<cansync_ParameterRequest> writer(rig.client.participant());
    dds::Writer<cansync_Command> commands(rig.client.participant());
    for (std::uint64_t number = 1; !stop; ++number) {
      auto request = good_read(number);
      request.slave = number % 3 == 0 ? 9 : 1;
      if (writer.write(request) == DDS_RETCODE_OK) ++written;
      auto command = TestClient::request<cansync_Command>(number + (1u << 30));
      command.kind = cansync_COMMAND_MODE;
      (void)commands.write(command);
    }
  });
  const auto serve_other = [&](std::uint64_t number) {
    other.write(good_read(number, 2));
    // The test is the line: whatever reaches it is done at once, until the other's request is.
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (other.replies<cansync_ParameterReply>(number, TestClient::identity(2)) == 0) {
      if (std::chrono::steady_clock::now() > end) return false;
      // A client that does not take its replies holds up DDS for the whole process.
      rig.client.all<cansync_ParameterReply>().clear();
      rig.client.all<cansync_CommandReply>().clear();
      other.all<cansync_CommandReply>().clear();
      Request request;
      if (!rig.exchange.requests.try_pop(request)) {
        std::this_thread::yield();
        continue;
      }
      if (const auto* read = std::get_if<cansync::ParameterRequest>(&request)) {
        rig.answer(ParameterDone{read->id, {}});
      } else if (const auto* mode = std::get_if<ModeRequest>(&request)) {
        rig.answer(CommandDone{mode->id, cansync::Outcome::done});
      }
    }
    // Its list holds the replies to the others, too.
    other.all<cansync_ParameterReply>().clear();
    return true;
  };
  std::uint64_t number = 1;
  const auto serve_until = [&](std::uint64_t flooded) {
    bool served = true;
    while (served && written < flooded) served = serve_other(number++);
    return served;
  };
  // What DDS and the tests' own lists need comes first.
  EXPECT_TRUE(serve_until(6'000));
  const std::size_t before = resident();
  EXPECT_TRUE(serve_until(46'000));
  const std::size_t after = resident();
  stop = true;
  flood.join();
  // 80,000 requests and as many replies that stayed would take far more than this, even with 160 bytes each.
  RecordProperty("growth", std::to_string(after > before ? after - before : 0));
  EXPECT_LE(after, before + (12u << 20)) << before << " bytes before";
}

}  // namespace
}  // namespace cansyncd
