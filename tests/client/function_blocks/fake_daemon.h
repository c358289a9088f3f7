#pragma once

#include <cansync/function_blocks/module_codes.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "client/function_blocks/block_cycle.h"
#include "dds/bounded_text.h"
#include "dds/daemon_identity.h"
#include "dds/endpoint.h"
#include "dds/gateway_topics.h"
#include "dds/reply_partition.h"
#include "support/dds_places.h"

namespace cansync::client::function_blocks {

/// Since when a made-up daemon reads requests: DDS finds the endpoints of a program one by one.
enum class Reads { at_once, later };

/// What a daemon of any protocol says, when the test wants it; it has no bus. Each object is a start of its
/// own.
class FakeDaemon {
 public:
  void tell_bus() { (void)bus_writer_.write(bus); }

  gateway_BusStatus bus = {};

 protected:
  FakeDaemon(const gateway::dds::ParticipantOptions& place, std::string_view protocol) : participant_(place) {
    static std::uint8_t starts = 0;
    identity_[0] = ++starts;
    gateway_GatewayStatus gateway = {};
    gateway::dds::copy_text(place.partition, gateway.bus);
    gateway::dds::copy_text(protocol, gateway.protocol);
    gateway.data_model = gateway_DATA_MODEL;
    gateway::dds::set_daemon(identity_, gateway);
    (void)gateway_writer_.write(gateway);
    gateway::dds::copy_text("error-active", bus.controller_state);
  }
  ~FakeDaemon() = default;

  /// The sample is meant for this start.
  template <class Sample>
  void expect_meant(const Sample& sample) const {
    EXPECT_EQ(gateway::dds::daemon_of(sample), identity_);
  }

  template <class Reply, class Request>
  static Reply reply_to(const Request& request, gateway_ReplyCode code, std::string_view reason) {
    Reply sample = {};
    std::copy(std::begin(request.client), std::end(request.client), std::begin(sample.client));
    sample.request = request.request;
    sample.code = code;
    gateway::dds::copy_text(reason, sample.reason);
    return sample;
  }

  /// Writes once a client is known to read it: DDS finds its readers one by one, and what is written before
  /// may be lost.
  template <class Sample>
  static void write_to_client(gateway::dds::Writer<Sample>& writer, const Sample& sample) {
    EXPECT_TRUE(repeat_until(std::this_thread::yield, [&] { return writer.matched() != 0; }));
    (void)writer.write(sample);
  }

  gateway::dds::Participant participant_;
  gateway::dds::DaemonIdentity identity_ = {};
  /// Of replies.
  gateway::dds::Partitions clients_{gateway::dds::every_reply_partition(participant_.options().partition)};

 private:
  gateway::dds::Writer<gateway_GatewayStatus> gateway_writer_{participant_};
  gateway::dds::Writer<gateway_BusStatus> bus_writer_{participant_};
  gateway::dds::Reader<gateway_JobCancel> cancel_reader_{participant_};
};

/// Function blocks that need no time, on a connection to such a daemon.
template <class Daemon, class Connection>
class BlockTest : public ::testing::Test {
 protected:
  /// Calls the block and lets the daemon listen until `condition` holds.
  template <class Block, class Condition>
  bool call_until(Block& block, Condition&& condition) {
    return repeat_until(
        [&] {
          block.call();
          daemon->take();
          std::this_thread::yield();
        },
        condition);
  }

  /// Starts the daemon anew without its reader of requests, and calls the block until it has taken something
  /// to send.
  template <class Block>
  void restart_unread(Block& block) {
    daemon.reset();
    daemon.emplace(places.here, Reads::later);
    const auto call = [&] {
      block.Snd = true;
      block.call();
    };
    ASSERT_TRUE(repeat_until(call, [&] { return block.error().find("started anew") != std::string::npos; }));
    ASSERT_TRUE(repeat_until(call, [&] { return block.RETVAL == module_code::done; })) << block.error();
    for (int i = 0; i < 10; ++i) block.call();
  }

  TwoPlaces places;
  std::optional<Daemon> daemon{std::in_place, places.here};
  Connection connection = Connection::connect(options_at(places.there));
};

}  // namespace cansync::client::function_blocks
