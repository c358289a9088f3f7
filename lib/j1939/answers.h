#pragma once

#include <cstddef>
#include <optional>

#include "can/bounded_list.h"
#include "j1939/counters.h"
#include "j1939/order.h"
#include "j1939/transport_sender.h"

namespace j1939 {

/// Most messages that may wait to be sent.
inline constexpr std::size_t kMostMessages = 64;
/// Most requests that may be open, wherever they are.
inline constexpr std::size_t kMostRequests = 32;
/// Most frames handed over that were not seen on the bus.
inline constexpr std::size_t kMostHandedOver = 8;
/// Most orders that were taken and whose answer was not.
inline constexpr std::size_t kMostOpen =
    kMostMessages + kMostRequests + kMostHandedOver + TransportSender::kSessions;

using can::JobKnown;

/// The outcome of an order without a final answer (can/job_ending.h). Pure; realtime safe.
Outcome outcome_of(JobKnown known, JobEnd end) noexcept;

/// The one answer to each order, until it is taken. Whoever takes an order sees to it that no more than
/// kMostOpen are open. Realtime safe; one thread.
class Answers {
 public:
  /// The counters must outlive it.
  explicit Answers(NodeCounters& counters) noexcept : counters_(counters) {}

  /// An order was taken, and is to be ended once.
  void begin(const Order& order) noexcept;
  /// It ended; `rest`: what else there is to say.
  void end(const Order& order, Outcome outcome, const Answer& rest = {}) noexcept;
  /// It ended without a final answer.
  void end(const Order& order, JobKnown known, JobEnd end, Answer rest = {}) noexcept;
  /// The oldest answer that was not taken yet.
  std::optional<Answer> take() noexcept;

  /// Answers that were not taken, 0..kMostOpen.
  std::size_t size() const noexcept { return answers_.size(); }
  /// Orders begun and not ended that are requests, 0..kMostRequests.
  std::size_t requests() const noexcept { return requests_; }

 private:
  NodeCounters& counters_;
  can::BoundedList<Answer, kMostOpen> answers_;
  std::size_t requests_ = 0;
};

}  // namespace j1939
