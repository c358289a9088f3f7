#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <type_traits>
#include <variant>

#include "can/bus.h"
#include "can/link_facts.h"
#include "j1939/address_claim.h"
#include "j1939/message.h"
#include "j1939/node.h"
#include "j1939/order.h"
#include "j1939/transport.h"
#include "rt/latest_value.h"
#include "rt/spsc_ring.h"
#include "rt/wake_signal.h"

/// Everything that the realtime thread of a bus of J1939 and its gateway thread share. The gateway writes
/// `requests` and reads the rest; the realtime thread the other way round. All of it is bounded, allocated at
/// the start and wait-free on both sides.
namespace cansyncd {

/// Takes back an order that has not ended; no answer of its own: the order answers. An unknown one is
/// ignored.
struct CancelMessage {
  j1939::OrderId id = 0;
};

/// A request of the gateway. Each Order has exactly one `MessageDone`, until which its memory stays.
using J1939Request = std::variant<j1939::Order, CancelMessage>;

/// The one answer to an Order.
struct MessageDone {
  j1939::Answer answer;
  j1939::Refusal refusal = j1939::Refusal::none;  ///< not none: nothing was sent, `answer` has the id alone
  can::Time sent_time{0};                         ///< done: CLOCK_REALTIME
};

/// A message that a range takes, or that tells of faults. Over 8 bytes its data are the next entries of `long_data`, as many as
/// `pieces_of` says.
struct MessageReport {
  j1939::Pgn number = 0;
  std::uint8_t priority = 0;
  std::uint8_t source = 0;
  std::uint8_t destination = 0;
  j1939::Transport transport = j1939::Transport::frame;
  bool taken = true;          ///< by a range
  std::uint8_t range = 0;     ///< its position
  std::uint32_t size = 0;     ///< bytes
  can::Time receive_time{0};  ///< CLOCK_REALTIME of the last bit
  std::array<std::uint8_t, 8> data = {};
};

/// The data of a long message, or a piece of those of one of over 1785 bytes.
using LongData = std::array<std::uint8_t, j1939::kMostBytes>;
/// Pieces that so many bytes take.
constexpr std::size_t pieces_of(std::size_t bytes) noexcept {
  return (bytes + j1939::kMostBytes - 1) / j1939::kMostBytes;
}

/// The claims of others that were heard.
struct AddressSnapshot {
  std::array<j1939::Name, j1939::ClaimTable::kAddresses> names = {};
  std::array<bool, j1939::ClaimTable::kAddresses> claimed = {};
};

/// State of the bus and the node; written when it changes and ten times a second.
struct NodeSnapshot {
  can::ControllerStatus controller;
  can::TimestampSource timestamps = can::TimestampSource::thread;
  j1939::ClaimState claim = j1939::ClaimState::listening;
  std::int16_t address = -1;  ///< claimed, or being claimed; -1: none
  bool name_twice = false;
  std::uint64_t losses = 0;
  std::uint64_t intruders = 0;
  j1939::NodeCounters counters;
  j1939::ReceiverCounters packets;
  std::uint64_t answers_lost = 0;
  std::uint64_t groups_left_out = 0;
  std::uint64_t lost = 0;        ///< messages that had no room in `messages` or `long_data`
  std::uint32_t waiting = 0;     ///< orders that wait to be handed over
  std::uint32_t transports = 0;  ///< messages in packets under way
  std::uint32_t bus_load = 0;    ///< permille, of the last second
};

/// The shared structures. Constructed before both threads, destroyed after both.
///
/// The realtime thread takes a request only while `done` has room for the answer of every order it has taken,
/// so that no answer can be lost. What still waits in `requests` when it stops is answered as stopped, as far
/// as there is room; once it has ended, whatever is left was never begun.
struct J1939Exchange {
  /// Long messages that may wait for the gateway, and beside them so many of the longest.
  static constexpr std::size_t kLongMessages = 64;
  static constexpr std::size_t kLongest = 2;

  /// `request_queue` and `report_queue`: entries of `requests` and of `messages`; `most_bytes`: of the
  /// longest message.
  J1939Exchange(std::size_t request_queue, std::size_t report_queue, std::size_t most_bytes)
      : requests(request_queue),
        done(request_queue + j1939::kMostOpen),
        messages(report_queue),
        long_data(kLongMessages + kLongest * pieces_of(most_bytes)) {}

  rt::SpscRing<J1939Request> requests;   ///< gateway -> realtime
  rt::SpscRing<MessageDone> done;        ///< realtime -> gateway
  rt::SpscRing<MessageReport> messages;  ///< realtime -> gateway, lossy
  rt::SpscRing<LongData> long_data;      ///< realtime -> gateway, written before the entry of `messages`
  rt::LatestValue<NodeSnapshot> status;
  rt::LatestValue<AddressSnapshot> addresses;
  rt::LatestValue<can::LinkFacts> link;  ///< of the thread that watches the interface
  rt::WakeSignal gateway_wake;           ///< signalled when anything above was written for the gateway
};

}  // namespace cansyncd
