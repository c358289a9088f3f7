#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <initializer_list>
#include <numeric>
#include <optional>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "drive_rig.h"

// The drive's parameters and memory, asked over the bus.
namespace sim {
namespace {

using cansync::ParameterCommand;
using cansync::ParameterError;
using cansync::ParameterReply;
using cansync::Telegram;
using cansync::TransferError;
using cansync::TransferInitialise;
using cansync::TransferReply;
using Kind = ParameterCommand::Kind;

class DriveJobs : public ::testing::Test {
 protected:
  explicit DriveJobs(const DriveSettings& settings = rig_settings()) : rig_(settings) { rig_.edge(); }

  /// Sends the telegram and takes the answer apart.
  template <class Reply>
  Reply ask(const Telegram& telegram) {
    const auto answer = rig_.send(telegram);
    if (!answer) {
      ADD_FAILURE() << "no answer";
      return {};
    }
    const cansync::Decoded decoded = cansync::decode(answer->frame);
    const auto* got = std::get_if<Telegram>(&decoded);
    if (got == nullptr || !std::holds_alternative<Reply>(*got)) {
      ADD_FAILURE() << "not the kind of answer that was due";
      return {};
    }
    return std::get<Reply>(*got);
  }

  ParameterReply parameter(Kind kind, std::uint16_t number, std::uint32_t value = 0, std::uint8_t element = 7,
                           std::uint16_t sub = 0) {
    return ask<ParameterReply>(ParameterCommand{rig_.drive.number(),
                                                kind,
                                                *cansync::ParameterNumber::from(number),
                                                *cansync::Element::from(element),
                                                value,
                                                {sub}});
  }
  std::uint32_t word(std::uint16_t number, std::uint8_t element = 7) {
    const ParameterReply reply = parameter(Kind::read, number, 0, element);
    EXPECT_FALSE(reply.error);
    EXPECT_EQ(reply.payload_size, 4) << "a word";
    return cansync::load_word(reply.payload.data());
  }
  std::uint32_t doubleword(std::uint16_t number, std::uint8_t element = 7) {
    const ParameterReply reply = parameter(Kind::read, number, 0, element);
    EXPECT_FALSE(reply.error);
    EXPECT_EQ(reply.payload_size, 6) << "a doubleword";
    return cansync::load_doubleword(reply.payload.data());
  }
  static ParameterError error(const ParameterReply& reply) {
    return reply.error ? static_cast<ParameterError>(cansync::load_word(reply.payload.data()))
                       : ParameterError::none;
  }
  ParameterError write(Kind kind, std::uint16_t number, std::uint32_t value) {
    return error(parameter(kind, number, value));
  }

  TransferReply initialise(TransferInitialise::Direction direction, std::uint16_t length,
                           std::uint32_t address, std::uint16_t sub = 0) {
    return ask<TransferReply>(TransferInitialise{
        rig_.drive.number(), direction, *cansync::BlockOffset::from(length), address, {sub}});
  }
  static TransferError error(const TransferReply& reply) {
    return reply.error ? static_cast<TransferError>(cansync::load_word(reply.payload.data()))
                       : TransferError::none;
  }

