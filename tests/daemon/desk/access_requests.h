#pragma once

#include <array>
#include <cstdint>

#include "support/gateway_rig.h"

/// Requests of every kind that access is decided for.
namespace cansyncd {

/// Element "value" of a parameter.
inline constexpr std::uint8_t kElementValue = 7;

/// A read or a write of one parameter.
inline cansync_ParameterRequest parameter(std::uint64_t number, bool write, std::uint32_t value = 0) {
  auto request = TestClient::request<cansync_ParameterRequest>(number);
  request.write = write;
  request.slave = 1;
  request.number = 100;
  request.element = kElementValue;
  request.format = cansync_FORMAT_AS_SLAVE_SAYS;
  request.value = value;
  return request;
}

inline cansync_TransferRequest upload(std::uint64_t number) {
  auto request = TestClient::request<cansync_TransferRequest>(number);
  request.slave = 1;
  request.address = 0x1000;
  request.length = 4;
  return request;
}

/// What a download brings.
inline std::array<std::uint8_t, 3> abc = {'a', 'b', 'c'};

inline cansync_TransferRequest download(std::uint64_t number) {
  auto request = upload(number);
  request.direction = cansync_DIRECTION_DOWNLOAD;
  request.length = abc.size();
  request.data = {static_cast<std::uint32_t>(abc.size()), static_cast<std::uint32_t>(abc.size()), abc.data(),
                  false};
  return request;
}

/// Every kind of command.
inline constexpr cansync_CommandKind kCommands[] = {
    cansync_COMMAND_CONTROL_WORD,   cansync_COMMAND_BROADCAST,       cansync_COMMAND_MODE,
    cansync_COMMAND_POLLING,        cansync_COMMAND_CHANNEL_CURSORS, cansync_COMMAND_REFERENCE_MAPPING,
    cansync_COMMAND_ACTUAL_MAPPING, cansync_COMMAND_RELEASE};

/// A command of this kind that nothing is wrong with.
inline cansync_Command command(std::uint64_t number, cansync_CommandKind kind) {
  auto sample = TestClient::request<cansync_Command>(number);
  sample.kind = kind;
  sample.slave = 2;
  sample.control_word = 0x000F;
  sample.priority = 1;
  sample.slave_mask = 0xF;
  sample.action = 128;
  sample.polling_one = 3;
  sample.polling_two = -2;
  sample.maximum_slave = -2;
  sample.cursor_control_word = -128;
  sample.cursor_parameter = -2;
  sample.cursor_transfer = -2;
  return sample;
}

/// The master in active operation, which takes every command.
inline MasterSnapshot in_operation() {
  MasterSnapshot master;
  master.state = cansync::State::active_master;
  return master;
}

}  // namespace cansyncd
