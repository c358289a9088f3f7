#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <vector>

#include "cansync/sim/drive_parameters.h"
#include "sim/faults.h"
#include "whole_rig.h"

/// Requests to a whole rig, the replies to them, and what disturbs them.
namespace cansyncd {

/// First start address of a transfer.
inline constexpr std::uint32_t kData = 0x1000;
/// Identity of who gives the commands that are a cause.
inline constexpr std::uint8_t kOperator = 2;
/// Identity of requests that only mark an instant.
inline constexpr std::uint8_t kMarker = 3;

/// A read or write that a simulated drive answers; `timeout` in ms.
inline cansync_ParameterRequest parameter(std::uint64_t number, std::uint32_t of_slave, bool writes,
                                          std::uint32_t timeout) {
  auto request = TestClient::request<cansync_ParameterRequest>(number);
  request.slave = of_slave;
  request.write = writes;
  request.number = writes ? sim::parameter::first_plain_word : sim::parameter::operating_mode;
  request.element = 7;
  request.format = cansync_FORMAT_WORD;
  request.timeout = timeout;
  return request;
}

/// An upload that takes many telegrams; `timeout` in ms.
inline cansync_TransferRequest transfer(std::uint64_t number, std::uint32_t of_slave, std::uint32_t timeout) {
  auto request = TestClient::request<cansync_TransferRequest>(number);
  request.slave = of_slave;
  request.address = kData;
  request.length = 1200;
  request.timeout = timeout;
  return request;
}

/// A command of this kind that nothing is wrong with.
inline cansync_Command command(std::uint64_t number, cansync_CommandKind kind) {
  auto sample = TestClient::request<cansync_Command>(number);
  sample.kind = kind;
  sample.slave = 1;
  // A word that enables no drive is sent also to a slave that does not answer.
  sample.control_word = cansync::StartupSettings{}.enabling_control_bits;
  sample.priority = 1;
  sample.slave_mask = 0xF;
  sample.action = 200;
  sample.mode = cansync_MODE_RUN;
  sample.polling_one = sample.polling_two = sample.maximum_slave = -2;
  sample.cursor_control_word = sample.cursor_parameter = sample.cursor_transfer = -2;
  return sample;
}

/// Waits until the gateway has taken everything that came, and told everything the master had ended before.
inline void pass_marker(WholeRig& rig) {
  static std::uint64_t number = 0;
  // The pass that takes the first may have begun before.
  for (int i = 0; i < 2; ++i) {
    auto a = parameter(++number, 9, false, 0);
    auto b = transfer(++number, 9, 0);
    auto c = command(++number, cansync_COMMAND_CONTROL_WORD);
    c.slave = 9;
    a.client[0] = b.client[0] = c.client[0] = kMarker;
    rig.watcher().write(a);
    rig.watcher().write(b);
    rig.watcher().write(c);
    ASSERT_TRUE(eventually(rig.watcher().signal(), [&] {
      const auto& codes = rig.replies(kMarker);
      return codes.contains(number) && codes.contains(number - 1) && codes.contains(number - 2);
    }));
  }
}

/// Gives the operator's order to change the mode of the line.
inline void order(WholeRig& rig, cansync_Mode mode) {
  auto sample = command(1, cansync_COMMAND_MODE);
  sample.client[0] = kOperator;
  sample.mode = mode;
  rig.watcher().deliver(sample);
}

/// A fault of this kind from now on, of one slave or of all.
inline sim::Fault fault(sim::FaultKind kind, std::optional<std::uint8_t> of_slave = std::nullopt) {
  sim::Fault out;
  out.kind = kind;
  if (of_slave) out.slave = slave(*of_slave);
  return out;
}

/// Adds this fault to each slave that requests name.
inline void add(WholeRig& rig, sim::FaultKind kind) {
  for (const std::uint8_t number : {std::uint8_t{1}, std::uint8_t{2}, std::uint8_t{3}}) {
    (void)rig.line().line().faults().add(fault(kind, number));
  }
}

/// Replies to requests 1 to `count`, each of which must have exactly one; the last is waited for.
inline std::vector<gateway_ReplyCode> only_replies(WholeRig& rig, std::uint64_t count) {
  EXPECT_TRUE(rig.all_answered(count));
  pass_marker(rig);
  std::vector<gateway_ReplyCode> out;
  for (const auto& [number, codes] : rig.replies()) {
    EXPECT_EQ(codes.size(), 1u) << "request " << number;
    out.push_back(codes.front());
  }
  EXPECT_EQ(out.size(), count);
  return out;
}

}  // namespace cansyncd
