#include "cansync/dds/validate.h"

#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "cansync/telegram/telegram.h"

namespace cansync::dds {
namespace {

/// Slaves 0..3 and 7; slave 2 takes blocks of 120 bytes, the others 300.
Limits line() {
  MasterSettings settings;
  for (const unsigned slave : {0u, 1u, 2u, 3u, 7u}) settings.slaves[slave].configured = true;
  settings.slaves[2].block_limit = 120;
  return limits_of(settings);
}

template <class T>
struct Case {
  std::function<void(T&)> change;
  std::string expected;  // empty: allowed
};

/// Applies each change to `good` and compares the problem's text.
template <class T>
void expect_texts(const T& good, const std::vector<Case<T>>& cases, const Limits& limits = line()) {
  ASSERT_FALSE(check(good, limits));
  for (const Case<T>& entry : cases) {
    T sample = good;
    entry.change(sample);
    const std::string text = check(sample, limits).value_or(gateway::dds::Denial{}).reason;
    EXPECT_EQ(text, entry.expected);
    EXPECT_LE(text.size(), std::size_t{gateway_TEXT});
  }
}

cansync_ParameterRequest good_parameter() {
  cansync_ParameterRequest request = {};
  request.slave = 3;
  request.number = 301;
  request.element = 7;
  request.format = cansync_FORMAT_AS_SLAVE_SAYS;
  return request;
}

TEST(Validate, ParameterRequest) {
  using R = cansync_ParameterRequest;
  expect_texts<R>(good_parameter(),
                  {
                      {[](R& r) { r.slave = 32; }, "slave 32: out of range; allowed 0..31"},
                      {[](R& r) { r.slave = 0xFFFFFFFF; }, "slave 4294967295: out of range; allowed 0..31"},
                      {[](R& r) { r.slave = 5; }, "slave 5: not configured; allowed 0..3, 7"},
                      {[](R& r) { r.slave = 7; }, ""},
                      {[](R& r) { r.sub_slave = 65535; }, ""},
                      {[](R& r) { r.sub_slave = 65536; }, "sub_slave 65536: out of range; allowed 0..65535"},
                      {[](R& r) { r.number = 4095; }, ""},
                      {[](R& r) { r.number = 4096; }, "number 4096: out of range; allowed 0..4095"},
                      {[](R& r) { r.element = 0; }, ""},
                      {[](R& r) { r.element = 8; }, "element 8: out of range; allowed 0..7"},
                      {[](R& r) { r.format = static_cast<cansync_ParameterFormat>(3); },
                       "format 3: out of range; allowed 0..2"},
                      {[](R& r) { r.timeout = 3'600'000; }, ""},
                      {[](R& r) { r.timeout = 3'600'001; },
                       "timeout 3600001 ms: out of range; allowed 0..3600000 ms, 0 = the daemon's default"},
                      {[](R& r) { r.value = 70000; }, ""},  // a read does not use it
                  });
}

TEST(Validate, ParameterWrite) {
  using R = cansync_ParameterRequest;
  R write = good_parameter();
  write.write = true;
  write.format = cansync_FORMAT_WORD;
  write.value = 65535;
  expect_texts<R>(write,
                  {
                      {[](R& r) { r.element = 6; },
                       "element 6: cannot be written; allowed 7 (the value), the others can only be read"},
                      {[](R& r) { r.value = 65536; },
                       "value 65536: too wide for a word; allowed 0..65535, or format doubleword"},
                      {[](R& r) {
                         r.value = 0xFFFFFFFF;
                         r.format = cansync_FORMAT_DOUBLEWORD;
                       },
                       ""},
                      {[](R& r) {
                         r.value = 0xFFFFFFFF;
                         r.format = cansync_FORMAT_AS_SLAVE_SAYS;
                       },
                       ""},
                  });
}

cansync_TransferRequest good_upload() {
  cansync_TransferRequest request = {};
  request.direction = cansync_DIRECTION_UPLOAD;
  request.slave = 1;
  request.address = 0x100;
  request.length = 1000;
  return request;
}

TEST(Validate, Upload) {
  using R = cansync_TransferRequest;
  expect_texts<R>(
      good_upload(),
      {
          {[](R& r) { r.slave = 32; }, "slave 32: out of range; allowed 0..31"},
          {[](R& r) { r.slave = 4; }, "slave 4: not configured; allowed 0..3, 7"},
          {[](R& r) { r.sub_slave = 70000; }, "sub_slave 70000: out of range; allowed 0..65535"},
          {[](R& r) {
             constexpr std::uint32_t kNone = 2;  // as a client of another language could send it
             std::memcpy(&r.direction, &kNone, sizeof r.direction);
           },
           "direction 2: out of range; allowed 0..1"},
          {[](R& r) { r.length = 0; }, "length 0: out of range; allowed 1..16777216 bytes"},
          {[](R& r) { r.length = 16777216; }, ""},
          {[](R& r) { r.length = 16777217; }, "length 16777217: out of range; allowed 1..16777216 bytes"},
          {[](R& r) { r.data._length = 4; }, "data of 4 bytes: not with an upload; allowed 0 bytes"},
          {[](R& r) { r.address = 0xFF; },
           "address 0xFF: 0x00..0xFF belong to the slave's operating system; allowed 0x100..0xFFFFFFFF, or "
           "set allow_reserved_addresses"},
          {[](R& r) { r.address = 0xFFFFFFFF - 999; }, ""},
          {[](R& r) { r.address = 0xFFFFFFFF - 998; },
           "address 0xFFFFFC19: with length 1000 the end lies at 0x100000000; allowed up to 0xFFFFFFFF"},
          {[](R& r) { r.block_size = 300; }, ""},
          {[](R& r) { r.block_size = 301; },
           "block_size 301: over the limit of slave 1; allowed 1..300, 0 = 300"},
          {[](R& r) {
             r.slave = 2;
             r.block_size = 121;
           },
           "block_size 121: over the limit of slave 2; allowed 1..120, 0 = 120"},
          {[](R& r) { r.block_size = 4093; },
           "block_size 4093: over the limit of slave 1; allowed 1..300, 0 = 300"},
          {[](R& r) { r.timeout = 4'000'000; },
           "timeout 4000000 ms: out of range; allowed 0..3600000 ms, 0 = the daemon's default"},
      });
}

TEST(Validate, DownloadNeedsItsData) {
  using R = cansync_TransferRequest;
  R download = good_upload();
  download.direction = cansync_DIRECTION_DOWNLOAD;
  download.data._length = 1000;
  expect_texts<R>(download, {
                                {[](R& r) { r.data._length = 999; },
                                 "length 1000: does not fit the data; allowed 999, the bytes of data"},
                                {[](R& r) { r.data._length = r.length = 0; },
                                 "length 0: out of range; allowed 1..16777216 bytes"},
                            });
}

TEST(Validate, BlocksBeginAtWholeStartAddresses) {
  Limits limits = line();
  limits.address_step = 4;
  cansync_TransferRequest request = good_upload();
  request.block_size = 120;
  EXPECT_FALSE(check(request, limits));
  request.block_size = 122;
  const auto problem = check(request, limits);
  ASSERT_TRUE(problem);
  EXPECT_EQ(problem->cause, gateway_CAUSE_BLOCK_SIZE);
  EXPECT_EQ(problem->reason,
            "block_size 122: no whole start addresses; allowed multiples of 4 up to 300, 0 = 300");
}

TEST(Validate, ReservedAddressesWhenTheSettingAllowsThem) {
  Limits limits = line();
  limits.allow_reserved_addresses = true;
  cansync_TransferRequest request = good_upload();
  request.address = 0;
  EXPECT_FALSE(check(request, limits));
}

TEST(Validate, AddressesThatCountDoublewordsReachFurther) {
  Limits limits = line();
  limits.address_step = 4;
  cansync_TransferRequest request = good_upload();
  request.address = 0xFFFFFFFF - 249;  // 1000 bytes are 250 addresses
  EXPECT_FALSE(check(request, limits));
  ++request.address;
  EXPECT_NE(check(request, limits), std::nullopt);
}

cansync_Command command_of(cansync_CommandKind kind) {
  cansync_Command command = {};
  command.kind = kind;
  command.slave = 3;
  command.slave_mask = 0x8F;
  command.action = 1;
  command.polling_one = command.polling_two = command.maximum_slave = -2;
  command.cursor_control_word = command.cursor_parameter = command.cursor_transfer = -2;
  return command;
}

TEST(Validate, ControlWordAndMode) {
  using C = cansync_Command;
  expect_texts<C>(
      command_of(cansync_COMMAND_CONTROL_WORD),
      {{[](C& c) { c.slave = 33; }, "slave 33: out of range; allowed 0..31"},
       {[](C& c) { c.slave = 30; }, "slave 30: not configured; allowed 0..3, 7"},
       {[](C& c) { c.control_word = 0xFFFF; }, ""},
       {[](C& c) { c.control_word = 0x10000; }, "control_word 65536: out of range; allowed 0..65535"}});
  expect_texts<C>(command_of(cansync_COMMAND_MODE), {{[](C& c) { c.mode = static_cast<cansync_Mode>(5); },
                                                      "mode 5: out of range; allowed 0..4"}});
}

TEST(Validate, Release) {
  using C = cansync_Command;
  expect_texts<C>(command_of(cansync_COMMAND_RELEASE),
                  {{[](C& c) { c.slave = 7; }, ""},
                   {[](C& c) { c.slave = 32; }, "slave 32: out of range; allowed 0..31"},
                   {[](C& c) { c.slave = 5; }, "slave 5: not configured; allowed 0..3, 7"}});
}

TEST(Validate, Broadcast) {
  using C = cansync_Command;
  expect_texts<C>(
      command_of(cansync_COMMAND_BROADCAST),
      {
          {[](C& c) { c.priority = 2; }, ""},
          {[](C& c) { c.priority = 3; }, "priority 3: out of range; allowed 0..2"},
          {[](C& c) { c.slave_mask = 0; },
           "slave_mask 0x0: no slave; allowed bits of the configured slaves 0..3, 7, or 0xFFFFFFFF"},
          {[](C& c) { c.slave_mask = 0x80000011; },
           "slave_mask 0x80000011: slaves 4, 31 are not configured; allowed bits of 0..3, 7, or 0xFFFFFFFF for all that are on "
           "the bus"},
          {[](C& c) { c.slave_mask = 0xFFFFFFFF; }, ""},  // all slaves (M 4.2)
          {[](C& c) { c.action = 0; },
           "action 0: reserved or out of range; allowed 1 (control word) and 128..255"},
          {[](C& c) { c.action = 2; },
           "action 2: reserved or out of range; allowed 1 (control word) and 128..255"},
          {[](C& c) { c.action = 127; },
           "action 127: reserved or out of range; allowed 1 (control word) and 128..255"},
          {[](C& c) { c.action = 128; }, ""},
          {[](C& c) { c.action = 256; },
           "action 256: reserved or out of range; allowed 1 (control word) and 128..255"},
          {[](C& c) { c.data_byte = 256; }, "data_byte 256: out of range; allowed 0..255"},
          {[](C& c) { c.data_word = 65536; }, "data_word 65536: out of range; allowed 0..65535"},
      });
}

TEST(Validate, PollingAndCursors) {
  using C = cansync_Command;
  expect_texts<C>(
      command_of(cansync_COMMAND_POLLING),
      {
          {[](C& c) { c.polling_one = -128; }, ""},
          {[](C& c) { c.polling_two = -1; }, ""},
          {[](C& c) { c.polling_one = 7; }, ""},
          {[](C& c) { c.polling_one = 6; }, "polling_one 6: not configured; allowed 0..3, 7"},
          {[](C& c) { c.polling_two = 32; },
           "polling_two 32: out of range; allowed a slave 0..31, -128 automatic, -1 nobody, -2 unchanged"},
          {[](C& c) { c.polling_two = -3; },
           "polling_two -3: out of range; allowed a slave 0..31, -128 automatic, -1 nobody, -2 unchanged"},
          {[](C& c) { c.maximum_slave = 31; }, ""},
          {[](C& c) { c.maximum_slave = 32; }, "maximum_slave 32: out of range; allowed 0..31, -2 unchanged"},
          {[](C& c) { c.maximum_slave = -1; }, "maximum_slave -1: out of range; allowed 0..31, -2 unchanged"},
      });
  const std::string range = ": out of range; allowed a slave 0..31, -128 automatic, -1 nobody, -2 unchanged";
  expect_texts<C>(
      command_of(cansync_COMMAND_CHANNEL_CURSORS),
      {
          {[](C& c) { c.cursor_control_word = 99; }, "cursor_control_word 99" + range},
          {[](C& c) { c.cursor_parameter = -127; }, "cursor_parameter -127" + range},
          {[](C& c) { c.cursor_transfer = 4; }, "cursor_transfer 4: not configured; allowed 0..3, 7"},
      });
}

TEST(Validate, Mappings) {
  using C = cansync_Command;
  const std::string form =
      ": no register byte; allowed 0 (unused), or bit 0 set, bit 1 high word, bits 2..6 value 0..7, bit 7 "
      "zero";
  const std::vector<Case<C>> cases = {
      {[](C& c) { c.mapping[0] = 0x0D; }, ""},  // low word of value 3
      {[](C& c) { c.mapping[7] = 0x1F; }, ""},  // high word of value 7
      {[](C& c) { c.mapping[0] = 0x8D; }, "mapping[0] 0x8D" + form},
      {[](C& c) { c.mapping[3] = 0x0C; }, "mapping[3] 0x0C" + form},  // named but not assigned
      {[](C& c) { c.mapping[5] = 0x21; }, "mapping[5] 0x21" + form},  // value 8
      {[](C& c) { c.mapping[1] = 0x11; },
       "mapping[1] 0x11: value 4 does not belong to telegram 1; allowed 0..3"},
      {[](C& c) { c.mapping[4] = 0x0D; },
       "mapping[4] 0x0D: value 3 does not belong to telegram 2; allowed 4..7"},
  };
  expect_texts<C>(command_of(cansync_COMMAND_REFERENCE_MAPPING), cases);
  expect_texts<C>(command_of(cansync_COMMAND_ACTUAL_MAPPING), cases);
  expect_texts<C>(command_of(cansync_COMMAND_ACTUAL_MAPPING),
                  {{[](C& c) { c.slave = 8; }, "slave 8: not configured; allowed 0..3, 7"}});
}

TEST(Validate, ReferenceValues) {
  using V = cansync_ReferenceValues;
  V good = {};
  good.telegram = 1;
  good.valid = 15;
  expect_texts<V>(
      good,
      {
          {[](V& v) { v.telegram = 2; }, ""},
          {[](V& v) { v.telegram = 0; }, "telegram 0: out of range; allowed 1..2"},
          {[](V& v) { v.telegram = 3; }, "telegram 3: out of range; allowed 1..2"},
          {[](V& v) { v.valid = 0; }, "valid 0: out of range; allowed 1..15, bit n = value[n] is new"},
          {[](V& v) { v.valid = 16; }, "valid 16: out of range; allowed 1..15, bit n = value[n] is new"},
          {[](V& v) { v.release_intervals = 1000; }, ""},
          {[](V& v) { v.release_intervals = 1001; }, "release_intervals 1001: out of range; allowed 0..1000"},
      });
}

TEST(Validate, NoConfiguredSlaveIsToldAsSuch) {
  const auto problem = check(good_parameter(), Limits{});
  ASSERT_TRUE(problem);
  EXPECT_EQ(problem->cause, gateway_CAUSE_SLAVE_NOT_CONFIGURED);
  EXPECT_EQ(problem->reason, "slave 3: not configured; allowed none");
}

TEST(Explain, EveryRefusalHasATextAndACauseOfItsKind) {
  for (int refusal = static_cast<int>(Refusal::slave_not_configured);
       refusal <= static_cast<int>(Refusal::beyond_limit); ++refusal) {
    const std::string text = explain(static_cast<Refusal>(refusal), line());
    EXPECT_GT(text.size(), 5u) << refusal;
    EXPECT_LE(text.size(), std::size_t{gateway_TEXT}) << refusal;
    EXPECT_GT(to_cause(static_cast<Refusal>(refusal)), gateway_CAUSE_UNKNOWN) << refusal;
  }
  EXPECT_EQ(to_cause(Refusal::none), gateway_CAUSE_NONE);
  EXPECT_EQ(to_cause(Refusal::unknown_job), gateway_CAUSE_UNKNOWN_JOB);
  EXPECT_EQ(to_cause(Refusal::bus_unavailable), gateway_CAUSE_BUS_UNAVAILABLE);
  EXPECT_EQ(to_cause(Refusal::not_permitted), gateway_CAUSE_RIGHT);
  EXPECT_EQ(to_cause(Refusal::mapping_changed), gateway_CAUSE_MAPPING_CHANGED);
  EXPECT_EQ(to_cause(Refusal::too_old), gateway_CAUSE_STALE);
  EXPECT_NE(explain(Refusal::queue_full, line()).find("256 parameter jobs and 32 transfers"),
            std::string::npos);
}

}  // namespace
}  // namespace cansync::dds
