#pragma once

#include <array>
#include <cstdint>

/// How a request ends that has no final answer, by what is known of it: one table for every protocol and every
/// kind of request, so that no word claims more than is known. Pure; realtime safe.
namespace can {

/// What is known of a request when it ends without its final answer.
enum class JobKnown : std::uint8_t {
  not_sent,     ///< nothing that changes something was handed to the bus: the receiver has nothing
  handed_over,  ///< something was, seen on the bus or not: whether the receiver acted on it is not known
  taken,        ///< the receiver has said that it has it, and not how it ended
};
inline constexpr unsigned kJobKnown = 3;

/// What ends it. A client that cancels, has gone or has lost its connection is `cancelled`.
enum class JobEnd : std::uint8_t {
  unanswered,  ///< the answer did not come when it was due, and it is not asked again
  time,        ///< the monitoring time is over
  cancelled,
  stopped,  ///< the master, station, node or daemon was stopped
  lost,     ///< the receiver stopped answering, or the node lost its address
};
inline constexpr unsigned kJobEnds = 5;

/// What is said of it. `cancelled`, `stopped` and `lost` say that the receiver has nothing; `no_answer` that it
/// is not known; `taken` that the receiver has it; `timeout` that the time was over before it was handed over,
/// or while the receiver was busy with it.
enum class JobEnding : std::uint8_t { no_answer, timeout, cancelled, stopped, lost, taken };

/// The one ending of each pair.
constexpr JobEnding ending_of(JobKnown known, JobEnd end) noexcept {
  using E = JobEnding;
  // By JobEnd, then JobKnown: not sent, handed over, taken.
  constexpr std::array<std::array<E, kJobKnown>, kJobEnds> kEndings = {{
      {E::no_answer, E::no_answer, E::taken},  // unanswered
      {E::timeout, E::no_answer, E::timeout},  // time
      {E::cancelled, E::no_answer, E::taken},  // cancelled
      {E::stopped, E::no_answer, E::taken},    // stopped
      {E::lost, E::no_answer, E::taken},       // lost
  }};
  return kEndings[static_cast<unsigned>(end)][static_cast<unsigned>(known)];
}

}  // namespace can
