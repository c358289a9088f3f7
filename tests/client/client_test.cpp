#include <cansync/client.h>
#include <cansync/topics.h>
#include <gtest/gtest.h>

#include <atomic>
#include <deque>
#include <optional>
#include <random>
#include <set>
#include <thread>
#include <vector>

#include "client/client_rig.h"
#include "client/fake_daemon.h"
#include "support/dds_places.h"
#include "support/long_wait.h"

namespace cansync::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class ClientTest : public ::testing::Test {
 protected:
  TwoPlaces places_;
  std::optional<FakeDaemon> daemon_{std::in_place, places_.here};
  std::optional<Client> client_{Client::connect(options_for(places_.there))};
};

TEST(Connect, WithoutADaemonTellsWhereItLookedAndWhatToDo) {
  const TwoPlaces places;
  try {
    const Client client = Client::connect(options_for(places.here, milliseconds(100)));
    FAIL() << "connected to nothing";
  } catch (const NoDaemon& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("no daemon found: looked for 100 ms"), std::string::npos) << text;
    EXPECT_NE(text.find("DDS domain " + std::to_string(places.here.domain)), std::string::npos) << text;
    EXPECT_NE(text.find("partition testbus, interface lo"), std::string::npos) << text;
    EXPECT_NE(text.find("systemctl status cansyncd@testbus"), std::string::npos) << text;
  }
}

TEST(Connect, WithoutANameTakesTheOnlyBusOfTheDomain) {
  const TwoPlaces places;
  const FakeDaemon daemon(places.here);
  Options options = options_for(places.there);
  options.bus.clear();
  Client client = Client::connect(options);
  EXPECT_NE(client.place().find("partition testbus"), std::string::npos) << client.place();
  EXPECT_EQ(client.read(0, 1).code, ReplyCode::done);
}

TEST(Connect, WithoutANameAndWithoutADaemonSaysThatNoBusIsThere) {
  const TwoPlaces places;
  Options options = options_for(places.here, milliseconds(100));
  options.bus.clear();
  try {
    const Client client = Client::connect(options);
    FAIL() << "connected to nothing";
  } catch (const NoDaemon& error) {
    EXPECT_NE(std::string(error.what()).find("for a daemon of any bus"), std::string::npos) << error.what();
  }
}

TEST(Connect, WaitsForADaemonThatComesLater) {
  const TwoPlaces places;
  std::optional<Client> client;
  std::thread waiting([&] { client.emplace(Client::connect(options_for(places.there))); });
  const FakeDaemon daemon(places.here);
  waiting.join();
  EXPECT_TRUE(client->daemon_present());
  EXPECT_EQ(client->read(0, 1).code, ReplyCode::done);
}

TEST(Connect, WorksInTheDaemonsOwnProcess) {
  const TwoPlaces places;
  const FakeDaemon daemon(places.here);
  Client client = Client::connect(options_for(places.here));
  EXPECT_EQ(client.write(1, 2, 3).code, ReplyCode::done);
  EXPECT_EQ(client.read(1, 2).value, 3u);
}

TEST_F(ClientTest, ReadGivesWhatWasWritten) {
  ASSERT_EQ(client_->write(2, 100, 0xCAFE1234).code, ReplyCode::done);
  const ParameterReply reply = client_->read(2, 100);
  EXPECT_EQ(reply.code, ReplyCode::done);
  EXPECT_EQ(reply.reason, "");
  EXPECT_EQ(reply.value, 0xCAFE1234u);
  EXPECT_TRUE(reply.doubleword);
  EXPECT_EQ(reply.intervals, 1u);
}

TEST_F(ClientTest, RefusalAndSlaveErrorCarryTheirCauseAndReason) {
  const ParameterReply refused = client_->read(3, 4096);
  EXPECT_EQ(refused.code, ReplyCode::refused);
  EXPECT_EQ(refused.reason, "number 4096: out of range; allowed 0..4095");
  EXPECT_EQ(refused.cause, RefusalCause::field);
  EXPECT_EQ(refused.retry(), Retry::never);
  EXPECT_EQ(client_->control_word(9, 0).wait().cause, RefusalCause::slave_not_configured);
  const ParameterReply error = client_->read(3, FakeDaemon::kErrorNumber);
  EXPECT_EQ(error.code, ReplyCode::slave_error);
  EXPECT_EQ(error.error_code, 0xFFFE);
  EXPECT_NE(error.reason.find("below the minimum"), std::string::npos);
  EXPECT_EQ(client_->control_word(9, 1).wait().reason, "slave 9: not configured; allowed 0..3");
}

