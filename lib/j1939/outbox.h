#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "can/bounded_list.h"
#include "can/frame.h"
#include "j1939/address_claim.h"
#include "j1939/answers.h"
#include "j1939/counters.h"
#include "j1939/order.h"
#include "j1939/requested.h"
#include "j1939/transport_receiver.h"
#include "j1939/transport_sender.h"

namespace j1939 {

/// What bounds an outbox.
struct OutboxSettings {
  std::size_t messages = kMostMessages;  ///< that may wait, 1..kMostMessages
  std::size_t most_bytes = 0;            ///< of a message; up to 1785 in any case
  Time spacing{};                        ///< between two packets of a broadcast
};

/// Everything that a node sends, on its way to the bus and until it is answered: its claim and its replies,
/// orders that wait or stand in the controller, and messages in packets. Realtime safe; one thread.
class Outbox {
 public:
  /// Everything it refers to must outlive it.
  Outbox(const OutboxSettings& settings, AddressClaim& claim, FrameQueue& replies,
         const TransportReceiver& receiver, NodeCounters& counters) noexcept;
  Outbox(const Outbox&) = delete;
  Outbox& operator=(const Outbox&) = delete;

  /// Takes an order, which then has exactly one answer, or says why not.
  Refusal submit(const Order& order, Time now) noexcept;
  /// Takes an order back that is not in the controller. False: there is none.
  bool cancel(OrderId id) noexcept;
  /// The frame to be handed to the bus next; nothing: none now.
  std::optional<can::Frame> next_frame() noexcept;
  /// The bus took what `next_frame` said.
  void handed_over() noexcept;
  /// What keeps the first waiting order from the bus.
  void held_back(Obstacle obstacle) noexcept { obstacle_ = obstacle; }
  /// An own frame stood on the bus until `end`.
  void echo(const can::Frame& frame, Time end) noexcept;
  /// Frames were lost on their way here, echoes perhaps too.
  void echoes_lost() noexcept;
  /// Takes no more orders, and ends those that are open.
  void stop() noexcept;

  /// What becomes of the node's own message in packets.
  enum class OwnMessage : std::uint8_t {
    taken,    ///< it begins as soon as there is room, in turn with orders
    waiting,  ///< the same one waits already
    full,     ///< too many others wait
  };
  /// Sends the node's own message in packets, whose end nobody hears of. The data stay where they are. Only while an
  /// address is held.
  OwnMessage send_own(Pgn number, std::uint8_t priority, Address to,
                      std::span<const std::uint8_t> data) noexcept;
  /// Whatever was handed over is gone; no message in packets goes on.
  void controller_emptied() noexcept;
  /// What was begun with an address that the node has no longer ends.
  void address_changed() noexcept;
  /// There is no address, and none to come: nothing that needs one waits any longer.
  void no_address_to_come() noexcept { end_waiting(JobEnd::lost); }
  /// It is `now`, or later: nothing is done.
  void time_is(Time now) noexcept { now_ = std::max(now_, now); }
  /// Ends the orders whose message in packets has ended, and begins those for which there is room.
  void follow_packets() noexcept;
  /// It is `now`: does what is due.
  void advance(Time now) noexcept;
  /// When `advance` must be called at the latest; Time::max() when nothing waits for time to pass.
  Time next_deadline() const noexcept;

  /// The other node's words about messages in packets go there; `follow_packets` after.
  TransportSender& packets() noexcept { return sender_; }
  /// As of now.
  const TransportSender& packets() const noexcept { return sender_; }
  /// What may be the answer to a request goes there.
  Requested& requested() noexcept { return requested_; }
  /// As of now.
  const Requested& requested() const noexcept { return requested_; }
  /// Of orders that have ended.
  Answers& answers() noexcept { return answers_; }
  /// Orders that wait to be handed over, 0..kMostMessages + kMostRequests.
  std::size_t waiting() const noexcept { return waiting_.size(); }
  /// Another frame may be handed over now.
  bool has_place() const noexcept { return !handed_over_.full(); }
  /// Frames handed over that were not seen on the bus, 0..kMostHandedOver.
  std::size_t handed_over_count() const noexcept { return handed_over_.size(); }

 private:
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
    OpenOrder open;          ///< of an order
    bool answered = false;   ///< of an order: its echo was missed
    bool overtaken = false;  ///< a later frame was seen on the bus, or its echo may be lost
  };
  /// Of the node, and begun as soon as there is room.
  struct Own {
    Pgn number = 0;
    std::uint8_t priority = 6;
    Address to = 0;
    std::span<const std::uint8_t> data;
  };
  static constexpr std::size_t kMostOwn = 64;
  struct Sending {
    OpenOrder open;
    std::uint64_t id = 0;   ///< of the job
    bool internal = false;  ///< the node's own
  };

  std::size_t open() const noexcept;
  bool has_room(const Order& order) const noexcept;
  void begin_sessions() noexcept;
  std::size_t next_own() const noexcept;
  std::size_t next_order() const noexcept;
  void seen(const HandedOver& entry, Time end_of_frame) noexcept;
  void unseen(const HandedOver& entry) noexcept;
  void overtake(std::size_t count) noexcept;
  void advance_sending() noexcept;
  void advance_handed_over() noexcept;
  void advance_waiting() noexcept;
  void end_waiting(JobEnd end) noexcept;
  void take_back_unbegun() noexcept;
  void end_sending(JobEnd end) noexcept;
  JobKnown known_of(const Sending& sending) const noexcept;
  void end_handed_over(JobEnd end) noexcept;

  OutboxSettings settings_;
  AddressClaim& claim_;
  FrameQueue& replies_;
  NodeCounters& counters_;
  TransportSender sender_;
  Answers answers_;
  Requested requested_;
  can::BoundedList<OpenOrder, kMostMessages + kMostRequests> waiting_;
  can::BoundedList<HandedOver, kMostHandedOver> handed_over_;
  can::BoundedList<Sending, TransportSender::kSessions> sending_;
  can::BoundedList<Own, kMostOwn> own_waiting_;
  bool orders_turn_ = false;  ///< of an own message and an order that may begin, the order does
  std::uint64_t jobs_ = 0;    ///< of the sender, so far
  std::optional<Offer> offer_;
  Obstacle obstacle_ = Obstacle::none;
  Time now_{};
  bool stopped_ = false;
};

}  // namespace j1939
