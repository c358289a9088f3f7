#pragma once

#include <cansync/j1939_function_blocks.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string_view>
#include <thread>
#include <vector>

#include "client/function_blocks/block_cycle.h"
#include "dds/bounded_text.h"
#include "dds/daemon_identity.h"
#include "dds/endpoint.h"
#include "dds/reply_partition.h"
#include "j1939/dds/topics.h"
#include "support/dds_places.h"

/// The function blocks of J1939 against a daemon without a bus.
namespace cansync::client::function_blocks {

/// Says what the daemon with address 0x21 would say, when the test wants it. Each object is a start of its
/// own.
class FakeMessageDaemon {
 public:
  /// A request of a client, and its bytes.
  struct Asked {
    j1939_MessageRequest sample;
    std::vector<std::uint8_t> data;
  };

  explicit FakeMessageDaemon(const gateway::dds::ParticipantOptions& place) : participant_(place) {
    static std::uint8_t starts = 0;
    identity_[0] = ++starts;
    gateway_GatewayStatus gateway = {};
    gateway::dds::copy_text(place.partition, gateway.bus);
    gateway::dds::copy_text("j1939", gateway.protocol);
    gateway.data_model = gateway_DATA_MODEL;
    gateway::dds::set_daemon(identity_, gateway);
    (void)gateway_writer_.write(gateway);
    gateway::dds::copy_text("error-active", bus.controller_state);
    (void)bus_writer_.write(bus);
    node.address = 0x21;
    claim("claimed");
  }

  void claim(std::string_view state) {
    gateway::dds::copy_text(state, node.claim_state);
    (void)node_writer_.write(node);
  }
  void tell_bus() { (void)bus_writer_.write(bus); }

  /// A message came; `lost` counts those that are in no batch.
  void message(std::uint32_t pgn, std::uint8_t destination, std::vector<std::uint8_t> data,
               j1939_MessageTransport transport = j1939_TRANSPORT_FRAME, std::uint64_t lost = 0) {
    j1939_ReceivedMessage received = {};
    received.pgn = pgn;
    received.priority = 3;
    received.source = 0x44;
    received.destination = destination;
    received.transport = transport;
    received.data._buffer = data.data();
    received.data._length = received.data._maximum = static_cast<std::uint32_t>(data.size());
    j1939_MessageBatch batch = {};
    batch.number = ++batches_;
    batch.lost = lost;
    batch.messages._buffer = &received;
    batch.messages._length = batch.messages._maximum = 1;
    (void)batch_writer_.write(batch);
  }

  /// As many frames of a byte that counts, in full batches.
  void burst(unsigned first, unsigned count) {
    std::vector<std::uint8_t> bytes(count);
    std::vector<j1939_ReceivedMessage> messages(count);
    for (unsigned i = 0; i < count; ++i) {
      bytes[i] = static_cast<std::uint8_t>(first + i);
      messages[i].pgn = 0xFEF1;
      messages[i].source = 0x44;
      messages[i].destination = 255;
      messages[i].data._buffer = &bytes[i];
      messages[i].data._length = messages[i].data._maximum = 1;
    }
    for (unsigned at = 0; at < count; at += j1939_MESSAGE_BATCH) {
      j1939_MessageBatch batch = {};
      batch.number = ++batches_;
      batch.messages._buffer = &messages[at];
      batch.messages._length = batch.messages._maximum = std::min<unsigned>(j1939_MESSAGE_BATCH, count - at);
      (void)batch_writer_.write(batch);
    }
  }

  std::vector<Asked> asked;
  bool answers = true;  ///< every request is done at once
  void take() {
    (void)request_reader_.take([this](const j1939_MessageRequest& sample) {
      EXPECT_EQ(gateway::dds::daemon_of(sample), identity_);
      Asked& one = asked.emplace_back();
      one.sample = sample;
      one.data.assign(sample.data._buffer, sample.data._buffer + sample.data._length);
      if (answers) reply(sample, gateway_REPLY_DONE);
    });
  }
  void reply(const j1939_MessageRequest& request, gateway_ReplyCode code, std::string_view reason = {}) {
    j1939_MessageReply sample = {};
    std::copy(std::begin(request.client), std::end(request.client), std::begin(sample.client));
    sample.request = request.request;
    sample.code = code;
    gateway::dds::copy_text(reason, sample.reason);
    (void)reply_writer_.write(sample);
  }

  gateway_BusStatus bus = {};
  j1939_NodeStatus node = {};

 private:
  gateway::dds::Participant participant_;
  gateway::dds::DaemonIdentity identity_ = {};
  gateway::dds::Writer<gateway_GatewayStatus> gateway_writer_{participant_};
  gateway::dds::Writer<gateway_BusStatus> bus_writer_{participant_};
  gateway::dds::Writer<j1939_NodeStatus> node_writer_{participant_};
  gateway::dds::Writer<j1939_AddressTable> table_writer_{participant_};
  gateway::dds::Writer<j1939_FaultList> fault_writer_{participant_};
  gateway::dds::Writer<j1939_MessageBatch> batch_writer_{participant_};
  gateway::dds::Writer<j1939_MessageReply> reply_writer_{
      participant_,
      gateway::dds::Partitions{gateway::dds::every_reply_partition(participant_.options().partition)},
      nullptr};
  gateway::dds::Reader<j1939_MessageRequest> request_reader_{participant_};
  gateway::dds::Reader<gateway_JobCancel> cancel_reader_{participant_};
  std::uint64_t batches_ = 0;
};

class MessageBlockTest : public ::testing::Test {
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

  TwoPlaces places;
  std::optional<FakeMessageDaemon> daemon{std::in_place, places.here};
  MessageConnection connection = MessageConnection::connect(options_at(places.there));
};

}  // namespace cansync::client::function_blocks
