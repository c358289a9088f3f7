#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "cansync.h"
#include "cansync/dds/topics.h"
#include "daemon/cansync/gateway/gateway.h"
#include "support/gateway_rig.h"
#include "support/virtual_line.h"

namespace cansyncd {

/// The settings of `gateway_config` for a line of four simulated drives.
inline Config whole_config() {
  Config config = gateway_config();
  config.master = support::line_settings(cansync::BitRate::mbit1, 4);
  // The computer may be slow; tests of stale requests switch this on.
  config.dds.request_max_age = std::chrono::milliseconds(0);
  return config;
}

/// A program that asks. Its replies are counted elsewhere; it has the readers a client has.
struct Asker {
  explicit Asker(const gateway::dds::ParticipantOptions& place)
      : client(place), transfer_replies(client.participant(), replies_to_all(place), &client.signal()) {}
  /// Until the gateway's side is matched on every topic.
  bool wait_for_gateway() {
    return client.wait_for_gateway() &&
           eventually(client.signal(), [&] { return transfer_replies.matched() > 0; });
  }
  bool wait_until_gone() {
    return client.wait_until_gone() &&
           eventually(client.signal(), [&] { return transfer_replies.matched() == 0; });
  }
  TestClient client;
  gateway::dds::Reader<cansync_TransferReply> transfer_replies;
};

/// The daemon but for its main program: the gateway over real DDS, and the realtime loop with simulated
/// drives in virtual time on a thread of its own. That time can be held, so that nothing depends on how fast
/// the computer is.
class WholeRig {
 public:
  using Codes = std::map<std::uint64_t, std::vector<gateway_ReplyCode>>;

  /// Comes back in active operation, with time held.
  explicit WholeRig(const Config& config = whole_config())
      : config_(config), line_(config.master, support::drives_for(config.master)), watcher_(places_.there) {
    line_.on_edge = [this](std::uint64_t) { at_edge(); };
    start_gateway();
    thread_ = std::thread([this] { line_.run(UINT64_MAX); });
    EXPECT_TRUE(watch([](const auto& status) {
      return status.option_status == static_cast<std::uint16_t>(cansync::State::active_master);
    }));
    hold();
  }
  ~WholeRig() {
    end_line();
    if (gateway_) gateway_->stop();
  }
  WholeRig(const WholeRig&) = delete;
  WholeRig& operator=(const WholeRig&) = delete;

  /// Time stands still afterwards, and the line may be touched. Only while there are SYNC edges.
  void hold() {
    std::unique_lock lock(mutex_);
    held_ = true;
    wait_until_parked(lock);
  }
  /// Time goes on.
  void release() {
    {
      const std::lock_guard lock(mutex_);
      held_ = false;
      edges_left_ = 0;
    }
    changed_.notify_all();
  }
  /// Time goes on for so many intervals, and is held again.
  void run(std::uint64_t edges) {
    std::unique_lock lock(mutex_);
    edges_left_ = edges;
    parked_ = false;
    changed_.notify_all();
    wait_until_parked(lock);
  }
  /// The realtime thread ends.
  void end_line() {
    line_.stop();
    release();
    if (thread_.joinable()) thread_.join();
  }

  Gateway& gateway() { return *gateway_; }
  /// The gateway is gone, and then there is a new one. The line must have ended, or time be held.
  void stop_gateway() {
    gateway_->stop();
    gateway_.reset();
    daemon_.reset();
    // Else the next one seems to be there before it is.
    EXPECT_TRUE(watcher_.wait_until_gone());
  }
  void start_gateway() {
    daemon_ = std::make_unique<gateway::dds::Participant>(places_.here);
    gateway_ = std::make_unique<Gateway>(config_, line_.exchange(), *daemon_, journal_, kTestDaemon);
    gateway_->start();
    EXPECT_TRUE(watcher_.wait_for_gateway());
  }

  /// Where programs look for the gateway.
  const gateway::dds::ParticipantOptions& client_place() const { return places_.there; }

  /// While time is held.
  support::VirtualLine& line() { return line_; }
  TestClient& watcher() { return watcher_.client; }
  std::unique_ptr<Asker> new_asker() {
    auto asker = std::make_unique<Asker>(places_.there);
    EXPECT_TRUE(asker->wait_for_gateway());
    return asker;
  }

  /// Waits for a status from now on.
  bool watch(const std::function<bool(const cansync_MasterStatus&)>& fits) {
    watcher_.client.all<cansync_MasterStatus>().clear();
    return watcher_.client.wait_for<cansync_MasterStatus>(fits).has_value();
  }
  bool watch_bus(const std::function<bool(const gateway_BusStatus&)>& fits) {
    watcher_.client.all<gateway_BusStatus>().clear();
    return watcher_.client.wait_for<gateway_BusStatus>(fits).has_value();
  }
  /// Waits for an event, also an earlier one.
  bool heard(std::string_view code) {
    return watcher_.client
        .wait_for<gateway_Event>([&](const auto& event) { return std::string_view(event.code) == code; })
        .has_value();
  }

  /// Replies so far to the client `identity`, by request number.
  const Codes& replies(std::uint8_t identity = 1) {
    take();
    return codes_[identity];
  }
  bool all_answered(std::uint64_t requests, std::uint8_t identity = 1) {
    return eventually(watcher_.client.signal(), [&] { return replies(identity).size() >= requests; });
  }

 private:
  void at_edge() {
    std::unique_lock lock(mutex_);
    if (edges_left_ > 0 && --edges_left_ > 0) return;
    if (!held_) return;
    parked_ = true;
    changed_.notify_all();
    changed_.wait(lock, [&] { return !held_ || edges_left_ > 0; });
    parked_ = false;
  }

  void wait_until_parked(std::unique_lock<std::mutex>& lock) {
    ASSERT_TRUE(changed_.wait_for(lock, std::chrono::seconds(60), [&] { return parked_; }))
        << "no SYNC edges";
  }

  template <class Reply>
  void take_from(std::vector<Reply>& replies) {
    for (const Reply& reply : replies) add(reply);
    replies.clear();
  }
  template <class Reply>
  void add(const Reply& reply) {
    codes_[reply.client[0]][reply.request].push_back(reply.code);
  }
  void take() {
    take_from(watcher_.client.all<cansync_ParameterReply>());
    take_from(watcher_.client.all<cansync_CommandReply>());
    watcher_.transfer_replies.take([this](const auto& reply) { add(reply); });
  }

  Config config_;
  TwoPlaces places_;
  support::VirtualLine line_;
  KeptJournal journal_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool held_ = false;
  bool parked_ = false;
  std::uint64_t edges_left_ = 0;
  Asker watcher_;
  std::map<std::uint8_t, Codes> codes_;
  std::unique_ptr<gateway::dds::Participant> daemon_;
  std::unique_ptr<Gateway> gateway_;
  std::thread thread_;
};

}  // namespace cansyncd
