#pragma once

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "j1939/node_rig.h"

/// A node that has its address, and messages of three packets.
namespace j1939::test {

using std::chrono::seconds;

/// Bytes of a message of 20: three packets.
inline const std::vector<std::uint8_t> kTwenty = counting(20);

inline can::Frame packet_of(std::uint32_t identifier, const std::vector<std::uint8_t>& data,
                            unsigned number) {
  can::Frame out = frame(identifier, {static_cast<int>(number)});
  out.dlc = 8;
  for (unsigned i = 0; i < 7; ++i) {
    const std::size_t at = (number - 1) * 7 + i;
    out.data[i + 1] = at < data.size() ? data[at] : 0xFF;
  }
  return out;
}

class TransportTest : public ::testing::Test {
 protected:
  TransportTest() { rig.claimed(); }
  explicit TransportTest(NodeSettings settings) : rig(std::move(settings)) { rig.claimed(); }

  Refusal send(OrderId id, Address destination, std::vector<std::uint8_t>& data, Time timeout = seconds(60)) {
    return rig.node.submit({.id = id,
                            .number = 0xFEF2,
                            .priority = 7,
                            .destination = destination,
                            .timeout = timeout,
                            .memory = data},
                           rig.now);
  }
  can::Frame packet_out(const std::vector<std::uint8_t>& data, unsigned number, int destination) {
    return packet_of(0x1CEB0080u | static_cast<std::uint32_t>(destination) << 8, data, number);
  }

  NodeRig rig;
  std::vector<std::uint8_t> twenty = kTwenty;
};

}  // namespace j1939::test
