#pragma once

#include <cansync/j1939_function_blocks.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "client/function_blocks/fake_daemon.h"
#include "dds/bounded_text.h"
#include "j1939/dds/topics.h"

/// The function blocks of J1939 against a daemon without a bus.
namespace cansync::client::function_blocks {

/// Says what the daemon with address 0x21 would say, when the test wants it. Each object is a start of its
/// own.
class FakeMessageDaemon : public FakeDaemon {
 public:
  /// A request of a client, and its bytes.
  struct Asked {
    j1939_MessageRequest sample;
    std::vector<std::uint8_t> data;
  };

  explicit FakeMessageDaemon(const gateway::dds::ParticipantOptions& place, Reads reads = Reads::at_once)
      : FakeDaemon(place, "j1939") {
    if (reads == Reads::at_once) read_requests();
    tell_bus();
    node.address = 0x21;
    claim("claimed");
  }

  void read_requests() { request_reader_.emplace(participant_); }
  void claim(std::string_view state) {
    gateway::dds::copy_text(state, node.claim_state);
    (void)node_writer_.write(node);
  }

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
    write_to_client(batch_writer_, batch);
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
      write_to_client(batch_writer_, batch);
    }
  }

  std::vector<Asked> asked;
  bool answers = true;  ///< every request is done at once
  void take() {
    if (!request_reader_) return;
    (void)request_reader_->take([this](const j1939_MessageRequest& sample) {
      expect_meant(sample);
      Asked& one = asked.emplace_back();
      one.sample = sample;
      one.data.assign(sample.data._buffer, sample.data._buffer + sample.data._length);
      if (answers) reply(sample, gateway_REPLY_DONE);
    });
  }
  void reply(const j1939_MessageRequest& request, gateway_ReplyCode code, std::string_view reason = {}) {
    write_to_client(reply_writer_, reply_to<j1939_MessageReply>(request, code, reason));
  }

  j1939_NodeStatus node = {};

 private:
  gateway::dds::Writer<j1939_NodeStatus> node_writer_{participant_};
  gateway::dds::Writer<j1939_AddressTable> table_writer_{participant_};
  gateway::dds::Writer<j1939_FaultList> fault_writer_{participant_};
  gateway::dds::Writer<j1939_MessageBatch> batch_writer_{participant_};
  gateway::dds::Writer<j1939_MessageReply> reply_writer_{participant_, clients_, nullptr};
  std::optional<gateway::dds::Reader<j1939_MessageRequest>> request_reader_;
  std::uint64_t batches_ = 0;
};

using MessageBlockTest = BlockTest<FakeMessageDaemon, MessageConnection>;

}  // namespace cansync::client::function_blocks
