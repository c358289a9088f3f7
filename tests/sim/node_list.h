#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "can/frame_length.h"
#include "scripted_node.h"

namespace sim::test {

/// The nodes of a line that is to be made.
using Nodes = std::vector<std::unique_ptr<Node>>;
using Texts = std::vector<std::string>;

/// Adds a node and returns it; the line will own it.
template <class NodeType, class... Args>
NodeType& add(Nodes& nodes, Args... args) {
  auto node = std::make_unique<NodeType>(args...);
  NodeType& reference = *node;
  nodes.push_back(std::move(node));
  return reference;
}

/// How long a frame takes at 1 Mbit/s, where a bit is a microsecond; with the interframe space.
inline can::Time length(std::string_view what) {
  return us(can::frame_bits(frame(what)));
}

/// What the master has received, one text for each frame.
inline Texts texts(const std::vector<can::ReceivedFrame>& received) {
  Texts all;
  for (const auto& one : received) all.push_back(text(one.frame));
  return all;
}

/// What a node has heard, one text for each frame.
inline Texts heard(const ListeningNode& node) {
  Texts all;
  for (const auto& one : node.heard) all.push_back(one.frame);
  return all;
}

}  // namespace sim::test
