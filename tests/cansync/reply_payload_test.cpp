// What is put into a reply goes over the bus to where the protocol has it, and is found there again.

#include "cansync/telegram/reply_payload.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace cansync {
namespace {

using Bytes = std::vector<unsigned>;

ParameterReply parameter_reply(const Bytes& payload) {
  ParameterReply reply;
  reply.payload_size = static_cast<std::uint8_t>(payload.size());
  std::copy(payload.begin(), payload.end(), reply.payload.begin());
  return reply;
}

/// The frame's bytes behind the control byte and the number.
Bytes payload_on_the_bus(const Telegram& telegram) {
  const can::Frame frame = encode(telegram);
  return {frame.data.begin() + 2, frame.data.begin() + frame.dlc};
}

template <class Reply>
Reply received(const Reply& reply) {
  const Decoded decoded = decode(encode(reply));
  const auto* telegram = std::get_if<Telegram>(&decoded);
  return telegram != nullptr ? std::get<Reply>(*telegram) : Reply{};
}

TEST(ReplyPayload, AWordAndItsSubSlave) {
  ParameterReply reply;
  put_value(reply, 0xABCD1234, false, {0x0567});
  EXPECT_EQ(payload_on_the_bus(reply), (Bytes{0x34, 0x12, 0x67, 0x05}));
  const auto answer = read_answer(received(reply));
  ASSERT_TRUE(answer);
  EXPECT_FALSE(answer->doubleword);
  EXPECT_EQ(answer->value, 0x1234u);
  EXPECT_EQ(answer->sub_slave, SubSlave{0x0567});
}

TEST(ReplyPayload, ADoublewordAndItsSubSlave) {
  ParameterReply reply;
  put_value(reply, 0xABCD1234, true, {0x0567});
  EXPECT_EQ(payload_on_the_bus(reply), (Bytes{0x34, 0x12, 0xCD, 0xAB, 0x67, 0x05}));
  const auto answer = read_answer(received(reply));
  ASSERT_TRUE(answer);
  EXPECT_TRUE(answer->doubleword);
  EXPECT_EQ(answer->value, 0xABCD1234u);
  EXPECT_EQ(answer->sub_slave, SubSlave{0x0567});
}

TEST(ReplyPayload, AWordMayComeAlone) {
  const auto answer = read_answer(parameter_reply({0x34, 0x12}));
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->value, 0x1234u);
  EXPECT_FALSE(answer->doubleword);
  EXPECT_FALSE(answer->sub_slave);
  EXPECT_FALSE(read_answer(parameter_reply({})));
}

TEST(ReplyPayload, AWriteIsConfirmedByTheSubSlaveOrByNothing) {
  ParameterReply reply;
  put_confirmation(reply, {0x0567});
  EXPECT_EQ(payload_on_the_bus(reply), (Bytes{0x67, 0x05}));
  EXPECT_TRUE(confirms_write(received(reply)));
  EXPECT_EQ(write_sub_slave(received(reply)), SubSlave{0x0567});
  EXPECT_TRUE(confirms_write(parameter_reply({})));
  EXPECT_FALSE(write_sub_slave(parameter_reply({})));
  EXPECT_FALSE(confirms_write(parameter_reply({1, 2, 3, 4})));
}

TEST(ReplyPayload, AnErrorOfAParameter) {
  ParameterReply reply;
  put_error(reply, ParameterError::not_changeable, {0x0567});
  EXPECT_EQ(payload_on_the_bus(reply), (Bytes{0xFC, 0xFF, 0x67, 0x05}));
  EXPECT_TRUE(received(reply).error);
  const auto answer = error_answer(received(reply));
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->error, ParameterError::not_changeable);
  EXPECT_EQ(answer->sub_slave, SubSlave{0x0567});
  EXPECT_FALSE(error_answer(parameter_reply({0xFC, 0xFF}))->sub_slave);
  EXPECT_FALSE(error_answer(parameter_reply({})));
}

TEST(ReplyPayload, AnErrorOfATransfer) {
  TransferReply reply;
  put_error(reply, TransferError::block_too_long);
  EXPECT_EQ(payload_on_the_bus(reply), (Bytes{0x07, 0x01}));
  EXPECT_TRUE(received(reply).error);
  EXPECT_EQ(error_answer(received(reply)), TransferError::block_too_long);
  EXPECT_FALSE(error_answer(TransferReply{}));
}

TEST(ReplyPayload, TheBytesOfAnUpload) {
  TransferReply reply;
  put_upload(reply, {1, 2, 3, 4, 5, 6});
  EXPECT_EQ(payload_on_the_bus(reply), (Bytes{1, 2, 3, 4, 5, 6}));
  const TransferReply back = received(reply);
  const auto bytes = upload_bytes(back);
  ASSERT_TRUE(bytes);
  EXPECT_EQ(Bytes(bytes->begin(), bytes->end()), (Bytes{1, 2, 3, 4, 5, 6}));
  EXPECT_FALSE(is_acknowledgement(back));
  EXPECT_TRUE(is_acknowledgement(TransferReply{}));
  EXPECT_FALSE(upload_bytes(TransferReply{}));
}

TEST(ReplyPayload, BusySaysNothingElse) {
  ParameterReply parameter;
  put_value(parameter, 0xFFFFFFFF, true, {0x0567});
  put_busy(parameter);
  EXPECT_TRUE(received(parameter).busy);
  EXPECT_EQ(payload_on_the_bus(parameter), Bytes{});
  TransferReply transfer;
  put_error(transfer, TransferError::not_possible);
  put_busy(transfer);
  EXPECT_FALSE(received(transfer).error);
  EXPECT_EQ(payload_on_the_bus(transfer), Bytes{});
}

TEST(ReplyPayload, DataBytesAreThoseOfTheFrame) {
  for (const std::size_t size : {0u, 2u, 4u, 6u}) {
    const ParameterReply reply = parameter_reply(Bytes(size));
    EXPECT_EQ(data_bytes(reply), encode(reply).dlc) << size;
  }
  TransferReply transfer;
  EXPECT_EQ(data_bytes(transfer), encode(transfer).dlc);
  put_upload(transfer, {});
  EXPECT_EQ(data_bytes(transfer), encode(transfer).dlc);
}

}  // namespace
}  // namespace cansync
