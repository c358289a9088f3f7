// Every telegram against bytes written by hand from the tables of M 3.2.1, in both directions.

#include <gtest/gtest.h>

#include <algorithm>
#include <initializer_list>
#include <string>
#include <vector>

#include "cansync/telegram/telegram.h"

namespace cansync {
namespace {

using Direction = TransferInitialise::Direction;
using Kind = ParameterCommand::Kind;

SlaveNumber slave(unsigned number) {
  return *SlaveNumber::from(number);
}
ParameterNumber parameter(unsigned number) {
  return *ParameterNumber::from(number);
}
Element element(unsigned number) {
  return *Element::from(number);
}
BlockOffset bytes(unsigned number) {
  return *BlockOffset::from(number);
}

struct Golden {
  std::string name;
  Telegram telegram;
  std::uint32_t id;
  std::vector<std::uint8_t> data;
};

can::Frame frame_of(const Golden& golden) {
  can::Frame frame;
  frame.id = golden.id;
  frame.dlc = static_cast<std::uint8_t>(golden.data.size());
  std::copy(golden.data.begin(), golden.data.end(), frame.data.begin());
  return frame;
}

std::vector<Golden> actions() {
  return {
      {"action_control_word_to_slave_3",
       ActionCommand{{0x00000008}, 1, 0, 0x047F},
       0x010,
       {0x08, 0x00, 0x00, 0x00, 0x01, 0x00, 0x7F, 0x04}},
      {"action_activate_sync_mode_all",
       ActionCommand{{0xFFFFFFFF}, 2, 1, 0},
       0x010,
       {0xFF, 0xFF, 0xFF, 0xFF, 0x02, 0x01, 0x00, 0x00}},
      {"action_user_128_slaves_0_and_31",
       ActionCommand{{0x80000001}, 128, 0x5A, 0x1234},
       0x010,
       {0x01, 0x00, 0x00, 0x80, 0x80, 0x5A, 0x34, 0x12}},
      {"action_user_255_nobody",
       ActionCommand{{0}, 255, 0xFF, 0xFFFF},
       0x010,
       {0, 0, 0, 0, 0xFF, 0xFF, 0xFF, 0xFF}},
  };
}

std::vector<Golden> process_data() {
  return {
      {"reference_1_asks_slave_5",
       ReferenceTelegram{Channel::one, 5, 4, {0x1122, 0x3344, 0x5566, 0x7788}},
       0x105,
       {0x22, 0x11, 0x44, 0x33, 0x66, 0x55, 0x88, 0x77}},
      {"reference_2_asks_nobody",
       ReferenceTelegram{Channel::two, 127, 4, {0xFFFF, 0, 1, 0x8000}},
       0x1FF,
       {0xFF, 0xFF, 0x00, 0x00, 0x01, 0x00, 0x00, 0x80}},
      {"reference_1_without_words", ReferenceTelegram{Channel::one, 0, 0, {}}, 0x100, {}},
      {"reference_1_nobody_below_127", ReferenceTelegram{Channel::one, 32, 1, {0xA55A}}, 0x120, {0x5A, 0xA5}},
      {"reference_2_three_words_slave_31",
       ReferenceTelegram{Channel::two, 31, 3, {0x0102, 0x0304, 0x0506}},
       0x19F,
       {0x02, 0x01, 0x04, 0x03, 0x06, 0x05}},
      {"actual_1_of_slave_0",
       ActualTelegram{Channel::one, slave(0), 4, {0x1122, 0x3344, 0x5566, 0x7788}},
       0x300,
       {0x22, 0x11, 0x44, 0x33, 0x66, 0x55, 0x88, 0x77}},
      {"actual_2_of_slave_31_one_word",
       ActualTelegram{Channel::two, slave(31), 1, {0xBEEF}},
       0x39F,
       {0xEF, 0xBE}},
      {"actual_1_of_slave_16_two_words",
       ActualTelegram{Channel::one, slave(16), 2, {0x0001, 0x0002}},
       0x310,
       {0x01, 0x00, 0x02, 0x00}},
      {"actual_2_without_words", ActualTelegram{Channel::two, slave(1), 0, {}}, 0x381, {}},
  };
}

std::vector<Golden> parameter_commands() {
  return {
      {"read_301_of_slave_7",
       ParameterCommand{slave(7), Kind::read, parameter(301), element(7), 0, {}},
       0x507,
       {0x71, 0x2D, 0x00, 0x00}},
      {"read_4095_element_0_sub_slave",
       ParameterCommand{slave(0), Kind::read, parameter(4095), element(0), 0, {0x1234}},
       0x500,
       {0x0F, 0xFF, 0x34, 0x12}},
      {"read_256_element_5",
       ParameterCommand{slave(1), Kind::read, parameter(256), element(5), 0, {}},
       0x501,
       {0x51, 0x00, 0x00, 0x00}},
      {"write_word_1",
       ParameterCommand{slave(0), Kind::write_word, parameter(1), element(7), 0xABCD, {}},
       0x500,
       {0x70, 0x01, 0xCD, 0xAB, 0x00, 0x00}},
      {"write_word_sub_slave",
       ParameterCommand{slave(9), Kind::write_word, parameter(0x9AB), element(7), 1, {0x0203}},
       0x509,
       {0x79, 0xAB, 0x01, 0x00, 0x03, 0x02}},
      {"write_doubleword_2048_of_slave_31",
       ParameterCommand{slave(31), Kind::write_doubleword, parameter(2048), element(7), 0x12345678, {0xFFFF}},
       0x51F,
       {0x78, 0x00, 0x78, 0x56, 0x34, 0x12, 0xFF, 0xFF}},
      {"write_to_element_3_decodes",  // refused by the slave, not by the decoder
       ParameterCommand{slave(2), Kind::write_word, parameter(16), element(3), 0x0100, {}},
       0x502,
       {0x30, 0x10, 0x00, 0x01, 0x00, 0x00}},
  };
}

std::vector<Golden> transfer_commands() {
  return {
      {"initialise_upload_300",
       TransferInitialise{slave(4), Direction::upload, bytes(300), 0x00010000, {}},
       0x504,
       {0x91, 0x2C, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00}},
      {"initialise_download_4092",
       TransferInitialise{slave(31), Direction::download, bytes(4092), 0x12345678, {9}},
       0x51F,
       {0xDF, 0xFC, 0x78, 0x56, 0x34, 0x12, 0x09, 0x00}},
      {"cancel", cancel_transfer(slave(6)), 0x506, {0x90, 0, 0, 0, 0, 0, 0, 0}},
      {"upload_body_294", UploadBlock{slave(4), bytes(294), false}, 0x504, {0xA1, 0x26}},
      {"upload_body_0", UploadBlock{slave(0), bytes(0), false}, 0x500, {0xA0, 0x00}},
      {"upload_last_4086", UploadBlock{slave(31), bytes(4086), true}, 0x51F, {0xBF, 0xF6}},
      {"download_body_0",
       DownloadBlock{slave(8), bytes(0), false, {1, 2, 3, 4, 5, 6}},
       0x508,
       {0xE0, 0x00, 0x01, 0x02, 0x03, 0x04, 0x05, 0x06}},
      {"download_last_258",
       DownloadBlock{slave(8), bytes(258), true, {0xFF, 0xFE, 0, 0, 0, 0}},
       0x508,
       {0xF1, 0x02, 0xFF, 0xFE, 0x00, 0x00, 0x00, 0x00}},
  };
}

std::vector<Golden> parameter_replies() {
  return {
      {"reply_read_word",
       ParameterReply{slave(3), parameter(301), false, false, 4, {0x00, 0x80, 0x00, 0x00}},
       0x583,
       {0x01, 0x2D, 0x00, 0x80, 0x00, 0x00}},
      {"reply_read_doubleword",
       ParameterReply{slave(0), parameter(4095), false, false, 6, {0x78, 0x56, 0x34, 0x12, 0x34, 0x12}},
       0x580,
       {0x0F, 0xFF, 0x78, 0x56, 0x34, 0x12, 0x34, 0x12}},
      {"reply_write_done",
       ParameterReply{slave(31), parameter(1), false, false, 2, {0x05, 0x00}},
       0x59F,
       {0x00, 0x01, 0x05, 0x00}},
      {"reply_write_done_without_sub_slave",
       ParameterReply{slave(31), parameter(1), false, false, 0, {}},
       0x59F,
       {0x00, 0x01}},
      {"reply_error_above_maximum",
       ParameterReply{slave(3), parameter(301), false, true, 4, {0xFD, 0xFF, 0x00, 0x00}},
       0x583,
       {0x21, 0x2D, 0xFD, 0xFF, 0x00, 0x00}},
      {"reply_error_without_sub_slave",
       ParameterReply{slave(3), parameter(301), false, true, 2, {0xFB, 0xFF}},
       0x583,
       {0x21, 0x2D, 0xFB, 0xFF}},
      {"reply_busy_shortest",
       ParameterReply{slave(3), parameter(301), true, false, 0, {}},
       0x583,
       {0x41, 0x2D}},
      {"reply_busy_odd_length",
       ParameterReply{slave(3), parameter(301), true, false, 1, {0x99}},
       0x583,
       {0x41, 0x2D, 0x99}},
      {"reply_busy_longest",
       ParameterReply{slave(3), parameter(301), true, false, 6, {1, 2, 3, 4, 5, 6}},
       0x583,
       {0x41, 0x2D, 1, 2, 3, 4, 5, 6}},
      {"reply_busy_and_error",
       ParameterReply{slave(3), parameter(301), true, true, 0, {}},
       0x583,
       {0x61, 0x2D}},
  };
}

std::vector<Golden> transfer_replies() {
  return {
      {"transfer_initialised_length_as_asked",
       TransferReply{slave(4), bytes(0), false, false, 0, {}},
       0x584,
       {0x80, 0x00}},
      {"transfer_initialised_length_300",
       TransferReply{slave(4), bytes(300), false, false, 0, {}},
       0x584,
       {0x81, 0x2C}},
      {"transfer_upload_data",
       TransferReply{slave(31), bytes(6), false, false, 6, {0x11, 0x22, 0x33, 0x44, 0x55, 0x66}},
       0x59F,
       {0x80, 0x06, 0x11, 0x22, 0x33, 0x44, 0x55, 0x66}},
      {"transfer_download_taken",
       TransferReply{slave(0), bytes(4086), false, false, 0, {}},
       0x580,
       {0x8F, 0xF6}},
      {"transfer_error_0105",
       TransferReply{slave(4), bytes(0), false, true, 2, {0x05, 0x01}},
       0x584,
       {0xA0, 0x00, 0x05, 0x01}},
      {"transfer_busy_shortest", TransferReply{slave(4), bytes(6), true, false, 0, {}}, 0x584, {0xC0, 0x06}},
      {"transfer_busy_five_bytes",
       TransferReply{slave(4), bytes(6), true, false, 3, {7, 8, 9}},
       0x584,
       {0xC0, 0x06, 7, 8, 9}},
  };
}

std::vector<Golden> all() {
  std::vector<Golden> rows;
  for (const auto& part : {actions(), process_data(), parameter_commands(), transfer_commands(),
                           parameter_replies(), transfer_replies()}) {
    rows.insert(rows.end(), part.begin(), part.end());
  }
  return rows;
}

class GoldenBytes : public testing::TestWithParam<Golden> {};

TEST_P(GoldenBytes, Encode) {
  EXPECT_TRUE(encode(GetParam().telegram) == frame_of(GetParam()));
}

TEST_P(GoldenBytes, Decode) {
  const Decoded decoded = decode(frame_of(GetParam()));
  const auto* telegram = std::get_if<Telegram>(&decoded);
  ASSERT_NE(telegram, nullptr) << name(std::get<DecodeError>(decoded));
  EXPECT_TRUE(*telegram == GetParam().telegram);
}

INSTANTIATE_TEST_SUITE_P(Wire, GoldenBytes, testing::ValuesIn(all()),
                         [](const auto& row) { return row.param.name; });

TEST(GoldenTable, HoldsEveryTelegram) {
  std::array<unsigned, std::variant_size_v<Telegram>> rows = {};
  for (const Golden& golden : all()) ++rows[golden.telegram.index()];
  for (std::size_t i = 0; i < rows.size(); ++i) EXPECT_GE(rows[i], 2u) << "telegram " << i;
}

}  // namespace
}  // namespace cansync
