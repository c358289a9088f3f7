#pragma once

#include <cstddef>
#include <cstdint>

namespace sim {

/// Most nodes beside the master on one line.
inline constexpr std::size_t kMostNodes = 32;

/// By which faults and traces name a node, 0..31: its number in its protocol, or what that maps it to.
using NodeNumber = std::uint8_t;

/// A set of nodes by their numbers; bit n stands for number n.
struct NodeSet {
  std::uint32_t bits = 0;

  static constexpr NodeSet all() noexcept { return {0xFFFFFFFFu}; }
  static constexpr NodeSet of(NodeNumber node) noexcept { return {1u << node}; }
  constexpr bool has(NodeNumber node) const noexcept { return ((bits >> node) & 1u) != 0; }
  constexpr void add(NodeNumber node) noexcept { bits |= 1u << node; }
  constexpr void add(NodeSet nodes) noexcept { bits |= nodes.bits; }
  constexpr bool empty() const noexcept { return bits == 0; }
  friend constexpr bool operator==(NodeSet, NodeSet) = default;
};

}  // namespace sim
