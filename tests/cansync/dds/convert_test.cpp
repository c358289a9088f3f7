#include "cansync/dds/convert.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

namespace cansync::dds {
namespace {

TEST(Text, IsCutToItsFieldAtAWholeCharacter) {
  char field[6];
  copy_text("abc", field);
  EXPECT_EQ(text(field), "abc");
  copy_text("abcdefgh", field);
  EXPECT_EQ(text(field), "abcde");
  copy_text("abcd\xC3\xA4", field);  // the two bytes of an umlaut do not fit any more
  EXPECT_EQ(text(field), "abcd");
  EXPECT_EQ(field[5], '\0');
  copy_text("", field);
  EXPECT_EQ(text(field), "");
}

TEST(ToCore, ParameterRequest) {
  cansync_ParameterRequest request = {};
  request.write = true;
  request.slave = 31;
  request.sub_slave = 0xABCD;
  request.number = 4095;
  request.element = 7;
  request.format = cansync_FORMAT_DOUBLEWORD;
  request.value = 0xDEADBEEF;
  request.timeout = 1500;
  const ParameterRequest core = to_core(request, 42);
  EXPECT_EQ(core.id, 42u);
  EXPECT_TRUE(core.write);
  EXPECT_EQ(core.slave.value(), 31);
  EXPECT_EQ(core.sub_slave.value, 0xABCD);
  EXPECT_EQ(core.number.value(), 4095);
  EXPECT_EQ(core.element.value(), 7);
  EXPECT_EQ(core.format, ParameterFormat::doubleword);
  EXPECT_EQ(core.value, 0xDEADBEEFu);
  EXPECT_EQ(core.monitoring_time, std::chrono::milliseconds(1500));
  request.format = cansync_FORMAT_WORD;
  EXPECT_EQ(to_core(request, 1).format, ParameterFormat::word);
  request.format = cansync_FORMAT_AS_SLAVE_SAYS;
  EXPECT_EQ(to_core(request, 1).format, ParameterFormat::as_slave_says);
}

TEST(ToCore, TransferRequest) {
  cansync_TransferRequest request = {};
  request.direction = cansync_DIRECTION_DOWNLOAD;
  request.slave = 9;
  request.address = 0x12345678;
  request.block_size = 4092;
  request.sub_slave = 3;
  std::vector<std::uint8_t> data(10);
  const TransferRequest core = to_core(request, 7, data);
  EXPECT_EQ(core.id, 7u);
  EXPECT_EQ(core.direction, TransferRequest::Direction::download);
  EXPECT_EQ(core.slave.value(), 9);
  EXPECT_EQ(core.address, 0x12345678u);
  EXPECT_EQ(core.block_size, 4092);
  EXPECT_EQ(core.sub_slave.value, 3);
  EXPECT_EQ(core.data.data(), data.data());
  EXPECT_EQ(core.data.size(), 10u);
  request.direction = cansync_DIRECTION_UPLOAD;
  EXPECT_EQ(to_core(request, 7, data).direction, TransferRequest::Direction::upload);
}

TEST(ToCore, Commands) {
  cansync_Command command = {};
  command.slave = 5;
  command.control_word = 0xBEEF;
  const ControlWordRequest word = to_control_word(command, 3);
  EXPECT_EQ(word.slave.value(), 5);
  EXPECT_EQ(word.control_word, 0xBEEF);
  command.priority = 1;
  command.slave_mask = 0x80000001;
  command.action = 200;
  command.data_byte = 0x12;
  command.data_word = 0x3456;
  const BroadcastRequest broadcast = to_broadcast(command, 4);
  EXPECT_EQ(broadcast.id, 4u);
  EXPECT_EQ(broadcast.priority, 1);
  EXPECT_EQ(broadcast.action, (ActionCommand{{0x80000001u}, 200, 0x12, 0x3456}));
}

TEST(ToCore, ReferenceValues) {
  cansync_ReferenceValues values = {};
  values.telegram = 2;
  values.value[3] = -1;
  values.valid = 0x8;
  values.from_interval = 99;
  const ReferenceUpdate update = to_core(values);
  EXPECT_EQ(update.channel, Channel::two);
  EXPECT_EQ(update.value[3], 0xFFFFFFFFu);
  EXPECT_EQ(update.valid_mask, 0x8);
  EXPECT_EQ(update.from_interval, 99u);
  EXPECT_EQ(update.release_intervals, 1u);  // 0 means 1
  values.telegram = 1;
  values.release_intervals = 50;
  EXPECT_EQ(to_core(values).channel, Channel::one);
  EXPECT_EQ(to_core(values).release_intervals, 50u);
}

TEST(Cursors, CodesBothWays) {
  for (std::int32_t code = 0; code < 32; ++code) {
    const auto cursor = to_cursor(code);
    ASSERT_TRUE(cursor.has_value());
    EXPECT_EQ(cursor->kind, Cursor::Kind::fixed);
    EXPECT_EQ(to_code(*cursor), code);
  }
  EXPECT_EQ(to_cursor(-128)->kind, Cursor::Kind::automatic);
  EXPECT_EQ(to_code(*to_cursor(-128)), -128);
  EXPECT_EQ(to_cursor(-1)->kind, Cursor::Kind::nobody);
  EXPECT_EQ(to_code(*to_cursor(-1)), -1);
  for (const std::int32_t code : {-2, 32, -127, 2147483647}) EXPECT_EQ(to_cursor(code), std::nullopt) << code;
}

TEST(Mappings, RegisterBytesBothWays) {
  const std::uint8_t bytes[8] = {0x01, 0x03, 0x00, 0x0D, 0x11, 0x1F, 0x00, 0x15};
  const auto mapping = to_mapping(bytes);
  ASSERT_TRUE(mapping.has_value());
  EXPECT_EQ((*mapping)[0].word[3], (WordMapping{true, false, 3}));
  EXPECT_EQ((*mapping)[1].word[1], (WordMapping{true, true, 7}));
  std::uint8_t back[8] = {};
  to_registers(*mapping, back);
  EXPECT_TRUE(std::equal(std::begin(bytes), std::end(bytes), std::begin(back)));
  const std::uint8_t wrong[8] = {0, 0, 0, 0, 0, 0, 0, 0x80};
  EXPECT_EQ(to_mapping(wrong), std::nullopt);
}

RequestKey key_with(std::uint64_t request) {
  gateway_JobCancel sample = {};
  sample.client[0] = 0xAA;
  sample.client[15] = 0xBB;
  sample.request = request;
  return key_of(sample);
}

TEST(Replies, ParameterCarriesKeyResultAndMeaning) {
  const ParameterResult done{Outcome::done, ParameterError::none, 0x12345678, true, 3, 1};
  const cansync_ParameterReply reply = parameter_reply(key_with(77), done);
  EXPECT_EQ(reply.client[0], 0xAA);
  EXPECT_EQ(reply.client[15], 0xBB);
  EXPECT_EQ(reply.request, 77u);
  EXPECT_EQ(reply.code, gateway_REPLY_DONE);
  EXPECT_EQ(text(reply.reason), "");
  EXPECT_EQ(reply.value, 0x12345678u);
  EXPECT_TRUE(reply.doubleword);
  EXPECT_EQ(reply.intervals, 3u);

  const cansync_ParameterReply error =
      parameter_reply(key_with(78), {Outcome::slave_error, ParameterError::below_minimum, 0, false, 1, 0});
  EXPECT_EQ(error.code, gateway_REPLY_SLAVE_ERROR);
  EXPECT_EQ(error.error_code, 0xFFFE);
  EXPECT_EQ(text(error.reason), "slave error 0xFFFE: " + std::string(meaning(ParameterError::below_minimum)));
}

TEST(Replies, TransferBorrowsItsData) {
  std::vector<std::uint8_t> data = {1, 2, 3};
  const TransferResult result{Outcome::slave_error, TransferError::block_too_long, 600, 606, 12, 2, 1};
  const cansync_TransferReply reply = transfer_reply(key_with(5), result, data);
  EXPECT_EQ(reply.code, gateway_REPLY_SLAVE_ERROR);
  EXPECT_EQ(reply.error_code, 0x0107);
  EXPECT_EQ(text(reply.reason), "slave error 0x0107: " + std::string(meaning(TransferError::block_too_long)));
  EXPECT_EQ(reply.done, 600u);
  EXPECT_EQ(reply.error_offset, 606u);
  EXPECT_EQ(reply.intervals, 12u);
  EXPECT_EQ(reply.repeated_telegrams, 2u);
  EXPECT_EQ(reply.repeated_blocks, 1u);
  EXPECT_EQ(reply.data._buffer, data.data());
  EXPECT_EQ(reply.data._length, 3u);
  EXPECT_FALSE(reply.data._release);
}

TEST(Replies, EveryOutcomeHasItsCodeAndAllButDoneAReason) {
  const std::vector<std::pair<Outcome, gateway_ReplyCode>> table = {
      {Outcome::done, gateway_REPLY_DONE},
      {Outcome::slave_error, gateway_REPLY_SLAVE_ERROR},
      {Outcome::timeout, gateway_REPLY_TIMEOUT},
      {Outcome::no_answer, gateway_REPLY_NO_ANSWER},
      {Outcome::word_expected, gateway_REPLY_WORD_EXPECTED},
      {Outcome::doubleword_expected, gateway_REPLY_DOUBLEWORD_EXPECTED},
      {Outcome::value_too_wide, gateway_REPLY_VALUE_TOO_WIDE},
      {Outcome::cancelled, gateway_REPLY_CANCELLED},
      {Outcome::master_stopped, gateway_REPLY_MASTER_STOPPED},
      {Outcome::slave_lost, gateway_REPLY_SLAVE_LOST},
      {Outcome::slave_held, gateway_REPLY_REFUSED},
      {Outcome::replaced, gateway_REPLY_REPLACED},
  };
  for (const auto& [outcome, code] : table) {
    const cansync_CommandReply reply = command_reply(key_with(1), outcome);
    EXPECT_EQ(reply.code, code);
    EXPECT_EQ(text(reply.reason).empty(), outcome == Outcome::done);
    EXPECT_TRUE(gateway::dds::fits(reply.code, reply.cause)) << name(outcome);
    ParameterResult parameter;
    parameter.outcome = outcome;
    EXPECT_EQ(parameter_reply(key_with(1), parameter).cause, reply.cause);
    TransferResult transfer;
    transfer.outcome = outcome;
    EXPECT_EQ(transfer_reply(key_with(1), transfer, {}).cause, reply.cause);
  }
}

TEST(Replies, RefusalsCarryCauseAndReasonAndNothingElse) {
  const std::string reason(300, 'x');
  const auto refused = parameter_refused(key_with(1), {gateway_CAUSE_FIELD, "slave 32: out of range"});
  EXPECT_EQ(refused.code, gateway_REPLY_REFUSED);
  EXPECT_EQ(refused.cause, gateway_CAUSE_FIELD);
  EXPECT_EQ(text(refused.reason), "slave 32: out of range");
  const auto transfer = transfer_refused(key_with(1), {gateway_CAUSE_LENGTH, reason});
  EXPECT_EQ(transfer.cause, gateway_CAUSE_LENGTH);
  EXPECT_EQ(text(transfer.reason), reason.substr(0, gateway_TEXT));
  const auto command = command_refused(key_with(9), {gateway_CAUSE_NO_SLAVES, reason});
  EXPECT_EQ(command.cause, gateway_CAUSE_NO_SLAVES);
  EXPECT_EQ(command.request, 9u);
}

TEST(State, ActualValuesAreScaledAsSignedNumbers) {
  std::array<cansync_ValueName, kValues> names = {};
  for (cansync_ValueName& name : names) {
    name.factor = 1.0;
    name.is_signed = true;
  }
  names[1].factor = 0.5;
  names[1].offset = 10.0;
  ActualValues values;
  values.value = {5, 0xFFFFFFFE, 0x80000000, 0, 0, 0, 0, 7};
  values.arrived = {true, false};
  values.count = {4, 0};
  values.interval = {100, 0};
  const cansync_ActualValues sample =
      actual_values(*SlaveNumber::from(6), "feeder", values, names, 103, 123456789);
  EXPECT_EQ(sample.slave, 6);
  EXPECT_EQ(text(sample.slave_name), "feeder");
  EXPECT_EQ(sample.raw[1], 0xFFFFFFFEu);
  EXPECT_EQ(sample.scaled[0], 5.0);
  EXPECT_EQ(sample.scaled[1], 9.0);
  EXPECT_EQ(sample.scaled[2], -2147483648.0);
  EXPECT_EQ(sample.arrived, 1);
  EXPECT_EQ(sample.ever, 1);
  EXPECT_EQ(sample.interval[0], 100u);
  EXPECT_EQ(sample.age[0], 3u);
  EXPECT_EQ(sample.receive_time, 123456789);
}

// Torque in 0.01 % as a word: -100 is -1.00 %, not +654.36 %.
TEST(State, AWordIsScaledWithItsOwnSign) {
  std::array<cansync_ValueName, kValues> names = {};
  for (cansync_ValueName& name : names) {
    name.factor = 0.01;
    name.is_signed = true;
  }
  names[1].is_signed = false;
  names[3].is_signed = false;
  ActualValues values;
  values.value = {0xFF9C, 0xFF9C, 0xFF9C, 0xFFFFFF9C};
  values.words = 0b0011;
  const cansync_ActualValues sample =
      actual_values(*SlaveNumber::from(6), "feeder", values, names, 103, 123456789);
  EXPECT_EQ(sample.raw[0], 0xFF9Cu) << "as on the bus";
  EXPECT_EQ(sample.words, 0b0011);
  EXPECT_DOUBLE_EQ(sample.scaled[0], -1.0);
  EXPECT_DOUBLE_EQ(sample.scaled[1], 654.36);
  EXPECT_DOUBLE_EQ(sample.scaled[2], 654.36) << "a doubleword";
  EXPECT_DOUBLE_EQ(sample.scaled[3], 42949671.96);
}

TEST(State, SlaveStatus) {
  SlaveStatus status;
  status.responds = true;
  status.status_word = 0x8003;
  status.longest_response = Duration(1234);
  status.missed_actual = 9;
  const ProcessMapping mapping = {default_mapping(Channel::one), default_mapping(Channel::two)};
  const cansync_SlaveStatus sample = slave_status(*SlaveNumber::from(2), "press", status, mapping, {});
  EXPECT_EQ(sample.slave, 2);
  EXPECT_TRUE(sample.responds);
  EXPECT_FALSE(sample.synchronized);
  EXPECT_EQ(sample.status_word, 0x8003);
  EXPECT_EQ(sample.longest_response, 1234);
  EXPECT_EQ(sample.missed_actual, 9u);
  EXPECT_EQ(sample.actual_mapping[0], 0x01);
  EXPECT_EQ(sample.actual_mapping[7], 0x17);  // high word of value 5
}

TEST(State, MasterStatus) {
  MasterSettings settings;
  settings.bit_rate = BitRate::kbit500;
  settings.slaves[3].configured = true;
  settings.process.maximum_slave = *SlaveNumber::from(3);
  settings.process.polling[1] = {Cursor::Kind::nobody, {}};
  settings.command_channel.serving = Serving::scan;
  MasterCounters counters;
  counters.rejected = {1, 2, 3, 4, 5, 6, 7};
  counters.unexpected_by_kind = {11, 12, 13, 14, 15};
  counters.unexpected = 8;
  cansync_MasterStatus sample = {};
  sample.interval = 5;
  fill_master_status(settings, counters, State::active_master, sample);
  EXPECT_EQ(sample.option_status, 0x0080);
  EXPECT_EQ(text(sample.state), name(State::active_master));
  EXPECT_EQ(sample.interval_length, 2'000'000u);
  EXPECT_EQ(sample.interval, 5u);  // not of the master's settings: stays
  EXPECT_EQ(sample.slaves_configured, 8u);
  EXPECT_EQ(sample.rejected_frames, 28u);
  EXPECT_EQ(sample.unexpected_frames, 8u);
  EXPECT_EQ(sample.frames_foreign, 1u);
  EXPECT_EQ(sample.frames_extended, 2u);
  EXPECT_EQ(sample.frames_remote, 3u);
  EXPECT_EQ(sample.frames_error, 4u);
  EXPECT_EQ(sample.frames_slave_number, 5u);
  EXPECT_EQ(sample.frames_length, 6u);
  EXPECT_EQ(sample.frames_reserved, 7u);
  EXPECT_EQ(sample.unexpected_slave, 11u);
  EXPECT_EQ(sample.unexpected_answer, 12u);
  EXPECT_EQ(sample.unexpected_late, 13u);
  EXPECT_EQ(sample.unexpected_duplicate, 14u);
  EXPECT_EQ(sample.unexpected_unasked, 15u);
  EXPECT_EQ(sample.polling_one, -128);
  EXPECT_EQ(sample.polling_two, -1);
  EXPECT_EQ(sample.maximum_slave, 3);
  EXPECT_EQ(text(sample.serving), "scan");
  EXPECT_EQ(sample.parameter_queue, 256u);
}

}  // namespace
}  // namespace cansync::dds
