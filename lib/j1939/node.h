#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "can/bounded_list.h"
#include "can/frame.h"
#include "j1939/address_claim.h"
#include "j1939/message.h"
#include "j1939/order.h"
#include "j1939/pgn_filter.h"
#include "j1939/transport_receiver.h"
#include "j1939/transport_sender.h"

namespace j1939 {

/// A group that others may request of the node, and that it may send by itself.
struct Provided {
  Pgn number = 0;
  std::uint8_t priority = 6;       ///< 0..7
  std::vector<std::uint8_t> data;  ///< 1..1785 bytes; none: somebody else answers, and the node says nothing
  Time period{
      0};  ///< between two times that it is sent to all, while an address is held; 0: on request alone
};

/// What a node is and takes.
struct NodeSettings {
  ClaimSettings claim;
  PgnFilter filter;
  bool between_others = false;  ///< messages in one frame from one other node to another are received too
  std::uint16_t queue = 64;     ///< messages that may wait to be sent, 1..Node::kMostQueue
  /// Bytes of a message by the extended transport protocol, in both directions; up to 1785: there is none.
  std::size_t most_bytes = 65'536;
  std::uint8_t window = 16;                      ///< packets of a connection asked for at once, 1..255
  Time spacing = std::chrono::milliseconds(50);  ///< between two packets of a broadcast, 10..200 ms
  std::vector<Provided> provided;
};

/// Counts since the start; they never fall.
struct NodeCounters {
  std::uint64_t frames = 0;      ///< of others, with 29-bit identifier and data
  std::uint64_t foreign = 0;     ///< of others, of any other kind: not J1939
  std::uint64_t messages = 0;    ///< whole ones for this node or all
  std::uint64_t taken = 0;       ///< of them, taken by a range
  std::uint64_t sent = 0;        ///< own frames that stood on the bus
  std::uint64_t unanswered = 0;  ///< orders that ended with refused, aborted or no_answer
  std::uint64_t not_sent = 0;    ///< orders that ended without being sent
};

/// A controller application on a bus: its address, messages in both directions, requests and their answers.
///
/// Sans-IO: it is told what came and when, asked what to send, and asked when it must be told the time again.
/// Realtime safe after its construction, which allocates; one thread.
class Node {
 public:
  static constexpr std::size_t kMostQueue = 64;
  static constexpr std::size_t kMostRequests = 32;
  static constexpr std::size_t kMostHandedOver = 8;
  static constexpr std::size_t kMostOpen =
      kMostQueue + kMostRequests + kMostHandedOver + TransportSender::kSessions;

  /// A message for whoever uses the node.
  struct Delivery {
    Message message;
    std::uint8_t range = 0;  ///< position of the range that takes it
  };

  /// A `queue` outside its range counts as the nearest inside. May allocate.
  explicit Node(NodeSettings settings);
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  /// Begins to claim the address. Once, before all else.
  void start(Time now) noexcept;

  /// A frame of another node stood on the bus until `end`. The message that it completes, when a range takes
  /// it; its data stay until the next call of `receive`.
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
  void held_back(Obstacle obstacle) noexcept { obstacle_ = obstacle; }
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
  /// Orders that wait to be handed over, 0..kMostQueue + kMostRequests.
  std::size_t waiting() const noexcept { return waiting_.size(); }
  /// Another frame may be handed over now: there is a place for it.
  bool has_place() const noexcept { return !handed_over_.full(); }
  /// Frames handed over that were not seen on the bus, 0..kMostHandedOver.
  std::size_t handed_over_count() const noexcept { return handed_over_.size(); }
  /// Messages in packets that are under way, in both directions.
  std::size_t transports() const noexcept { return receiver_.open() + sender_.open(); }
  /// Short answers of the node itself for which there was no room.
  std::uint64_t answers_lost() const noexcept { return replies_.lost(); }

