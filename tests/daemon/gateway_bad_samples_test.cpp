#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <thread>

#include "dds/topics.h"
#include "gateway_rig.h"
#include "look_alike.h"
#include "support/heap.h"

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

/// Counts what would go to the journal: what a test keeps must not look like growth of the daemon.
class CountedJournal : public JournalSink {
 public:
  void write(const std::string& /*message*/, const std::vector<JournalField>& /*fields*/) override {
    ++entries_;
  }
  std::uint64_t entries() const { return entries_; }

 private:
  std::atomic<std::uint64_t> entries_{0};
};

/// A program that writes reads and mode commands as fast as DDS takes them, on a thread of its own, as one
/// client. Every third read names a slave that there is not.
class Flood {
 public:
  explicit Flood(const dds::Participant& participant) : reads_(participant), commands_(participant) {}

  /// Begins to write `pairs` more of each kind.
  void begin(std::uint64_t pairs) {
    ending_ = false;
    thread_ = std::thread([this, pairs] {
      for (std::uint64_t i = 0; i < pairs; ++i) write(i % 3 == 0 ? 9 : 1);
      ending_ = true;
    });
  }
  /// False while it writes; true when the last was written and the gateway's readers have all.
  bool ended() const {
    return ending_ && dds_wait_for_acks(reads_.handle(), 0) == DDS_RETCODE_OK &&
           dds_wait_for_acks(commands_.handle(), 0) == DDS_RETCODE_OK;
  }
  void join() { thread_.join(); }
  /// Writes one more of each kind, which the gateway answers after all before, and returns the number of the
  /// read; that of the command is one more.
  std::uint64_t last() {
    write(1);
    return number_ - 2;
  }
  std::uint64_t written() const { return written_; }

 private:
  void write(std::uint32_t to_slave) {
    auto read = good_read(number_++);
    read.slave = to_slave;
    if (reads_.write(read) == DDS_RETCODE_OK) ++written_;
    auto mode = TestClient::request<cansync_Command>(number_++);
    mode.kind = cansync_COMMAND_MODE;
    if (commands_.write(mode) == DDS_RETCODE_OK) ++written_;
  }

  dds::Writer<cansync_ParameterRequest> reads_;
  dds::Writer<cansync_Command> commands_;
  std::uint64_t number_ = 1;
  std::uint64_t written_ = 0;
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

/// A flood in `rig.client`'s program, and another program that asks for something now and then. The test is
/// the line: whatever reaches it is done at once.
class FloodRig {
 public:
  FloodRig()
      : rig_(gateway_config(), {}, {}, {}, &journal_),
        other_(rig_.places().there),
        flood_(rig_.client.participant()) {
    EXPECT_TRUE(other_.wait_for_gateway());
  }

  /// Floods with `pairs` requests of each kind while the other is served, until all is answered. False when
  /// the other waited too long, or the end did not come.
  bool run(std::uint64_t pairs) {
    flood_.begin(pairs);
    bool served = true;
    do {
      served = served && serve_other();
    } while (served && !flood_.ended());
    flood_.join();
    return served && settle();
  }

  std::uint64_t written() const { return flood_.written(); }
  std::uint64_t answered() const { return answered_; }
  std::uint64_t others() const { return others_; }
  std::uint64_t journal_entries() const { return journal_.entries(); }

 private:
  static constexpr std::chrono::seconds kPatience{60};

