#pragma once

#include <cstdint>

namespace j1939 {

/// Counts of a node since the start; they never fall.
struct NodeCounters {
  std::uint64_t frames = 0;      ///< of others, with 29-bit identifier and data
  std::uint64_t foreign = 0;     ///< of others, of any other kind: not J1939
  std::uint64_t messages = 0;    ///< whole ones for this node or all
  std::uint64_t taken = 0;       ///< of them, taken by a range
  std::uint64_t sent = 0;        ///< own frames that stood on the bus
  std::uint64_t unanswered = 0;  ///< orders that ended with refused, aborted or no_answer
  std::uint64_t not_sent = 0;    ///< orders that ended without being sent
  // For this node or all, and not understood: claims, commands, requests, acknowledgements, and what speaks of packets.
  std::uint64_t wrong_length = 0;  ///< not as many bytes as their group has
  std::uint64_t unknown = 0;       ///< a first byte that their group does not know
};

}  // namespace j1939
