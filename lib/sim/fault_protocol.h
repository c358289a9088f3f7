#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "can/frame.h"
#include "sim/node_set.h"

namespace sim {

/// Identifiers by the name that fault scripts have for them: (id & mask) == identifier.
struct ChannelName {
  std::string_view name;
  std::uint32_t identifier = 0;
  std::uint32_t mask = 0;
};

/// What faults have to know of the protocol on a line. Pure functions; realtime safe.
class FaultProtocol {
 public:
  virtual ~FaultProtocol() = default;

  /// What the protocol calls a node, one word: the key of fault scripts for a node's number.
  virtual std::string_view node_word() const noexcept = 0;

  /// The channels that fault scripts may name. Lives as long as the program.
  virtual std::span<const ChannelName> channels() const noexcept = 0;

  /// The number of the node that a frame comes from or goes to; nothing when it names none.
  virtual std::optional<NodeNumber> node_of(const can::Frame& frame) const noexcept = 0;

  /// True when the frame is a node's answer to a question, which can be wrong or busy.
  virtual bool is_answer(const can::Frame& frame) const noexcept = 0;

  /// Makes of an answer the one to another question.
  virtual void make_wrong(can::Frame& answer) const noexcept = 0;

  /// Makes of an answer one that says busy and carries no data.
  virtual void make_busy(can::Frame& answer) const noexcept = 0;
};

/// What faults have to know of a protocol whose frames scripts name by identifier: nothing but its word.
class PlainFaults final : public FaultProtocol {
 public:
  /// `node_word`: a literal.
  explicit PlainFaults(std::string_view node_word) noexcept : node_word_(node_word) {}

  std::string_view node_word() const noexcept override { return node_word_; }
  std::span<const ChannelName> channels() const noexcept override { return {}; }
  std::optional<NodeNumber> node_of(const can::Frame&) const noexcept override { return std::nullopt; }
  bool is_answer(const can::Frame&) const noexcept override { return false; }
  void make_wrong(can::Frame&) const noexcept override {}
  void make_busy(can::Frame&) const noexcept override {}

 private:
  const std::string_view node_word_;
};

}  // namespace sim
