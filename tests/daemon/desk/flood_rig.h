#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "cansync/dds/topics.h"
#include "dds/endpoint.h"
#include "dds/participant.h"
#include "good_requests.h"
#include "support/gateway_rig.h"
#include "support/long_wait.h"

namespace cansyncd {

/// Counts what would go to the journal: what a test keeps must not look like growth of the daemon.
class CountedJournal : public JournalSink {
 public:
  void write(LogPriority /*priority*/, EventCode /*event*/, const std::string& /*message*/,
             const std::vector<JournalField>& /*fields*/) override {
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
  explicit Flood(const gateway::dds::Participant& participant)
      : reads_(participant), commands_(participant) {}

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
    const std::uint64_t before = written_;
    write(1);
    EXPECT_EQ(written_, before + 2) << "DDS did not take the last requests of the flood";
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

  gateway::dds::Writer<cansync_ParameterRequest> reads_;
  gateway::dds::Writer<cansync_Command> commands_;
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
    // Both were answered once before the flood: what a program waits for while DDS makes it known to the
    // gateway is not what is tested here.
    EXPECT_TRUE(serve_other());
    EXPECT_TRUE(settle());
  }

  /// Floods with `pairs` requests of each kind while the other is served, until all is answered. Fails when
  /// the other waited too long, or the end did not come.
  testing::AssertionResult run(std::uint64_t pairs) {
    flood_.begin(pairs);
    testing::AssertionResult served = testing::AssertionSuccess();
    do {
      served = serve_other();
    } while (served && !flood_.ended());
    flood_.join();
    return served ? settle() : served;
  }

  std::uint64_t written() const { return flood_.written(); }
  std::uint64_t answered() const { return answered_; }
  std::uint64_t others() const { return others_; }
  std::uint64_t journal_entries() const { return journal_.entries(); }

 private:
  testing::AssertionResult serve_other() {
    const std::uint64_t number = ++others_;
    other_.write(good_read(number, 2));
    return serve_until("the answer to the other program", [&] { return other_done_ == number; });
  }
  /// Until the gateway has answered everything: those asked last are done last of their queues.
  testing::AssertionResult settle() {
    do {
      last_read_ = flood_.last();
      read_code_.reset();
      command_code_.reset();
      const auto last = serve_until("the answers to the last read and the last command",
                                    [&] { return read_code_ && command_code_; });
      if (!last) return last;
      // Refused as long as too many others are open.
    } while (read_code_ != gateway_REPLY_DONE || command_code_ != gateway_REPLY_DONE);
    // Those that were refused unread are answered after those that were read.
    const auto all =
        serve_until("the answers to all the rest", [&] { return answered_ >= flood_.written(); });
    return all ? serve_other() : all;
  }
  template <class Condition>
  testing::AssertionResult serve_until(const char* what, Condition&& condition) {
    const auto end = std::chrono::steady_clock::now() + gateway::kLongWait;
    while (!condition()) {
      if (std::chrono::steady_clock::now() > end) {
        return testing::AssertionFailure()
               << what << " did not come within " << gateway::kLongWait.count() << " s: asked by the other "
               << others_ << ", answered up to " << other_done_ << "; written by the flood "
               << flood_.written() << ", answered " << answered_ << "; last read " << last_read_
               << (read_code_ ? " answered" : " open") << ", last command "
               << (command_code_ ? "answered" : "open");
      }
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
    return testing::AssertionSuccess();
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
    drain<cansync_CommandReply>(other_, [](const auto&) {});
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
  std::optional<gateway_ReplyCode> read_code_;
  std::optional<gateway_ReplyCode> command_code_;
  std::uint64_t answered_ = 0;
};

}  // namespace cansyncd
