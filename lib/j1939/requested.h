#pragma once

#include <cstddef>
#include <cstdint>

#include "can/bounded_list.h"
#include "j1939/answers.h"
#include "j1939/codec.h"
#include "j1939/message.h"
#include "j1939/order.h"
#include "j1939/transport_receiver.h"

namespace j1939 {

/// An order that was taken, and until when.
struct OpenOrder {
  Order order;
  Time until{};
};

/// Requests that stood on the bus, each to one node, whose answer is waited for. Realtime safe; one thread.
class Requested {
 public:
  /// Both must outlive it.
  Requested(Answers& answers, const TransportReceiver& receiver) noexcept
      : answers_(answers), receiver_(receiver) {}

  /// There is always room: no more than kMostRequests are open.
  void add(const OpenOrder& open) noexcept { asked_.push({open, 0}); }
  /// One waits for this group from this node.
  bool waits_for(Pgn number, Address source) const noexcept;
  /// A message came: it is the answer to all that wait for it.
  void answered(const Message& message) noexcept;
  /// The node `message.source` acknowledged a request.
  void acknowledged(const Message& message, const Acknowledgement& said) noexcept;
  /// Waits for the answer of one no more; its request was on the bus. False: there is none.
  bool cancel(OrderId id) noexcept;
  /// Ends every one for this reason.
  void end_all(JobEnd end) noexcept;

  /// Ends those whose time is over at `now`. An answer that is coming in packets then is waited for, and no
  /// other: whoever begins again and again would hold its place.
  void advance(Time now) noexcept;
  /// When `advance` must be called at the latest; Time::max(): no time is waited for.
  Time next_deadline() const noexcept;
  /// Requests that wait, 0..kMostRequests.
  std::size_t size() const noexcept { return asked_.size(); }

 private:
  struct Asked {
    OpenOrder open;
    std::uint64_t answer = 0;  ///< what was coming when its time was over; 0: nothing, or not over
  };
  template <class Ends>
  void end_where(Pgn number, Address source, Ends ends) noexcept;

  Answers& answers_;
  const TransportReceiver& receiver_;
  can::BoundedList<Asked, kMostRequests> asked_;
};

}  // namespace j1939
