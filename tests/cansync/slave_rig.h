#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cansync/slave/slave.h"

namespace cansync::test {

/// Number of the slave under test.
inline constexpr std::uint8_t kNumber = 5;

/// A frame written byte by byte from the manual's tables, so that the slave is held to the wire and not to
/// the project's own encoder.
inline can::Frame frame(std::uint32_t id, std::initializer_list<std::uint8_t> bytes) {
  can::Frame result;
  result.id = id;
  result.dlc = static_cast<std::uint8_t>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), result.data.begin());
  return result;
}
/// A frame of the command channel to the slave under test.
inline can::Frame command(std::initializer_list<std::uint8_t> bytes) {
  return frame(0x500 + kNumber, bytes);
}
/// A frame of the command channel from the slave under test.
inline can::Frame response(std::initializer_list<std::uint8_t> bytes) {
  return frame(0x580 + kNumber, bytes);
}

/// Notes every call, answers as told.
class RecordingApplication : public SlaveApplication {
 public:
  ParameterAnswer read_parameter(ParameterNumber number, Element element, SubSlave sub) noexcept override {
    note("read " + std::to_string(number.value()) + "." + std::to_string(element.value()) + "/" +
         std::to_string(sub.value));
    return parameter;
  }
  ParameterAnswer write_parameter(ParameterNumber number, Element, SubSlave sub, bool doubleword,
                                  std::uint32_t value) noexcept override {
    note("write " + std::to_string(number.value()) + "/" + std::to_string(sub.value) +
         (doubleword ? " dw " : " w ") + std::to_string(value));
    return parameter;
  }
  void parameter_dropped() noexcept override { note("dropped"); }
  BlockAnswer begin_block(const TransferInitialise& initialise) noexcept override {
    note("begin " + std::to_string(initialise.address));
    return block;
  }
  BlockAnswer read_block(std::uint16_t offset, std::span<std::uint8_t> out) noexcept override {
    note("get " + std::to_string(offset) + "+" + std::to_string(out.size()));
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<std::uint8_t>(offset + i + 1);
    return block;
  }
  BlockAnswer write_block(std::uint16_t offset, std::span<const std::uint8_t> data) noexcept override {
    note("put " + std::to_string(offset) + "+" + std::to_string(data.size()));
    if (!block.busy) taken.insert(taken.end(), data.begin(), data.end());
    return block;
  }
  void parameter_answered() noexcept override { note("parameter answered"); }
  void transfer_answered() noexcept override { note("transfer answered"); }
  void end_block(bool complete) noexcept override { note(complete ? "complete" : "cancelled"); }
  void sync_activated() noexcept override { note("activated"); }
  void control_word(std::uint16_t word) noexcept override { note("control " + std::to_string(word)); }
  void action(std::uint8_t number, std::uint8_t byte, std::uint16_t word) noexcept override {
    note("action " + std::to_string(number) + " " + std::to_string(byte) + " " + std::to_string(word));
  }

  void note(const std::string& text) { calls += (calls.empty() ? "" : ", ") + text; }
  std::string take() { return std::exchange(calls, ""); }

  ParameterAnswer parameter;
  BlockAnswer block;
  std::vector<std::uint8_t> taken;
  std::string calls;
};

/// A slave with an application that notes, led by hand through its states.
class SlaveTest : public ::testing::Test {
 protected:
  explicit SlaveTest(SlaveSideSettings settings = {}) : slave_(numbered(settings), application_) {}

  static SlaveSideSettings numbered(SlaveSideSettings settings) {
    settings.number = *SlaveNumber::from(kNumber);
    return settings;
  }
  void set_up() {
    EXPECT_TRUE(slave_.control(ControlCommand::handshake));
    EXPECT_TRUE(slave_.control(ControlCommand::take_over_initialisation));
    EXPECT_TRUE(slave_.control(ControlCommand::start_synchronous));
    EXPECT_EQ(slave_.state(), State::setting_up_slave);
  }
  void activate() {
    set_up();
    EXPECT_TRUE(slave_.control(ControlCommand::enable_active));
    EXPECT_EQ(slave_.state(), State::active_slave);
  }
  std::optional<can::Frame> send(const can::Frame& sent) {
    const auto answer = slave_.receive(sent, kAskedAt);
    return answer ? std::optional(answer->frame) : std::nullopt;
  }
  /// End of what `send` sends, after the edge.
  static constexpr Duration kAskedAt = std::chrono::microseconds(100);

  RecordingApplication application_;
  Slave slave_;
};

}  // namespace cansync::test
