#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "can/frame.h"
#include "j1939/node.h"

/// A node on a bus of its own, in virtual time: what it sends stands on the bus at once.
namespace j1939::test {

using std::chrono::milliseconds;

/// A frame with these fields: an identifier and its bytes.
inline can::Frame frame(std::uint32_t identifier, std::initializer_list<int> bytes) {
  can::Frame out;
  out.id = identifier;
  out.extended = true;
  for (const int byte : bytes) out.data[out.dlc++] = static_cast<std::uint8_t>(byte);
  return out;
}

/// Bytes that count up, from 1 on.
inline std::vector<std::uint8_t> counting(std::size_t size) {
  std::vector<std::uint8_t> data(size);
  for (std::size_t i = 0; i < size; ++i) data[i] = static_cast<std::uint8_t>(i + 1);
  return data;
}

/// A message as it was given out, with its own copy of the data.
struct Got {
  Message message;
  std::vector<std::uint8_t> data;
  static constexpr std::uint8_t kNoRange = 0xFF;
  std::uint8_t range = 0;
};

/// NAME of the node: an arbitrary address, identity 0x12345 of manufacturer 7.
inline constexpr NameFields kFields = {
    .identity = 0x12345, .manufacturer = 7, .function = 0x80, .arbitrary_address = true};
/// Of the same form, with a stronger and a weaker value.
inline constexpr Name kStronger = 0x10;
inline constexpr Name kWeaker = ~Name{0};
inline constexpr Address kOwn = 0x80;
inline constexpr Address kOther = 0x21;

inline NodeSettings settings_at(Address address) {
  NodeSettings settings;
  settings.claim.name = compose(kFields);
  settings.claim.preferred = address;
  settings.filter.add({});
  return settings;
}

/// "18EEFF80#45230E..." would be unreadable in tests: the identifier and the bytes apart.
class NodeRig {
 public:
  explicit NodeRig(NodeSettings settings = settings_at(kOwn)) : node(std::move(settings)) { node.start(now); }

  /// All that the node wants to send now, each seen on the bus at once.
  std::vector<can::Frame> pump() {
    std::vector<can::Frame> all;
    node.advance(now);
    while (const auto next = node.next_frame()) {
      node.handed_over();
      if (echoes) node.echo(*next, now);
      all.push_back(*next);
      node.advance(now);
      if (all.size() > 4000) break;
    }
    return all;
  }

  /// Time goes on to `until`, from one deadline to the next; what the node sends meanwhile.
  std::vector<can::Frame> run_to(Time until) {
    std::vector<can::Frame> all = pump();
    while (node.next_deadline() <= until) {
      now = std::max(now, node.next_deadline());
      const auto more = pump();
      all.insert(all.end(), more.begin(), more.end());
    }
    now = until;
    const auto more = pump();
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  std::vector<can::Frame> run(Time time) { return run_to(now + time); }

  /// Claims the address, which nobody contests.
  NodeRig& claimed() {
    (void)run(milliseconds(250));
    return *this;
  }

  /// A frame of another; then what the node sends because of it.
  std::vector<can::Frame> hear(const can::Frame& heard) {
    node.advance(now);
    if (const auto delivery = node.receive(heard, now)) {
      Got got{delivery->message,
              {delivery->message.data.begin(), delivery->message.data.end()},
              delivery->range.value_or(Got::kNoRange)};
      got.message.data = {};
      messages.push_back(std::move(got));
    }
    return pump();
  }

  /// The claim of `address` by another.
  std::vector<can::Frame> hear_claim(Address address, Name name) {
    can::Frame claim = frame(0x18EEFF00u | address, {});
    claim.dlc = 8;
    for (unsigned i = 0; i < 8; ++i) claim.data[i] = static_cast<std::uint8_t>(name >> 8 * i);
    return hear(claim);
  }

  std::vector<Answer> answers() {
    std::vector<Answer> all;
    while (const auto answer = node.take_answer()) all.push_back(*answer);
    return all;
  }

  Time now = std::chrono::seconds(1);
  bool echoes = true;
  Node node;
  std::vector<Got> messages;
};

/// The claim of the rig's node for `address`.
inline can::Frame own_claim(Address address) {
  return frame(0x18EEFF00u | address, {0x45, 0x23, 0xE1, 0x00, 0x00, 0x80, 0x00, 0x80});
}

/// Sends a message of `size` bytes from one node to another that takes `window` packets at once; each frame
/// of the one is heard by the other, and it must arrive whole, once.
inline void expect_whole_between_two(std::size_t size, unsigned window) {
  NodeSettings receiver = settings_at(kOther);
  receiver.claim.name = kStronger;
  receiver.window = static_cast<std::uint8_t>(window);
  NodeRig from;
  NodeRig to(receiver);
  from.claimed();
  to.claimed();
  std::vector<std::uint8_t> data = counting(size);
  ASSERT_EQ(from.node.submit({.id = 1,
                              .number = 0xEF00,
                              .destination = kOther,
                              .timeout = std::chrono::seconds(60),
                              .memory = data},
                             from.now),
            Refusal::none);
  std::vector<can::Frame> outgoing = from.pump();
  while (!outgoing.empty()) {
    std::vector<can::Frame> back;
    for (const auto& one : outgoing) {
      for (const auto& answer : to.hear(one)) back.push_back(answer);
    }
    outgoing.clear();
    for (const auto& one : back) {
      for (const auto& next : from.hear(one)) outgoing.push_back(next);
    }
  }
  ASSERT_EQ(to.messages.size(), 1u) << size << " " << window;
  EXPECT_EQ(to.messages[0].data, data);
  EXPECT_EQ(from.answers().at(0).outcome, Outcome::done);
}

}  // namespace j1939::test