/// With as little room for replies as there may be: writes of the daemon wait for acknowledgements again and
/// again.
TEST(ManyRequests, OfSeveralThreadsGetTheirOwnReply) {
  constexpr std::uint32_t kThreads = 4;
  constexpr std::uint32_t kEach = 200;
  constexpr std::size_t kOpen = kOpenRequests / kThreads;
  TwoPlaces places;
  places.here.xml = dds::configuration(places.here);
  for (const std::string room = "64 MiB"; places.here.xml.find(room) != std::string::npos;)
    places.here.xml.replace(places.here.xml.find(room), room.size(), "4 kB");
  const FakeDaemon daemon(places.here);
  Client client = Client::connect(options_for(places.there));
  std::vector<std::thread> threads;
  std::atomic<unsigned> wrong = 0;
  for (std::uint32_t slave = 0; slave < kThreads; ++slave) {
    threads.emplace_back([&, slave] {
      std::deque<ParameterJob> jobs;
      for (std::uint32_t i = 0; i < kEach + kOpen; ++i) {
        if (i < kEach) {
          jobs.push_back(client.submit(
              ParameterRequest{.write = true, .slave = slave, .number = i, .value = slave * 1000 + i}));
        }
        if (i + 1 < kOpen || jobs.empty()) continue;
        const std::uint32_t number = std::min(i + 1, kEach) - static_cast<std::uint32_t>(jobs.size());
        const ParameterReply reply = jobs.front().wait();
        jobs.pop_front();
        if (!reply.ok() || reply.value != slave * 1000 + number) ++wrong;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0u);
  EXPECT_EQ(daemon.requests(), kThreads * kEach);  // each came exactly once
}

TEST_F(ClientTest, OneRequestMoreThanMayBeOpenIsRefusedHere) {
  const ParameterRequest silent{.slave = 1, .number = FakeDaemon::kSilentNumber};
  std::vector<ParameterJob> open;
  for (std::size_t i = 0; i < kOpenRequests; ++i) open.push_back(client_->submit(silent));
  const ParameterReply one_more = client_->read(0, 1);
  EXPECT_EQ(one_more.code, ReplyCode::refused);
  EXPECT_EQ(one_more.speaker, Speaker::client);
  EXPECT_EQ(one_more.cause, RefusalCause::client_limit);
  EXPECT_EQ(one_more.retry(), Retry::soon);
  EXPECT_EQ(one_more.reason,
            "queue full: this client has 64 requests open, at most 64 are allowed; wait for a reply first");
  EXPECT_EQ(client_->control_word(1, 0).wait().reason, one_more.reason);  // all kinds together
  // As soon as one has ended there is room.
  EXPECT_TRUE(open.front().cancel());
  EXPECT_EQ(open.front().wait().code, ReplyCode::cancelled);
  EXPECT_TRUE(client_->read(0, 1).ok());
  EXPECT_EQ(daemon_->requests(), kOpenRequests + 1);
}

TEST_F(ClientTest, ClientsDoNotSeeEachOthersReplies) {
  Client other = Client::connect(options_for(places_.there));
  // Both count their requests from 1: only the identity tells the replies apart.
  const ParameterJob silent =
      client_->submit(ParameterRequest{.slave = 1, .number = FakeDaemon::kSilentNumber});
  const ParameterReply reply = other.read(1, 5);
  EXPECT_TRUE(reply.ok());
  EXPECT_EQ(silent.wait_for(milliseconds(0)), std::nullopt);
  EXPECT_TRUE(silent.cancel());
  EXPECT_EQ(silent.wait().code, ReplyCode::cancelled);
}

TEST_F(ClientTest, TransfersOfMoreThanAMegabyteAreIdentical) {
  std::mt19937 random(20260101);
  std::vector<std::uint8_t> data(3'000'001);
  for (std::uint8_t& byte : data) byte = static_cast<std::uint8_t>(random());
  Watched<std::set<std::uint32_t>> progress;
  const TransferReply down = client_->download(1, 0x100, data, [&](std::uint32_t done, std::uint32_t total) {
    progress.change([&](auto& seen) { seen.insert(done); });
    EXPECT_EQ(total, 3'000'001u);
  });
  ASSERT_EQ(down.code, ReplyCode::done) << down.reason;
  EXPECT_EQ(down.done, 3'000'001u);
  const TransferReply up = client_->upload(1, 0x100, 3'000'001);
  ASSERT_EQ(up.code, ReplyCode::done) << up.reason;
  EXPECT_EQ(up.data, data);
}

TEST_F(ClientTest, LongestTransferPassesAndOneByteMoreIsRefused) {
  std::vector<std::uint8_t> data(16'777'216, 0x5A);
  const TransferReply down = client_->download(1, 0x100, data);
  EXPECT_EQ(down.code, ReplyCode::done) << down.reason;
  data.push_back(0);
  const TransferReply refused = client_->download(1, 0x100, data);
  EXPECT_EQ(refused.code, ReplyCode::refused);
  EXPECT_EQ(refused.reason, "length 16777217: out of range; allowed 1..16777216 bytes");
}

TEST_F(ClientTest, StopFlagCancelsARunningTransferAndWaitsForItsEnd) {
  std::atomic<bool> stop = false;
  std::uint32_t done = 0;
  const TransferJob job =
      client_->submit(TransferRequest{.slave = 1, .address = FakeDaemon::kEndlessAddress, .length = 1000});
  const TransferReply reply = job.wait(stop, [&](std::uint32_t bytes, std::uint32_t) {
    done = bytes;
    stop = true;  // as a signal handler would
  });
  EXPECT_EQ(reply.code, ReplyCode::cancelled);
  EXPECT_EQ(done, 500u);
}

TEST(Causes, EachHasAWordOfItsOwnAndOnlyARefusalIsDecidedByIt) {
  std::set<std::string_view> words;
  for (unsigned i = 0; i <= static_cast<unsigned>(RefusalCause::shared_limit); ++i) {
    const auto cause = static_cast<RefusalCause>(i);
    EXPECT_TRUE(words.insert(name(cause)).second) << name(cause);
    EXPECT_NE(retry(ReplyCode::refused, cause), Retry::look_first) << "nothing was sent";
    EXPECT_EQ(retry(ReplyCode::slave_error, cause), Retry::never);
    EXPECT_EQ(retry(ReplyCode::no_reply, cause), Retry::look_first);
  }
  EXPECT_EQ(retry(ReplyCode::refused, RefusalCause::read_only), Retry::after_change);
  EXPECT_EQ(name(static_cast<RefusalCause>(200)), "unknown");
  EXPECT_EQ(retry(ReplyCode::refused, static_cast<RefusalCause>(200)), Retry::never);
}

TEST_F(ClientTest, EveryCauseComesAsTheDaemonGaveIt) {
  for (unsigned i = 1; i <= static_cast<unsigned>(RefusalCause::shared_limit); ++i) {
    const ParameterReply refused = client_->read(0, FakeDaemon::kRefusals + i);
    EXPECT_EQ(refused.code, ReplyCode::refused);
    EXPECT_EQ(refused.cause, static_cast<RefusalCause>(i)) << name(static_cast<RefusalCause>(i));
    EXPECT_EQ(refused.reason, "not now");
  }
}

/// A daemon from before the causes says REPLY_REFUSED and nothing else.
TEST_F(ClientTest, ARefusalWithoutACauseIsOneOfAnUnknownCause) {
  const ParameterReply old = client_->read(0, FakeDaemon::kRefusals);
  EXPECT_EQ(old.code, ReplyCode::refused);
  EXPECT_EQ(old.cause, RefusalCause::unknown);
  EXPECT_EQ(old.retry(), Retry::never);
}

TEST_F(ClientTest, AnotherThreadCanCancel) {
  const ParameterJob job = client_->submit(ParameterRequest{.slave = 0, .number = FakeDaemon::kSilentNumber});
  std::thread other([job] { EXPECT_TRUE(job.cancel()); });
  EXPECT_EQ(job.wait().code, ReplyCode::cancelled);
  other.join();
}

TEST_F(ClientTest, OpenJobsEndWhenTheDaemonGoes) {
  const ParameterJob job = client_->submit(ParameterRequest{.slave = 0, .number = FakeDaemon::kSilentNumber});
  daemon_.reset();
  const ParameterReply reply = job.wait();
  EXPECT_EQ(reply.code, ReplyCode::no_reply);
  EXPECT_NE(reply.reason.find("the daemon is gone"), std::string::npos);
  const ParameterReply after = client_->read(0, 1);
  EXPECT_EQ(after.code, ReplyCode::no_daemon);
  EXPECT_EQ(after.retry(), Retry::when_state_over);
  EXPECT_NE(after.reason.find("nothing was sent"), std::string::npos);
}

/// What a daemon took that was killed is answered by nobody: it ends at the client, once, and the next daemon
/// is asked anew.
TEST_F(ClientTest, OpenJobsOfEveryKindEndWhenTheDaemonGoesAndTheNextOneServes) {
  const ParameterJob read =
      client_->submit(ParameterRequest{.slave = 0, .number = FakeDaemon::kSilentNumber});
  const ParameterJob write =
      client_->submit(ParameterRequest{.write = true, .slave = 1, .number = FakeDaemon::kSilentNumber});
  const TransferJob upload =
      client_->submit(TransferRequest{.slave = 2, .address = FakeDaemon::kEndlessAddress, .length = 100});
  const TransferJob download = client_->submit(TransferRequest{
      .download = true, .slave = 3, .address = FakeDaemon::kEndlessAddress, .data = {1, 2, 3}});
  const CommandJob command = client_->broadcast({.slave_mask = 1, .action = FakeDaemon::kSilentAction});
  // It has taken them all.
  while (daemon_->requests() < 5) std::this_thread::yield();
  daemon_.reset();
  EXPECT_EQ(read.wait().code, ReplyCode::no_reply);
  EXPECT_EQ(write.wait().code, ReplyCode::no_reply);
  EXPECT_EQ(upload.wait().code, ReplyCode::no_reply);
  EXPECT_EQ(download.wait().code, ReplyCode::no_reply);
  EXPECT_EQ(command.wait().code, ReplyCode::no_reply);

  daemon_.emplace(places_.here);
  const auto end = std::chrono::steady_clock::now() + gateway::kLongWait;
  ParameterReply reply = client_->read(0, 1);
  while (!reply.ok() && std::chrono::steady_clock::now() < end) {
    // Ended by the client itself, until the new daemon is found; none waits for an answer that cannot come.
    EXPECT_TRUE(reply.code == ReplyCode::no_reply || reply.code == ReplyCode::no_daemon) << reply.reason;
    std::this_thread::yield();
    reply = client_->read(0, 1);
  }
  EXPECT_TRUE(reply.ok()) << reply.reason;
}

TEST_F(ClientTest, OpenJobsEndWhenTheClientGoes) {
  const CommandJob done = client_->mode(Mode::run, true);
  EXPECT_TRUE(done.wait().ok());
  const ParameterJob open =
      client_->submit(ParameterRequest{.slave = 0, .number = FakeDaemon::kSilentNumber});
  client_.reset();
  EXPECT_EQ(open.wait().code, ReplyCode::no_reply);
  EXPECT_FALSE(open.cancel());
}

TEST_F(ClientTest, CommandsArriveWithTheirFields) {
  EXPECT_TRUE(client_->control_word(3, 0xABCD).wait().ok());
  EXPECT_TRUE(
      client_->broadcast({.priority = 1, .slave_mask = 5, .action = 130, .data_byte = 9, .data_word = 77})
          .wait()
          .ok());
  EXPECT_TRUE(client_->mode(Mode::run, true).wait().ok());
  EXPECT_TRUE(client_->polling({.one = 2, .maximum_slave = 3}).wait().ok());
  EXPECT_TRUE(client_->cursors({.transfer = kAutomatic}).wait().ok());
  EXPECT_TRUE(client_->map_references({0x01, 0x03}).wait().ok());
  EXPECT_TRUE(client_->map_actuals(2, {0, 0, 0, 0x0D}).wait().ok());
  const std::vector<cansync_Command> commands = daemon_->commands();
  ASSERT_EQ(commands.size(), 7u);
  EXPECT_EQ(commands[0].slave, 3u);
  EXPECT_EQ(commands[0].control_word, 0xABCDu);
  EXPECT_EQ(dds::text(commands[0].client_name), "client_test");
  EXPECT_EQ(commands[1].slave_mask, 5u);
  EXPECT_EQ(commands[1].action, 130u);
  EXPECT_EQ(commands[1].data_byte, 9u);
  EXPECT_EQ(commands[1].data_word, 77u);
  EXPECT_EQ(commands[2].mode, cansync_MODE_RUN);
  EXPECT_TRUE(commands[2].force);
  EXPECT_EQ(commands[3].polling_one, 2);
  EXPECT_EQ(commands[3].polling_two, kUnchanged);
  EXPECT_EQ(commands[3].maximum_slave, 3);
  EXPECT_EQ(commands[4].cursor_control_word, kUnchanged);
  EXPECT_EQ(commands[4].cursor_transfer, kAutomatic);
  EXPECT_EQ(commands[5].mapping[1], 0x03);
  EXPECT_EQ(commands[6].slave, 2u);
  EXPECT_EQ(commands[6].mapping[3], 0x0D);
}

TEST_F(ClientTest, SlavesAreFoundByNumberAndName) {
  const std::vector<SlaveStatus> slaves = client_->slaves();
  ASSERT_EQ(slaves.size(), 4u);
  EXPECT_EQ(dds::text(slaves[3].name), "slave3");
  EXPECT_EQ(client_->find_slave("slave2").slave, 2);
  EXPECT_EQ(client_->find_slave("31").slave, 31);
  EXPECT_EQ(client_->find_slave("0x1f").slave, 31);
  EXPECT_EQ(client_->find_slave("32").problem, "slave 32: out of range; allowed 0..31 or a slave's name");
  EXPECT_EQ(client_->find_slave("nobody").problem,
            "slave 'nobody': no slave has this name; allowed 0..31 or slave0, slave1, slave2, slave3");
}

TEST_F(ClientTest, OfTwoSlavesThatBearANameWhileNamesAreExchangedNeitherIsMeant) {
  Watched<bool> alike;
  const auto subscription = client_->on_slave_status([&](const SlaveStatus& status) {
    if (status.slave == 1) alike.change([&](bool& is) { is = dds::text(status.name) == "slave2"; });
  });
  daemon_->name_slave_1("slave2");
  ASSERT_TRUE(alike.wait([](bool is) { return is; }));
  const SlaveLookup found = client_->find_slave("slave2");
  EXPECT_FALSE(found.slave);
  EXPECT_EQ(found.problem,
            "slave 'slave2': slaves 1 and 2 bear this name at the moment; ask again, or give a number");
  EXPECT_EQ(client_->find_slave("slave3").slave, 3);
  daemon_->name_slave_1("slave1");
  ASSERT_TRUE(alike.wait([](bool is) { return !is; }));
  EXPECT_EQ(client_->find_slave("slave2").slave, 2);
}

TEST_F(ClientTest, ANameIsUnknownOnlyWhenAllNamesWereTold) {
  Watched<std::uint32_t> configured;
  const auto subscription = client_->on_master_status([&](const MasterStatus& status) {
    configured.change([&](std::uint32_t& mask) { mask = status.slaves_configured; });
  });
  daemon_->configure_slave_4();
  ASSERT_TRUE(configured.wait([](std::uint32_t mask) { return mask == 0b11111; }));
  EXPECT_EQ(client_->find_slave("slave2").slave, 2);
  EXPECT_EQ(
      client_->find_slave("nobody").problem,
      "slave 'nobody': the daemon has not told the names of all slaves yet; ask again, or give a number");
}

TEST_F(ClientTest, SubscriptionsHearWhatIsKnownAndWhatComes) {
  daemon_->publish_actual(1, 11);
  Watched<std::map<int, std::uint32_t>> seen;
  Subscription subscription = client_->on_actual_values([&](const ActualValues& values) {
    seen.change([&](auto& map) { map[values.slave] = values.raw[0]; });
  });
  EXPECT_TRUE(seen.wait([](const auto& map) { return map.contains(1) && map.at(1) == 11; }));
  daemon_->publish_actual(2, 22);
  EXPECT_TRUE(seen.wait([](const auto& map) { return map.contains(2); }));
  ASSERT_TRUE(client_->actual_values(2, gateway::kLongWait).has_value());
  EXPECT_EQ(client_->actual_values(2)->raw[0], 22u);
  EXPECT_EQ(client_->actual_values(3, milliseconds(0)), std::nullopt);

  subscription = Subscription();  // ends it: nothing is heard any more, by a second one it is
  Watched<std::uint32_t> second;
  const Subscription other = client_->on_actual_values(
      [&](const ActualValues& values) { second.change([&](auto& last) { last = values.raw[0]; }); });
  daemon_->publish_actual(3, 33);
  EXPECT_TRUE(second.wait([](std::uint32_t last) { return last == 33; }));
  EXPECT_FALSE(seen.get().contains(3));
}

TEST_F(ClientTest, EventsComeWithTheirHistory) {
  for (std::uint64_t number = 1; number <= 120; ++number) daemon_->publish_event(number);
  Watched<std::vector<std::uint64_t>> numbers;
  const Subscription subscription = client_->on_event(
      [&](const Event& event) { numbers.change([&](auto& list) { list.push_back(event.number); }); });
  EXPECT_TRUE(numbers.wait([](const auto& list) { return list.size() >= 100; }));
  daemon_->publish_event(121);
  EXPECT_TRUE(numbers.wait([](const auto& list) { return list.back() == 121; }));
  EXPECT_EQ(numbers.get().front(), 21u);
  const std::vector<Event> recent = client_->recent_events();
  ASSERT_EQ(recent.size(), 100u);
  EXPECT_EQ(recent.back().number, 121u);
}

class ReferenceWriters : public ClientTest {
 protected:
  bool seen(std::int32_t value) const {
    const auto values = daemon_->references();
    return std::find(values.begin(), values.end(), value) != values.end();
  }
  /// The daemon's thread takes references; a request that is answered afterwards is the fence.
  bool written_until(ReferenceWriter& writer, std::int32_t value) {
    const auto end = std::chrono::steady_clock::now() + gateway::kLongWait;
    while (!seen(value) && std::chrono::steady_clock::now() < end) {
      (void)writer.write(1, {value, 0, 0, 0}, 1);
      (void)client_->read(0, 1);
    }
    return seen(value);
  }
  /// The client knows who has telegram 1.
  static bool knows_the_owner(const Client& client) {
    const auto end = std::chrono::steady_clock::now() + gateway::kLongWait;
    while (client.master_status().reference_release[0].writer[0] == '\0') {
      if (std::chrono::steady_clock::now() > end) return false;
      std::this_thread::yield();
    }
    return true;
  }
};

/// Of the same strength, and of less.
class OtherReferenceWriter : public ReferenceWriters, public testing::WithParamInterface<std::int32_t> {};

TEST_P(OtherReferenceWriter, WritesNotOneSampleUntilTheOneThatHasTheTelegramReleasesIt) {
  constexpr std::int32_t kStrength = 10;
  Client other = Client::connect(options_for(places_.there));
  ReferenceWriter owner(*client_, kStrength);
  ReferenceWriter waiting(other, GetParam());
  ASSERT_TRUE(written_until(owner, 100));
  EXPECT_EQ(owner.write(1, {100, 0, 0, 0}, 1), "") << "it knows itself by its GUID";
  ASSERT_TRUE(knows_the_owner(other));
  const std::string refused = waiting.write(1, {1, 0, 0, 0}, 1);
  EXPECT_NE(refused.find("has it with strength 10"), std::string::npos) << refused;
  EXPECT_TRUE(waiting.waits());
  EXPECT_EQ(waiting.write(2, {2, 0, 0, 0}, 1), "") << "nobody has the other telegram";
  ASSERT_TRUE(written_until(owner, 101));
  EXPECT_FALSE(seen(1));
  EXPECT_EQ(daemon_->references_waited(), 0);
  owner.release(1);
  EXPECT_TRUE(written_until(waiting, 3));
  EXPECT_FALSE(waiting.waits());
}

INSTANTIATE_TEST_SUITE_P(Strengths, OtherReferenceWriter, testing::Values(10, 1));

TEST_F(ReferenceWriters, OneThatIsAskedToTakesOver) {
  Client other = Client::connect(options_for(places_.there));
  ReferenceWriter owner(*client_, 10);
  ASSERT_TRUE(written_until(owner, 100));
  ASSERT_TRUE(knows_the_owner(other));
  ReferenceWriter taking(other, kTakeOver);
  EXPECT_EQ(taking.strength(), 11);
  EXPECT_TRUE(written_until(taking, 200));
}

}  // namespace
}  // namespace cansync::client