 private:
  struct Open {
    Order order;
    Time until{};
    std::uint64_t answer = 0;  ///< of a request that is on the bus: what was coming at `until`; 0: nothing
  };
  enum class Owner : std::uint8_t { claim, reply, order, session };
  struct Offer {
    Owner owner = Owner::claim;
    std::size_t index = 0;  ///< of the waiting order, or the session
    can::Frame frame;
  };
  struct HandedOver {
    can::Frame frame;
    Owner owner = Owner::claim;
    std::size_t session = 0;
    std::uint64_t id = 0;    ///< of the session's job
    Open open;               ///< of an order
    bool answered = false;   ///< of an order: its echo was missed
    bool overtaken = false;  ///< a later frame was seen on the bus, or its echo may be lost
  };
  struct Sending {
    Open open;
    std::uint64_t id = 0;   ///< of the job
    bool internal = false;  ///< the node's own answer to a request
  };

  // --- receiving (node_receive.cpp)
  std::optional<Delivery> receive_frame(const can::Frame& frame, const Identifier& from, Time end) noexcept;
  /// Somebody here takes such a long message of `source`; others get no session.
  bool wanted(Pgn number, Address source) const noexcept;
  void transport_control(const can::Frame& frame, const Identifier& from, Time end) noexcept;
  void extended_control(const can::Frame& frame, const Identifier& from, Time end) noexcept;
  bool may_begin(const can::Frame& frame, const Identifier& from, Pgn by) noexcept;
  std::optional<Delivery> deliver(const Message& message) noexcept;
  void take_request(const Message& message) noexcept;
  void provide(const Provided& provided, const Message& request) noexcept;
  /// False: too many messages in packets are under way. `by_itself`: while the one before waits, another is
  /// not sent.
  bool send_provided(const Provided& provided, Address to, bool by_itself = false) noexcept;
  void send_periodic() noexcept;
  Time next_periodic() const noexcept;
  void acknowledge(const Message& request, Pgn number, std::uint8_t control) noexcept;
  void take_acknowledgement(const Message& message) noexcept;
  void answer_asked(const Message& message) noexcept;

  // --- sending (node_send.cpp)
  can::Frame frame_for(const Order& order, Address source) const noexcept;
  void begin_sessions() noexcept;
  void take_ended() noexcept;
  void seen(const HandedOver& entry, Time end_of_frame) noexcept;
  void unseen(const HandedOver& entry) noexcept;
  void overtake(std::size_t count) noexcept;

  // --- orders and their ends, and the address (node.cpp)
  bool wants_claims_of_all(const Order& order) const noexcept;
  bool has_room(const Order& order) const noexcept;
  void follow_address() noexcept;
  void end(const Order& order, Outcome outcome, const Answer& rest = {}) noexcept;
  void end_waiting(Outcome outcome) noexcept;
  void end_asked(Outcome outcome) noexcept;
  void end_unanswered() noexcept;
  std::size_t open() const noexcept;

  NodeSettings settings_;
  std::vector<Time> due_;  ///< of each group provided; Time::max(): no address was held yet
  std::size_t queue_;
  AddressClaim claim_;
  FrameQueue replies_;
  TransportReceiver receiver_;
  TransportSender sender_;
  can::BoundedList<Open, kMostQueue + kMostRequests> waiting_;
  can::BoundedList<HandedOver, kMostHandedOver> handed_over_;
  can::BoundedList<Sending, TransportSender::kSessions> sending_;
  can::BoundedList<Open, kMostRequests> asked_;  ///< requests on the bus whose answer is waited for
  can::BoundedList<Answer, kMostOpen> answers_;
  std::size_t requests_ = 0;  ///< open orders that are requests
  std::uint64_t jobs_ = 0;    ///< of the sender, so far
  std::optional<Offer> offer_;
  std::optional<Address> own_;  ///< the address as `follow_address` saw it last
  Obstacle obstacle_ = Obstacle::none;
  can::Frame last_;  ///< memory of a message in one frame
  NodeCounters counters_;
  Time now_{};
  bool stopped_ = false;
};

}  // namespace j1939
