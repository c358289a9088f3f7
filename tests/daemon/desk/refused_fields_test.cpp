#include <gtest/gtest.h>

#include <functional>
#include <set>
#include <string_view>

#include "good_requests.h"

namespace cansyncd {
namespace {

/// The fields that the rows' reasons name first, without indices.
template <class Cases>
std::set<std::string_view> fields_of(const Cases& cases) {
  std::set<std::string_view> fields;
  for (const auto& row : cases) {
    const std::string_view field = *row.pieces.begin();
    fields.insert(field.substr(0, field.find('[')));
  }
  return fields;
}
using Fields = std::set<std::string_view>;

/// Field, value and allowed range of each refusal of a parameter request.
TEST(RefusedFields, ParameterFieldsOutOfRange) {
  GatewayRig rig;
  struct Case {
    std::function<void(cansync_ParameterRequest&)> spoil;
    gateway_RefusalCause cause;
    std::initializer_list<std::string_view> pieces;
  };
  const Case cases[] = {
      {[](auto& r) { r.slave = 9; }, gateway_CAUSE_SLAVE_NOT_CONFIGURED, {"slave", "9", "0..3"}},
      {[](auto& r) { r.slave = 32; }, gateway_CAUSE_FIELD, {"slave", "32"}},
      {[](auto& r) { r.slave = 0xFFFFFFFF; }, gateway_CAUSE_FIELD, {"slave", "4294967295"}},
      {[](auto& r) { r.sub_slave = 65536; }, gateway_CAUSE_FIELD, {"sub_slave", "65536", "0..65535"}},
      {[](auto& r) { r.number = 4096; }, gateway_CAUSE_FIELD, {"number", "4096", "0..4095"}},
      {[](auto& r) { r.element = 8; }, gateway_CAUSE_FIELD, {"element", "8", "0..7"}},
      {[](auto& r) { r.write = true, r.element = 3; },
       gateway_CAUSE_ELEMENT_NOT_WRITABLE,
       {"element", "3", "7"}},
      {[](auto& r) { r.write = true, r.format = cansync_FORMAT_WORD, r.value = 65536; },
       gateway_CAUSE_VALUE_TOO_WIDE,
       {"value", "65536", "0..65535"}},
      {[](auto& r) { r.timeout = 3'600'001; }, gateway_CAUSE_FIELD, {"timeout", "3600001", "3600000"}},
  };
  // What is no format is dropped by DDS.
  EXPECT_EQ(fields_of(cases), (Fields{"slave", "sub_slave", "number", "element", "value", "timeout"}));
  std::uint64_t number = 1;
  for (const Case& c : cases) {
    auto request = good_read(number);
    c.spoil(request);
    rig.client.write(request);
    const auto reply = rig.client.reply<cansync_ParameterReply>(number++);
    ASSERT_TRUE(reply);
    expect_refused(*reply, c.cause, c.pieces);
  }
  EXPECT_EQ(rig.exchange.requests.size(), 0u);
}

TEST(RefusedFields, TransferFieldsOutOfRange) {
  GatewayRig rig;
  std::array<std::uint8_t, 4> four = {1, 2, 3, 4};
  struct Case {
    std::function<void(cansync_TransferRequest&)> spoil;
    gateway_RefusalCause cause;
    std::initializer_list<std::string_view> pieces;
  };
  const Case cases[] = {
      {[](auto& r) { r.slave = 9; }, gateway_CAUSE_SLAVE_NOT_CONFIGURED, {"slave", "9", "0..3"}},
      {[](auto& r) { r.slave = 32; }, gateway_CAUSE_FIELD, {"slave", "32"}},
      {[](auto& r) { r.sub_slave = 65536; }, gateway_CAUSE_FIELD, {"sub_slave", "65536", "0..65535"}},
      {[&](auto& r) {
         r.data = {4, 4, four.data(), false};
       },
       gateway_CAUSE_LENGTH,
       {"data", "4 bytes", "upload"}},
      {[](auto& r) { r.direction = cansync_DIRECTION_DOWNLOAD, r.length = 0; },
       gateway_CAUSE_LENGTH,
       {"length", "0", "1..16777216"}},
      {[](auto& r) { r.length = 0; }, gateway_CAUSE_LENGTH, {"length", "0", "1..16777216"}},
      {[](auto& r) { r.length = 16'777'217; }, gateway_CAUSE_LENGTH, {"length", "16777217", "1..16777216"}},
      {[&](auto& r) {
         r.direction = cansync_DIRECTION_DOWNLOAD, r.data = {4, 4, four.data(), false};
       },
       gateway_CAUSE_LENGTH,
       {"length", "100", "4"}},
      {[](auto& r) { r.address = 0xFF; }, gateway_CAUSE_ADDRESS, {"address", "0xFF", "0x100..0xFFFFFFFF"}},
      {[](auto& r) { r.address = 0xFFFFFFFF; }, gateway_CAUSE_ADDRESS, {"address", "0xFFFFFFFF"}},
      {[](auto& r) { r.block_size = 4093; }, gateway_CAUSE_BLOCK_SIZE, {"block_size", "4093", "1..300"}},
      {[](auto& r) { r.block_size = 301; }, gateway_CAUSE_BLOCK_SIZE, {"block_size", "301", "1..300"}},
      {[](auto& r) { r.block_size = 0xFFFFFFFF; },
       gateway_CAUSE_BLOCK_SIZE,
       {"block_size", "4294967295", "1..300"}},
      {[](auto& r) { r.timeout = 3'600'001; }, gateway_CAUSE_FIELD, {"timeout", "3600001", "3600000"}},
  };
  // What is no direction, and data over its bound, is dropped by DDS.
  EXPECT_EQ(fields_of(cases),
            (Fields{"slave", "sub_slave", "address", "length", "block_size", "timeout", "data"}));
  std::uint64_t number = 1;
  for (const Case& c : cases) {
    auto request = good_upload(number);
    c.spoil(request);
    rig.client.write(request);
    const auto answer = rig.transfer_reply(number++);
    ASSERT_TRUE(answer);
    expect_refused(answer->reply, c.cause, c.pieces);
  }
  EXPECT_EQ(rig.exchange.requests.size(), 0u);
}

TEST(RefusedFields, CommandFieldsOutOfRange) {
  GatewayRig rig;
  struct Case {
    cansync_CommandKind kind;
    std::function<void(cansync_Command&)> spoil;
    gateway_RefusalCause cause;
    std::initializer_list<std::string_view> pieces;
  };
  const Case cases[] = {
      {cansync_COMMAND_CONTROL_WORD,
       [](auto& c) { c.slave = 9; },
       gateway_CAUSE_SLAVE_NOT_CONFIGURED,
       {"slave", "9", "0..3"}},
      {cansync_COMMAND_CONTROL_WORD,
       [](auto& c) { c.control_word = 65536; },
       gateway_CAUSE_FIELD,
       {"control_word", "65536", "0..65535"}},
      {cansync_COMMAND_BROADCAST,
       [](auto& c) { c.priority = 3; },
       gateway_CAUSE_FIELD,
       {"priority", "3", "0..2"}},
      {cansync_COMMAND_BROADCAST,
       [](auto& c) { c.slave_mask = 0; },
       gateway_CAUSE_NO_SLAVES,
       {"slave_mask", "0x0", "0..3"}},
      {cansync_COMMAND_BROADCAST,
       [](auto& c) { c.slave_mask = 0x10; },
       gateway_CAUSE_SLAVE_NOT_CONFIGURED,
       {"slave_mask", "0x10", "0..3"}},
      {cansync_COMMAND_BROADCAST,
       [](auto& c) { c.action = 0; },
       gateway_CAUSE_ACTION_RESERVED,
       {"action", "0", "128..255"}},
      {cansync_COMMAND_BROADCAST,
       [](auto& c) { c.action = 2; },
       gateway_CAUSE_ACTION_RESERVED,
       {"action", "2", "128..255"}},
      {cansync_COMMAND_BROADCAST,
       [](auto& c) { c.action = 127; },
       gateway_CAUSE_ACTION_RESERVED,
       {"action", "127", "128..255"}},
      {cansync_COMMAND_BROADCAST,
       [](auto& c) { c.action = 256; },
       gateway_CAUSE_ACTION_RESERVED,
       {"action", "256", "128..255"}},
      {cansync_COMMAND_BROADCAST,
       [](auto& c) { c.data_byte = 256; },
       gateway_CAUSE_FIELD,
       {"data_byte", "256", "0..255"}},
      {cansync_COMMAND_BROADCAST,
       [](auto& c) { c.data_word = 65536; },
       gateway_CAUSE_FIELD,
       {"data_word", "65536", "0..65535"}},
      {cansync_COMMAND_POLLING,
       [](auto& c) { c.polling_one = 32; },
       gateway_CAUSE_FIELD,
       {"polling_one", "32", "0..31"}},
      {cansync_COMMAND_POLLING,
       [](auto& c) { c.polling_two = -3; },
       gateway_CAUSE_FIELD,
       {"polling_two", "-3", "-128"}},
      {cansync_COMMAND_POLLING,
       [](auto& c) { c.maximum_slave = 32; },
       gateway_CAUSE_FIELD,
       {"maximum_slave", "32", "0..31"}},
      {cansync_COMMAND_POLLING,
       [](auto& c) { c.polling_one = 9; },
       gateway_CAUSE_SLAVE_NOT_CONFIGURED,
       {"polling_one", "9", "0..3"}},
      {cansync_COMMAND_POLLING,
       [](auto& c) { c.polling_two = -129; },
       gateway_CAUSE_FIELD,
       {"polling_two", "-129", "-128"}},
      {cansync_COMMAND_POLLING,
       [](auto& c) { c.maximum_slave = -1; },
       gateway_CAUSE_FIELD,
       {"maximum_slave", "-1", "-2"}},
      {cansync_COMMAND_CHANNEL_CURSORS,
       [](auto& c) { c.cursor_control_word = 32; },
       gateway_CAUSE_FIELD,
       {"cursor_control_word", "32", "0..31"}},
      {cansync_COMMAND_CHANNEL_CURSORS,
       [](auto& c) { c.cursor_parameter = 9; },
       gateway_CAUSE_SLAVE_NOT_CONFIGURED,
       {"cursor_parameter", "9", "0..3"}},
      {cansync_COMMAND_CHANNEL_CURSORS,
       [](auto& c) { c.cursor_transfer = -3; },
       gateway_CAUSE_FIELD,
       {"cursor_transfer", "-3", "-128"}},
      {cansync_COMMAND_REFERENCE_MAPPING,
       [](auto& c) { c.mapping[0] = 0x80; },
       gateway_CAUSE_MAPPING,
       {"mapping[0]", "0x80"}},
      {cansync_COMMAND_REFERENCE_MAPPING,
       [](auto& c) { c.mapping[0] = 0x11; },
       gateway_CAUSE_MAPPING,
       {"mapping[0]", "0x11", "0..3"}},
      {cansync_COMMAND_REFERENCE_MAPPING,
       [](auto& c) { c.mapping[4] = 0x0D; },
       gateway_CAUSE_MAPPING,
       {"mapping[4]", "0x0D", "4..7"}},
      {cansync_COMMAND_ACTUAL_MAPPING,
       [](auto& c) { c.slave = 9; },
       gateway_CAUSE_SLAVE_NOT_CONFIGURED,
       {"slave", "9", "0..3"}},
      {cansync_COMMAND_ACTUAL_MAPPING,
       [](auto& c) { c.mapping[7] = 0x21; },
       gateway_CAUSE_MAPPING,
       {"mapping[7]", "0x21"}},
      {cansync_COMMAND_RELEASE,
       [](auto& c) { c.slave = 9; },
       gateway_CAUSE_SLAVE_NOT_CONFIGURED,
       {"slave", "9", "0..3"}},
      {cansync_COMMAND_RELEASE, [](auto& c) { c.slave = 32; }, gateway_CAUSE_FIELD, {"slave", "32"}},
  };
  // What is no kind or mode is dropped by DDS.
  EXPECT_EQ(fields_of(cases),
            (Fields{"slave", "control_word", "priority", "slave_mask", "action", "data_byte", "data_word",
                    "polling_one", "polling_two", "maximum_slave", "cursor_control_word", "cursor_parameter",
                    "cursor_transfer", "mapping"}));
  std::uint64_t number = 1;
  for (const Case& c : cases) {
    auto command = good_command(number, c.kind);
    c.spoil(command);
    rig.client.write(command);
    const auto reply = rig.client.reply<cansync_CommandReply>(number++);
    ASSERT_TRUE(reply);
    expect_refused(*reply, c.cause, c.pieces);
  }
  EXPECT_EQ(rig.exchange.requests.size(), 0u);
}

}  // namespace
}  // namespace cansyncd
