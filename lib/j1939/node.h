#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "can/frame.h"
#include "j1939/address_claim.h"
#include "j1939/codec.h"
#include "j1939/counters.h"
#include "j1939/message.h"
#include "j1939/order.h"
#include "j1939/outbox.h"
#include "j1939/pgn_filter.h"
#include "j1939/provider.h"
#include "j1939/transport_receiver.h"

namespace j1939 {

/// What a node is and takes.
struct NodeSettings {
  ClaimSettings claim;
  PgnFilter filter;
  bool between_others = false;  ///< messages in one frame from one other node to another are received too
  std::uint16_t queue = 64;     ///< messages that may wait to be sent, 1..kMostMessages
  /// Bytes of a message by the extended transport protocol, in both directions; up to 1785: there is none.
  std::size_t most_bytes = 65'536;
  std::uint8_t window = 16;                      ///< packets of a connection asked for at once, 1..255
  Time spacing = std::chrono::milliseconds(50);  ///< between two packets of a broadcast, 10..200 ms
  std::vector<Provided> provided;
};

/// A controller application on a bus: its address, messages in both directions, requests and their answers.
///
/// Sans-IO: it is told what came and when, asked what to send, and asked when it must be told the time again.
/// Realtime safe after its construction, which allocates; one thread.
class Node {
 public:
  /// A message for whoever uses the node.
  struct Delivery {
    Message message;
    std::optional<std::uint8_t> range;  ///< position of the range that takes it; nothing: it tells of faults
  };

  /// A `queue` outside its range counts as the nearest inside. May allocate.
  explicit Node(NodeSettings settings);
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  /// Begins to claim the address. Once, before all else.
  void start(Time now) noexcept;

  /// A frame of another node stood on the bus until `end`. The message that it completes, when a range takes
  /// it or it tells of faults; its data stay until the next call of `receive`.
  std::optional<Delivery> receive(const can::Frame& frame, Time end) noexcept;

  /// Takes an order, which is then answered exactly once (`take_answer`), or says why not.
  Refusal submit(const Order& order, Time now) noexcept;
  /// Takes an order back that is not in the controller; it is answered as cancelled. False: there is none.
  bool cancel(OrderId id) noexcept;

  /// The frame to be handed to the bus next; nothing: none now. Say what became of it by `handed_over` or
  /// `held_back`.
  std::optional<can::Frame> next_frame() noexcept;
  /// The bus took what `next_frame` said.
  void handed_over() noexcept;
  /// What keeps the first waiting order from the bus.
  void held_back(Obstacle obstacle) noexcept { outbox_.held_back(obstacle); }
  /// An own frame stood on the bus until `end`.
  void echo(const can::Frame& frame, Time end) noexcept;
  /// Whatever was handed over is gone from the controller, and the node claims its address anew.
  void controller_emptied() noexcept;
  /// Frames were lost on their way here, echoes perhaps too.
  void echoes_lost() noexcept;

  /// It is `now`: does what is due.
  void advance(Time now) noexcept;
  /// When `advance` must be called at the latest; Time::max() when nothing waits for time to pass.
  Time next_deadline() const noexcept;
  /// The oldest answer that was not taken yet.
  std::optional<Answer> take_answer() noexcept;
  /// Takes no more orders, and ends those that are open.
  void stop() noexcept;

  /// As of now.
  const AddressClaim& claim() const noexcept { return claim_; }
  /// As of now.
  const NodeCounters& counters() const noexcept { return counters_; }
  /// As of now.
  const ReceiverCounters& received_packets() const noexcept { return receiver_.counters(); }
  /// Orders that wait to be handed over, 0..kMostMessages + kMostRequests.
  std::size_t waiting() const noexcept { return outbox_.waiting(); }
  /// Another frame may be handed over now: there is a place for it.
  bool has_place() const noexcept { return outbox_.has_place(); }
  /// Frames handed over that were not seen on the bus, 0..kMostHandedOver.
  std::size_t handed_over_count() const noexcept { return outbox_.handed_over_count(); }
  /// Messages in packets that are under way, in both directions.
  std::size_t transports() const noexcept { return receiver_.open() + outbox_.packets().open(); }
  /// Answers of the node itself for which there was no room.
  std::uint64_t answers_lost() const noexcept { return replies_.lost() + provider_.unanswered(); }
  /// Times that a group with a period was due and left out.
  std::uint64_t groups_left_out() const noexcept { return provider_.left_out(); }

 private:
  std::optional<Delivery> receive_frame(const can::Frame& frame, const Identifier& from, Time end) noexcept;
  /// Somebody here takes such a long message of `source`; others get no session.
  bool wanted(Pgn number, Address source) const noexcept;
  void transport_control(const TransportControl& said, const Identifier& from, Time end) noexcept;
  bool may_begin(const TransportControl& said, Address source) noexcept;
  std::optional<Delivery> deliver(const Message& message) noexcept;
  void take(const Message& message) noexcept;
  void take_request(const Message& message, Pgn number) noexcept;
  void take_acknowledgement(const Message& message, const Acknowledgement& said) noexcept;
  void follow_address() noexcept;

  NodeSettings settings_;  ///< but for what is provided
  NodeCounters counters_;
  AddressClaim claim_;
  FrameQueue replies_;
  TransportReceiver receiver_;
  Outbox outbox_;
  Provider provider_;
  std::optional<Address> own_;  ///< the address as `follow_address` saw it last
  can::Frame last_;             ///< memory of a message in one frame
  Time now_{};
};

}  // namespace j1939
