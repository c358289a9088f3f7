#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "can/job_ending.h"
#include "can/obstacle.h"
#include "j1939/identifier.h"

/// What a node is asked to send, and how that ended.
namespace j1939 {

/// By which an order is answered; chosen by whoever gives it, below 2^63.
using OrderId = std::uint64_t;

/// What an order is for; from 0 without gaps.
enum class OrderKind : std::uint8_t {
  send,     ///< a message
  request,  ///< a request for a group (PGN 59904); of one destination also its answer
};

/// Something to be sent.
struct Order {
  OrderId id = 0;
  OrderKind kind = OrderKind::send;
  Pgn number = 0;                        ///< what is sent, or asked for (`is_pgn`)
  std::uint8_t priority = 6;             ///< 0..7
  Address destination = kGlobalAddress;  ///< 0..253, or all; PDU2 in one frame: all
  Time timeout{};                        ///< monitoring time from `submit` to the answer, over 0
  /// Of a message its data, as many bytes as the node's settings allow; over 1785 to one destination alone;
  /// of a request the memory for those of its answer. It stays where it is until the order has been answered.
  std::span<std::uint8_t> memory = {};
};

/// It goes in packets.
constexpr bool is_long(const Order& order) noexcept {
  constexpr std::size_t kFrameBytes = 8;
  return order.kind == OrderKind::send && order.memory.size() > kFrameBytes;
}

/// Why an order is not taken; nothing was sent.
enum class Refusal : std::uint8_t {
  none,
  queue_full,        ///< as many orders are open as there is room for: try again when one has been answered
  bad_order,         ///< no group, priority or destination that can be
  too_long,          ///< more bytes than the node's settings allow
  too_long_for_all,  ///< over 1785 bytes, and not to one destination
  no_address,        ///< the node has no address, and none to come
  stopped,           ///< the node has been stopped
};

using can::JobEnd;
using can::Obstacle;

/// How an order ended.
enum class Outcome : std::uint8_t {
  done,          ///< the message stood on the bus whole, or was acknowledged, or the request was answered
  refused,       ///< the other node answered that it will not (`code`: control byte of PGN 59392)
  aborted,       ///< the receiver broke the connection off (`code`: its reason)
  no_answer,     ///< begun, but not seen on the bus whole, or not answered, before its end
  timeout,       ///< nothing of it was handed over in time; it will not be sent
  cancelled,     ///< taken back before anything of it was handed over
  address_lost,  ///< the node lost its address before anything of it was handed over
  stopped,       ///< the node was stopped before anything of it was handed over
};

/// The one answer to an order that was taken.
struct Answer {
  OrderId id = 0;
  Outcome outcome = Outcome::done;
  Time sent{};                         ///< done: end of the last frame, or of the answer
  Obstacle obstacle = Obstacle::none;  ///< timeout: what kept it from the bus
  bool claiming = false;               ///< timeout: nothing did, the address was still being claimed
  JobEnd ended_by = JobEnd::time;      ///< no_answer: what ended it
  std::uint8_t code = 0;               ///< refused, aborted
  std::uint32_t size = 0;              ///< request, done: bytes of the answer, in the order's memory
};

}  // namespace j1939
