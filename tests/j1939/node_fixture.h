#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "j1939/node_rig.h"

namespace j1939::test {

/// A node that has its address and provides three groups.
class NodeTest : public ::testing::Test {
 protected:
  NodeTest() : rig(settings()) { rig.claimed(); }

  static NodeSettings settings() {
    NodeSettings all = settings_at(kOwn);
    all.provided = {{0xFEE5, 6, counting(8)}, {0xFEEB, 6, counting(20)}, {0xFEEC, 6, {}}};
    return all;
  }
  Order message(OrderId id, Pgn number, std::size_t size) {
    data = counting(size);
    return {.id = id, .number = number, .priority = 3, .timeout = milliseconds(100), .memory = data};
  }
  Order request(OrderId id, Pgn number, Address destination) {
    return {.id = id,
            .kind = OrderKind::request,
            .number = number,
            .destination = destination,
            .timeout = milliseconds(1250),
            .memory = data};
  }
  Answer only_answer() {
    const auto all = rig.answers();
    EXPECT_EQ(all.size(), 1u);
    return all.empty() ? Answer{} : all[0];
  }

  NodeRig rig;
  std::vector<std::uint8_t> data = std::vector<std::uint8_t>(kMostBytes);
};

}  // namespace j1939::test
