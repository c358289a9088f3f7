#pragma once

#include <cstdint>
#include <vector>

#include "j1939/address_claim.h"
#include "j1939/codec.h"
#include "j1939/message.h"
#include "j1939/outbox.h"
#include "j1939/transport.h"

namespace j1939 {

/// A group that others may request of the node, and that it may send by itself.
struct Provided {
  Pgn number = 0;
  std::uint8_t priority = 6;       ///< 0..7
  std::vector<std::uint8_t> data;  ///< 1..1785 bytes; none: somebody else answers, and the node says nothing
  Time period{
      0};  ///< between two times that it is sent to all, while an address is held; 0: on request alone
};

/// The groups that a node provides: answers requests for them, and sends those with a period by itself. What has no
/// room waits for it, each group once for each that it is for.
/// Realtime safe after its construction, which allocates; one thread.
class Provider {
 public:
  /// Everything it refers to must outlive it.
  Provider(std::vector<Provided> provided, const AddressClaim& claim, FrameQueue& replies, Outbox& outbox);

  /// A request for `number` came: it is answered, or refused when it is no group of these.
  void requested(const Message& request, Pgn number) noexcept;
  /// It is `now`: sends what is due. What went by while no address was held is left out, and so is a group whose
  /// message of before waits still.
  void advance(Time now) noexcept;
  /// When `advance` must be called at the latest, as of `now`; Time::max(): no time is waited for.
  Time next_deadline(Time now) const noexcept;
  /// Nothing more is sent by itself.
  void stop() noexcept { stopped_ = true; }
  /// Times that a group was due and left out, because that of before waited still or there was no room.
  std::uint64_t left_out() const noexcept { return left_out_; }
  /// Requests of a node to all that had to stay without an answer: too many others waited.
  std::uint64_t unanswered() const noexcept { return unanswered_; }

 private:
  Outbox::OwnMessage send(const Provided& provided, Address to, bool by_itself) noexcept;
  void acknowledge(const Message& request, Pgn number, Acknowledgement::Kind kind) noexcept;

  std::vector<Provided> provided_;
  std::vector<Time> due_;  ///< of each; Time::max(): no address was held yet
  const AddressClaim& claim_;
  FrameQueue& replies_;
  Outbox& outbox_;
  std::uint64_t left_out_ = 0;
  std::uint64_t unanswered_ = 0;
  bool stopped_ = false;
};

}  // namespace j1939