  bool serve_other() {
    const std::uint64_t number = ++others_;
    other_.write(good_read(number, 2));
    return serve_until([&] { return other_done_ == number; });
  }
  /// Until the gateway has answered everything: those asked last are done last of their queues.
  bool settle() {
    do {
      last_read_ = flood_.last();
      read_code_.reset();
      command_code_.reset();
      if (!serve_until([&] { return read_code_ && command_code_; })) return false;
      // Refused as long as too many others are open.
    } while (read_code_ != cansync_REPLY_DONE || command_code_ != cansync_REPLY_DONE);
    return serve_other();
  }
  template <class Condition>
  bool serve_until(Condition&& condition) {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (!condition()) {
      if (std::chrono::steady_clock::now() > end) return false;
      take_replies();
      Request request;
      if (!rig_.exchange.requests.try_pop(request)) {
        std::this_thread::yield();
      } else if (const auto* read = std::get_if<cansync::ParameterRequest>(&request)) {
        rig_.answer(ParameterDone{read->id, {}});
      } else if (const auto* mode = std::get_if<ModeRequest>(&request)) {
        rig_.answer(CommandDone{mode->id, cansync::Outcome::done});
      }
    }
    return true;
  }
  /// A client that does not take its replies would hold up DDS.
  void take_replies() {
    drain<cansync_ParameterReply>(rig_.client, [this](const auto& reply) {
      if (reply.client[0] != 1) return;
      ++answered_;
      if (reply.request == last_read_) read_code_ = reply.code;
    });
    drain<cansync_CommandReply>(rig_.client, [this](const auto& reply) {
      ++answered_;
      if (reply.request == last_read_ + 1) command_code_ = reply.code;
    });
    drain<cansync_ParameterReply>(other_, [this](const auto& reply) {
      if (reply.client[0] == 2) other_done_ = reply.request;
    });
    drain<cansync_CommandReply>(other_, [](const auto& /*reply*/) {});
  }
  template <class Reply, class Take>
  static void drain(TestClient& client, Take&& take) {
    auto& replies = client.all<Reply>();
    for (const Reply& reply : replies) take(reply);
    replies.clear();
  }

  CountedJournal journal_;
  GatewayRig rig_;
  TestClient other_;
  Flood flood_;
  std::uint64_t others_ = 0;
  std::uint64_t other_done_ = 0;
  std::uint64_t last_read_ = 0;  ///< number of the read that ends a flood; its command has the next
  std::optional<cansync_ReplyCode> read_code_;
  std::optional<cansync_ReplyCode> command_code_;
  std::uint64_t answered_ = 0;
};

/// Growth of the heap over `rounds` calls of `round`, from the least of the third to fifth to the least of
/// the last three: buffers grow with the first, and DDS takes and gives back packet buffers of 1 MiB.
template <class Round>
std::size_t growth_over_rounds(Round&& round) {
  std::array<std::size_t, 10> used = {};
  for (std::size_t& bytes : used) {
    round();
    if (testing::Test::HasFatalFailure()) return 0;
    bytes = support::heap_in_use();
  }
  const std::size_t before = *std::min_element(used.begin() + 2, used.begin() + 5);
  const std::size_t after = *std::min_element(used.begin() + 7, used.end());
  const std::size_t growth = after > before ? after - before : 0;
  testing::Test::RecordProperty("growth", std::to_string(growth));
  return growth;
}

/// One program writes without a rest; the other is served, each request is answered once, nothing is kept.
TEST(GatewayBadSamples, AFloodKeepsNobodyElseWaitingAndTakesNoMemory) {
  FloodRig rig;
  const std::size_t growth = growth_over_rounds([&] {
    ASSERT_TRUE(rig.run(8'000));
    ASSERT_EQ(rig.answered(), rig.written());
  });
  EXPECT_GT(rig.journal_entries(), 0u);
  // Of 80,000 requests, nearly all refused; 80 bytes kept of each are too many.
  EXPECT_LE(growth, 6u << 20);
}

/// Nothing is kept of requests that were taken and answered, either.
TEST(GatewayBadSamples, AnsweredRequestsTakeNoMemory) {
  CountedJournal journal;
  GatewayRig rig(gateway_config(), {}, {}, {}, &journal);
  std::uint64_t number = 0;
  // Together fewer than a client may have open.
  constexpr unsigned kWindow = 25;
  const auto ask = [&] {
    for (unsigned i = 0; i < kWindow; ++i) {
      rig.client.write(good_read(++number));
      auto mode = TestClient::request<cansync_Command>(++number);
      mode.kind = cansync_COMMAND_MODE;
      rig.client.write(mode);
    }
    for (unsigned i = 0; i < 2 * kWindow; ++i) {
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
      return reads.size() + commands.size() == std::size_t{2 * kWindow};
    }));
    reads.clear();
    commands.clear();
  };
  const std::size_t growth = growth_over_rounds([&] {
    for (unsigned i = 0; i < 100 && !testing::Test::HasFatalFailure(); ++i) ask();
  });
  // Of 25,000 requests; 60 bytes kept of each are too many.
  EXPECT_LE(growth, 1'500'000u);
}

}  // namespace
}  // namespace cansyncd
