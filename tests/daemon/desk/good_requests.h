#pragma once

#include <gtest/gtest.h>

#include <initializer_list>
#include <string_view>

#include "support/gateway_rig.h"

/// Requests that nothing is wrong with, to be spoilt, and what must come of them then.
namespace cansyncd {

/// A read of a parameter's value.
inline cansync_ParameterRequest good_read(std::uint64_t number, std::uint8_t client = 1,
                                          std::uint32_t of_slave = 1) {
  auto request = TestClient::request<cansync_ParameterRequest>(number, TestClient::identity(client));
  request.slave = of_slave;
  request.number = 301;
  request.element = 7;
  request.format = cansync_FORMAT_AS_SLAVE_SAYS;
  return request;
}

/// 100 bytes of slave 1.
inline cansync_TransferRequest good_upload(std::uint64_t number) {
  auto request = TestClient::request<cansync_TransferRequest>(number);
  request.slave = 1;
  request.address = 0x1000;
  request.length = 100;
  return request;
}

/// A command of either kind to slave 1, or to all four.
inline cansync_Command good_command(std::uint64_t number,
                                    cansync_CommandKind kind = cansync_COMMAND_CONTROL_WORD) {
  auto command = TestClient::request<cansync_Command>(number);
  command.kind = kind;
  command.slave = 1;
  command.priority = 1;
  command.slave_mask = 0xF;
  command.action = 128;
  return command;
}

/// The reply is a refusal for this cause, and its reason has all of `pieces`.
template <class Reply>
void expect_refused(const Reply& reply, gateway_RefusalCause cause,
                    std::initializer_list<std::string_view> pieces) {
  const std::string_view reason = reply.reason;
  EXPECT_EQ(reply.code, gateway_REPLY_REFUSED) << reason;
  EXPECT_EQ(gateway::dds::name(reply.cause), gateway::dds::name(cause)) << reason;
  for (const auto piece : pieces)
    EXPECT_NE(reason.find(piece), std::string_view::npos) << piece << " in: " << reason;
}

}  // namespace cansyncd
