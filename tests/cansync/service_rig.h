#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cansync/slave/slave_service.h"
#include "slave_rig.h"

namespace cansync::test {

/// Notes what a slave's service tells.
struct ServiceRecord final : SlaveServiceListener {
  void asked(const AskedParameter& job) noexcept override {
    parameter = job;
    note((job.write ? "write " : "read ") + std::to_string(job.number.value()));
  }
  void dropped(std::uint64_t id) noexcept override { note("dropped " + std::to_string(id)); }
  void answered(std::uint64_t id) noexcept override { note("answered " + std::to_string(id)); }
  void block_begun(const AskedBlock& asked) noexcept override {
    block = asked;
    note((asked.direction == AskedBlock::Direction::upload ? "upload " : "download ") +
         std::to_string(asked.length) + (asked.area ? " area" : " single"));
  }
  void block_complete(std::uint64_t) noexcept override { note("complete"); }
  void step_asked(std::uint64_t, const AskedStep& asked) noexcept override {
    step = asked;
    note("step " + std::to_string(asked.offset) + "+" + std::to_string(asked.bytes));
  }
  void block_ended(std::uint64_t, BlockEnd end) noexcept override {
    constexpr const char* kNames[] = {"done", "cancelled", "refused", "timed out", "application gone"};
    note(kNames[static_cast<unsigned>(end)]);
  }
  void control_word(std::uint16_t word) noexcept override { note("control " + std::to_string(word)); }
  void action(std::uint8_t command, std::uint8_t, std::uint16_t) noexcept override {
    note("action " + std::to_string(command));
  }
  void sync_activated() noexcept override { note("activated"); }

  void note(const std::string& text) { notes += (notes.empty() ? "" : ", ") + text; }
  std::string take() { return std::exchange(notes, ""); }

  AskedParameter parameter;
  AskedBlock block;
  AskedStep step;
  std::string notes;
};

/// A slave in set-up, with a service behind it and an application at hand; every answer is on the bus at
/// once.
class ServiceTest : public ::testing::Test {
 protected:
  explicit ServiceTest(const SlaveServiceSettings& settings = service_settings())
      : service_(settings, told_), slave_(slave_settings(), service_) {
    for (const auto command : {ControlCommand::handshake, ControlCommand::take_over_initialisation,
                               ControlCommand::start_synchronous}) {
      EXPECT_TRUE(slave_.control(command));
    }
    service_.set_application(true);
  }

  static SlaveSideSettings slave_settings() {
    SlaveSideSettings settings;
    settings.number = *SlaveNumber::from(kNumber);
    settings.block_limit = 4095;
    return settings;
  }
  /// 400: a word 0..100 in the table; 401: read only; 402: not available; 500: a doubleword of the
  /// application, 501: a word of it with limits -10..10, 502: a word of it that is read only.
  static SlaveServiceSettings service_settings() {
    using Access = ParameterDefinition::Access;
    SlaveServiceSettings settings;
    settings.parameters = {
        {400, false, Access::read_write, 7, 0, 100, true, false},
        {401, true, Access::read_only, 0x12345678, 0, 0, false, false},
        {402, false, Access::not_available, 0, 0, 0, false, false},
        {500, true, Access::read_write, 0, 0, 0, false, true},
        {501, false, Access::read_write, 0, -10, 10, true, true},
        {502, false, Access::read_only, 0, 0, 0, false, true},
    };
    return settings;
  }

  std::optional<can::Frame> send(const can::Frame& frame, bool echo = true) {
    const auto answer = slave_.receive(frame, std::chrono::microseconds(400));
    if (!answer) return std::nullopt;
    EXPECT_TRUE(slave_.may_start(*answer, std::chrono::microseconds(420)));
    if (echo) slave_.sent(answer->frame);
    return answer->frame;
  }
  static can::Frame read(unsigned number) {
    return command(
        {static_cast<std::uint8_t>(0x70 | (number >> 8)), static_cast<std::uint8_t>(number & 0xFF), 0, 0});
  }
  static can::Frame busy(unsigned number) {
    return response(
        {static_cast<std::uint8_t>(0x40 | (number >> 8)), static_cast<std::uint8_t>(number & 0xFF)});
  }
  static can::Frame error(unsigned number, std::uint16_t code) {
    return response({static_cast<std::uint8_t>(0x20 | (number >> 8)),
                     static_cast<std::uint8_t>(number & 0xFF), static_cast<std::uint8_t>(code & 0xFF),
                     static_cast<std::uint8_t>(code >> 8), 0, 0});
  }
  static can::Frame write_word(unsigned number, std::uint16_t value) {
    return command({static_cast<std::uint8_t>(0x70 | (number >> 8)), static_cast<std::uint8_t>(number & 0xFF),
                    static_cast<std::uint8_t>(value & 0xFF), static_cast<std::uint8_t>(value >> 8), 0, 0});
  }

  ServiceRecord told_;
  SlaveService service_;
  Slave slave_;
};

}  // namespace cansync::test