  DriveRig rig_;
};

constexpr auto kUpload = TransferInitialise::Direction::upload;
constexpr auto kDownload = TransferInitialise::Direction::download;

TEST_F(DriveJobs, TellsWhatItIs) {
  EXPECT_EQ(word(parameter::device_type), 4400u);
  EXPECT_EQ(doubleword(parameter::firmware_version), 0x00010000u);
  EXPECT_EQ(doubleword(parameter::serial_number), 1003u);
  EXPECT_EQ(word(parameter::slave_number), kRigNumber);
  EXPECT_EQ(write(Kind::write_word, parameter::device_type, 1), ParameterError::not_changeable);
}

TEST_F(DriveJobs, MirrorsStateInParameters) {
  rig_.lock();
  for (int i = 0; i < 300; ++i) rig_.follow(i * 100);
  EXPECT_EQ(word(parameter::control_word), control_bit::run);
  EXPECT_EQ(word(parameter::status_word), rig_.drive.status_word());
  EXPECT_EQ(doubleword(parameter::position), rig_.drive.actual()[0]);
  EXPECT_EQ(doubleword(parameter::speed), rig_.drive.actual()[1]);
  EXPECT_EQ(doubleword(parameter::following_error), rig_.drive.actual()[2]);
  EXPECT_EQ(doubleword(parameter::position_setpoint), 29'900u);
  EXPECT_EQ(word(parameter::torque), rig_.drive.actual()[4] & 0xFFFF);
  EXPECT_EQ(word(parameter::temperature), rig_.drive.actual()[6]);
  rig_.edges(4);
  EXPECT_EQ(doubleword(parameter::missed_references), 4u);
  EXPECT_EQ(word(parameter::misses_in_a_row), 4u);
  rig_.edge(2);
  EXPECT_EQ(doubleword(parameter::missed_edges), 2u);
  rig_.send(DriveRig::action(128, 7, 0x1234));
  EXPECT_EQ(word(parameter::fault_code), 0x1234u);
  EXPECT_EQ(doubleword(parameter::last_action), 0x80071234u);
  EXPECT_EQ(doubleword(parameter::action_count), 1u);
}

TEST_F(DriveJobs, KeepsPlainWordsAndDoublewords) {
  for (std::uint16_t i = 0; i < parameter::plain_count; ++i) {
    const auto word_number = static_cast<std::uint16_t>(1000 + i);
    const auto doubleword_number = static_cast<std::uint16_t>(1020 + i);
    EXPECT_EQ(write(Kind::write_word, word_number, 0xFF00u + i), ParameterError::none);
    EXPECT_EQ(write(Kind::write_doubleword, doubleword_number, 0xABCD0000u + i), ParameterError::none);
    EXPECT_EQ(word(word_number), 0xFF00u + i);
    EXPECT_EQ(doubleword(doubleword_number), 0xABCD0000u + i);
  }
  EXPECT_EQ(error(parameter(Kind::read, 1040)), ParameterError::not_present);
}

TEST_F(DriveJobs, HoldsLimitsInBothFormats) {
  EXPECT_EQ(write(Kind::write_word, parameter::lag, 10'000), ParameterError::none);
  EXPECT_EQ(write(Kind::write_word, parameter::lag, 10'001), ParameterError::above_maximum);
  EXPECT_EQ(word(parameter::lag), 10'000u);
  EXPECT_EQ(write(Kind::write_word, parameter::torque_offset, 0xFFFF), ParameterError::none) << "-1";
  EXPECT_EQ(write(Kind::write_word, parameter::torque_offset, 0x8000), ParameterError::below_minimum);
  EXPECT_EQ(write(Kind::write_doubleword, parameter::maximum_speed, 0), ParameterError::below_minimum);
  EXPECT_EQ(write(Kind::write_doubleword, parameter::maximum_speed, 0x80000000),
            ParameterError::above_maximum);
}

TEST_F(DriveJobs, RefusesTheOtherFormat) {
  EXPECT_EQ(write(Kind::write_doubleword, parameter::lag, 1), ParameterError::wrong_format);
  EXPECT_EQ(write(Kind::write_word, parameter::user_doubleword, 1), ParameterError::wrong_format);
}

TEST_F(DriveJobs, ElementsTellLimitsAndInitialValue) {
  EXPECT_EQ(word(parameter::torque_offset, 0), 0xFC18u) << "-1000";
  EXPECT_EQ(word(parameter::torque_offset, 1), 1000u);
  EXPECT_EQ(write(Kind::write_word, parameter::lag, 7), ParameterError::none);
  EXPECT_EQ(word(parameter::lag, 2), 50u);
  EXPECT_EQ(doubleword(parameter::maximum_speed, 0), 1u);
  EXPECT_EQ(doubleword(parameter::maximum_speed, 1), 0x7FFFFFFFu);
  EXPECT_EQ(error(parameter(Kind::read, 1000, 0, 0)), ParameterError::not_present) << "no limits";
  for (std::uint8_t element = 3; element < 7; ++element) {
    EXPECT_EQ(error(parameter(Kind::read, parameter::lag, 0, element)), ParameterError::not_present);
  }
}

TEST_F(DriveJobs, ParameterThatIsNeverAvailable) {
  EXPECT_EQ(error(parameter(Kind::read, parameter::not_available)), ParameterError::not_available_now);
  EXPECT_EQ(write(Kind::write_word, parameter::not_available, 1), ParameterError::not_available_now);
}

TEST_F(DriveJobs, SubSlavesAreNotPresent) {
  const ParameterReply reply = parameter(Kind::read, parameter::device_type, 0, 7, 12);
  EXPECT_EQ(error(reply), ParameterError::not_present);
  EXPECT_EQ(cansync::load_word(reply.payload.data() + 2), 12) << "the address comes back";
  EXPECT_EQ(error(parameter(Kind::write_word, 1000, 5, 7, 12)), ParameterError::not_present);
  EXPECT_EQ(word(1000), 0u);
  EXPECT_EQ(error(initialise(kUpload, 6, 0x100, 12)), TransferError::address_not_allowed);
}

TEST_F(DriveJobs, AnswersBusyASettableNumberOfTimes) {
  EXPECT_EQ(write(Kind::write_word, parameter::busy_replies, 2), ParameterError::none);
  for (int job = 0; job < 2; ++job) {
    EXPECT_TRUE(parameter(Kind::read, parameter::busy).busy);
    EXPECT_TRUE(parameter(Kind::read, parameter::busy).busy);
    EXPECT_EQ(word(parameter::busy), 410u);
  }
  EXPECT_TRUE(parameter(Kind::write_word, parameter::busy, 5).busy);
  EXPECT_TRUE(parameter(Kind::write_word, parameter::busy, 5).busy);
  EXPECT_EQ(rig_.drive.parameters().value(parameter::busy), 410u) << "not yet written";
  EXPECT_FALSE(parameter(Kind::write_word, parameter::busy, 5).busy);
  EXPECT_EQ(rig_.drive.parameters().value(parameter::busy), 5u);
}

TEST_F(DriveJobs, AnotherJobMakesABusyOneStartAgain) {
  EXPECT_EQ(write(Kind::write_word, parameter::busy_replies, 2), ParameterError::none);
  EXPECT_TRUE(parameter(Kind::read, parameter::busy).busy);
  EXPECT_TRUE(parameter(Kind::read, parameter::busy).busy);
  EXPECT_EQ(word(parameter::device_type), 4400u);
  EXPECT_TRUE(parameter(Kind::read, parameter::busy).busy);
  EXPECT_TRUE(parameter(Kind::read, parameter::busy).busy);
  EXPECT_EQ(word(parameter::busy), 410u);
}

TEST_F(DriveJobs, EndlessBusy) {
  EXPECT_EQ(write(Kind::write_word, parameter::busy_replies, 0xFFFF), ParameterError::none);
  for (int i = 0; i < 100'000; ++i) ASSERT_TRUE(parameter(Kind::read, parameter::busy).busy);
  rig_.drive.answer_busy(DriveParameters::kEndless);
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(parameter(Kind::read, parameter::device_type).busy);
  rig_.drive.answer_busy(1);
  EXPECT_TRUE(parameter(Kind::read, parameter::device_type).busy);
  EXPECT_EQ(word(parameter::device_type), 4400u);
}

class OtherStatusParameter : public DriveJobs {
 protected:
  static DriveSettings settings() {
    DriveSettings result = rig_settings();
    result.status_parameter = 55;
    result.parameters.push_back({56, true, ParameterDefinition::Access::read_write, 0x12345678});
    result.parameters.push_back({1000, false, ParameterDefinition::Access::read_only, 3});
    result.parameters.push_back({5000});
    return result;
  }
  OtherStatusParameter() : DriveJobs(settings()) {}
};

TEST_F(OtherStatusParameter, StatusWordAndFurtherParametersAreSettable) {
  EXPECT_EQ(word(55), rig_.drive.status_word());
  EXPECT_EQ(doubleword(56), 0x12345678u);
  EXPECT_EQ(word(1000), 3u) << "the later definition counts";
  EXPECT_EQ(write(Kind::write_word, 1000, 1), ParameterError::not_changeable);
}

// --- the documented table

/// One row a parameter, as docs/simulated-drive.md writes it; ranges of numbers taken apart.
std::set<std::string> documented_rows() {
  std::ifstream document(CANSYNC_DRIVE_DOC);
  EXPECT_TRUE(document.is_open()) << CANSYNC_DRIVE_DOC;
  const std::regex row(R"(\| (\d+)(?:\.\.(\d+))? (\| (?:word|doubleword) \|[^|]*\|[^|]*\|[^|]*)\|[^|]*\|)");
  std::set<std::string> rows;
  std::smatch match;
  for (std::string line; std::getline(document, line);) {
    if (!std::regex_match(line, match, row)) continue;
    const int first = std::stoi(match[1]);
    const int last = match[2].matched ? std::stoi(match[2]) : first;
    for (int number = first; number <= last; ++number) {
      rows.insert(std::to_string(number) + " " + match[3].str());
    }
  }
  return rows;
}

TEST(DriveDocument, TableHasEveryParameterAsItIs) {
  std::set<std::string> rows;
  for (const ParameterDefinition& definition : standard_parameters()) {
    const std::array<const char*, 3> access = {"read, write", "read only", "never"};
    const std::string limits = definition.limited ? std::to_string(definition.minimum) + ".." +
                                                        std::to_string(definition.maximum) + " "
                                                  : "";
    rows.insert(std::to_string(definition.number) + " | " + (definition.doubleword ? "doubleword" : "word") +
                " | " + access.at(static_cast<std::size_t>(definition.access)) + " | " +
                std::to_string(definition.initial) + " | " + limits);
  }
  EXPECT_EQ(documented_rows(), rows);
}

// --- memory

class Transfers : public DriveJobs {
 protected:
  explicit Transfers(const DriveSettings& settings = rig_settings()) : DriveJobs(settings) {}

  void download(std::uint32_t address, const std::vector<std::uint8_t>& data) {
    ASSERT_EQ(error(initialise(kDownload, static_cast<std::uint16_t>(data.size()), address)),
              TransferError::none);
    for (std::size_t offset = 0; offset < data.size(); offset += 6) {
      cansync::DownloadBlock block{
          rig_.drive.number(), *cansync::BlockOffset::from(offset), offset + 6 >= data.size(), {}};
      block.data.fill(0xEE);
      std::copy_n(data.begin() + static_cast<std::ptrdiff_t>(offset),
                  std::min<std::size_t>(6, data.size() - offset), block.data.begin());
      const auto reply = ask<TransferReply>(block);
      ASSERT_EQ(error(reply), TransferError::none);
      ASSERT_EQ(reply.offset.value(), offset);
    }
  }

  std::vector<std::uint8_t> upload(std::uint32_t address, std::uint16_t length) {
    std::vector<std::uint8_t> data;
    EXPECT_EQ(error(initialise(kUpload, length, address)), TransferError::none);
    for (std::size_t offset = 0; offset < length; offset += 6) {
      const auto reply = ask<TransferReply>(cansync::UploadBlock{
          rig_.drive.number(), *cansync::BlockOffset::from(offset), offset + 6u >= length});
      EXPECT_EQ(error(reply), TransferError::none);
      data.insert(data.end(), reply.payload.begin(), reply.payload.end());
    }
    data.resize(length);
    return data;
  }
};

TEST_F(Transfers, WhatWasDownloadedIsUploadedAgain) {
  for (const std::uint16_t length : std::initializer_list<std::uint16_t>{1, 5, 6, 7, 299, 300}) {
    std::vector<std::uint8_t> data(length);
    std::iota(data.begin(), data.end(), static_cast<std::uint8_t>(length));
    download(0x123, data);
    EXPECT_EQ(upload(0x123, length), data);
    EXPECT_NE(rig_.drive.memory().contents()[0x23u + length], 0xEE) << "no padding in the memory";
  }
  EXPECT_EQ(rig_.drive.memory().completed(), 12u);
}

TEST_F(Transfers, AddressesOutsideTheMemoryAreRefused) {
  EXPECT_EQ(error(initialise(kUpload, 6, 0xFF)), TransferError::address_not_allowed);
  EXPECT_EQ(error(initialise(kDownload, 6, 0x100 + 4096)), TransferError::address_not_allowed);
  EXPECT_EQ(error(initialise(kDownload, 6, 0xFFFFFFFF)), TransferError::address_not_allowed);
  EXPECT_EQ(error(initialise(kDownload, 7, 0x100 + 4090)), TransferError::block_too_long);
  EXPECT_EQ(error(initialise(kDownload, 6, 0x100 + 4090)), TransferError::none);
  EXPECT_EQ(error(initialise(kDownload, 301, 0x100)), TransferError::longer_than_300_bytes);
}

TEST_F(Transfers, CancelIsCounted) {
  initialise(kDownload, 12, 0x100);
  EXPECT_EQ(error(initialise(kUpload, 0, 0)), TransferError::none);
  EXPECT_EQ(rig_.drive.memory().cancelled(), 1u);
  EXPECT_EQ(rig_.drive.memory().completed(), 0u);
}

TEST_F(Transfers, BusyTransferTelegrams) {
  rig_.drive.memory().set_busy_replies(2);
  for (int i = 0; i < 2; ++i) EXPECT_TRUE(initialise(kUpload, 6, 0x100).busy);
  EXPECT_FALSE(initialise(kUpload, 6, 0x100).busy);
  const cansync::UploadBlock last{rig_.drive.number(), {}, true};
  for (int i = 0; i < 2; ++i) EXPECT_TRUE(ask<TransferReply>(last).busy);
  EXPECT_FALSE(ask<TransferReply>(last).busy);
}

TEST_F(Transfers, CancelledWhileBusyTheNextIsBusyAsOftenAgain) {
  rig_.drive.memory().set_busy_replies(2);
  EXPECT_TRUE(initialise(kUpload, 6, 0x100).busy);
  initialise(kUpload, 0, 0);
  EXPECT_TRUE(initialise(kUpload, 6, 0x100).busy);
  EXPECT_TRUE(initialise(kUpload, 6, 0x100).busy);
  EXPECT_FALSE(initialise(kUpload, 6, 0x100).busy);
}

TEST_F(Transfers, DriveMayFixTheUploadLength) {
  rig_.drive.memory().set_upload_length(10);
  std::iota(rig_.drive.memory().contents().begin(), rig_.drive.memory().contents().begin() + 10, 1);
  EXPECT_EQ(initialise(kUpload, 24, 0x100).offset.value(), 10);
  ask<TransferReply>(cansync::UploadBlock{rig_.drive.number(), {}, false});
  const auto last =
      ask<TransferReply>(cansync::UploadBlock{rig_.drive.number(), *cansync::BlockOffset::from(6), true});
  EXPECT_EQ(last.payload, (std::array<std::uint8_t, 6>{7, 8, 9, 10, 0, 0}));
}

class DoublewordAddresses : public Transfers {
 protected:
  static DriveSettings settings() {
    DriveSettings result = rig_settings();
    result.memory.address_step = 4;
    result.slave.block_limit = 4092;
    return result;
  }
  DoublewordAddresses() : Transfers(settings()) {}
};

TEST_F(DoublewordAddresses, CountInStepsOfFourBytes) {
  std::vector<std::uint8_t> data(4092);
  for (std::size_t i = 0; i < data.size(); ++i) data[i] = static_cast<std::uint8_t>(i * 7);
  download(0x101, data);
  EXPECT_EQ(rig_.drive.memory().contents()[4], data[0]);
  EXPECT_EQ(upload(0x101, 4092), data);
}

}  // namespace
}  // namespace sim
