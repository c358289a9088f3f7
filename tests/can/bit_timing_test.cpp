#include "can/bit_timing.h"

#include <gtest/gtest.h>

#include <string>

namespace {

using can::BitTimingRegisters;
using can::Controller;

TEST(BitTiming, EveryPresetGivesTheBitRateItIsNamedFor) {
  for (const can::BitTimingPreset& preset : can::kBitTimingPresets) {
    const auto timing = can::decode(preset.registers, can::clock_hz(preset.controller));
    ASSERT_TRUE(timing.has_value());
    EXPECT_EQ(timing->bits_per_second, preset.bits_per_second);
    EXPECT_TRUE(timing->exact);
  }
}

TEST(BitTiming, PlcSamplesAtSixtyPercent) {
  const auto timing = can::decode({0x40, 0x34}, 20'000'000);
  ASSERT_TRUE(timing.has_value());
  EXPECT_EQ(timing->quanta, 10);
  EXPECT_EQ(timing->quantum_ps, 100'000u);
  EXPECT_EQ(timing->sample_point, 600);
  EXPECT_EQ(timing->prescaler, 1);
  EXPECT_EQ(timing->segment1, 5);
  EXPECT_EQ(timing->segment2, 4);
  EXPECT_EQ(timing->jump_width, 2);
  EXPECT_FALSE(timing->triple_sampling);
}

TEST(BitTiming, OmegaSamplesAtEightySevenAndAHalfPercent) {
  const auto timing = can::decode({0x03, 0x1C}, 16'000'000);
  ASSERT_TRUE(timing.has_value());
  EXPECT_EQ(timing->quanta, 16);
  EXPECT_EQ(timing->quantum_ps, 500'000u);
  EXPECT_EQ(timing->sample_point, 875);
  EXPECT_EQ(timing->prescaler, 4);
  EXPECT_EQ(timing->segment1, 13);
  EXPECT_EQ(timing->segment2, 2);
  EXPECT_EQ(timing->jump_width, 1);
}

TEST(BitTiming, PresetsNeedTheirOwnClock) {
  // The PLC's registers at the Omega's clock would be 800 kbit/s, the Omega's at the PLC's 625.
  EXPECT_EQ(can::decode({0x40, 0x34}, can::kOmegaClockHz)->bits_per_second, 800'000u);
  EXPECT_EQ(can::decode({0x00, 0x1C}, can::kPlcClockHz)->bits_per_second, 625'000u);
}

TEST(BitTiming, EveryFieldOfTheRegisters) {
  const auto timing = can::decode({0xFF, 0xFF}, 25'000'000);
  ASSERT_TRUE(timing.has_value());
  EXPECT_EQ(timing->jump_width, 4);
  EXPECT_EQ(timing->prescaler, 64);
  EXPECT_EQ(timing->segment1, 16);
  EXPECT_EQ(timing->segment2, 8);
  EXPECT_TRUE(timing->triple_sampling);
  EXPECT_EQ(timing->quanta, 25);
  EXPECT_EQ(timing->bits_per_second, 7'813u);  // 25 MHz / (2 * 64 * 25) = 7812.5
  EXPECT_FALSE(timing->exact);
}

TEST(BitTiming, WhatCannotWorkIsRefused) {
  EXPECT_FALSE(can::decode({0x40, 0x34}, 0).has_value()) << "no clock";
  EXPECT_FALSE(can::decode({0x40, 0x0C}, 16'000'000).has_value()) << "SJW 2 over TSEG2 1";
  EXPECT_FALSE(can::decode({0x80, 0x21}, 16'000'000).has_value()) << "SJW 3 over TSEG1 2";
  EXPECT_TRUE(can::decode({0x80, 0x22}, 16'000'000).has_value()) << "SJW 3 with segments of 3";
}

TEST(BaudrateSelection, ZeroTakesTheRegistersAsGiven) {
  const BitTimingRegisters given{0x12, 0x34};
  EXPECT_EQ(can::select_baudrate(Controller::plc, 0, given), (can::BaudrateSelection{given, 0}));
  EXPECT_EQ(can::select_baudrate(Controller::omega, 0, given), (can::BaudrateSelection{given, 0}));
}

TEST(BaudrateSelection, PresetsIgnoreTheRegistersGiven) {
  const BitTimingRegisters given{0x12, 0x34};
  EXPECT_EQ(can::select_baudrate(Controller::plc, 3, given).registers, (BitTimingRegisters{0x47, 0x34}));
  EXPECT_EQ(can::select_baudrate(Controller::plc, 4, given).registers, (BitTimingRegisters{0x43, 0x34}));
  EXPECT_EQ(can::select_baudrate(Controller::plc, 5, given).registers, (BitTimingRegisters{0x41, 0x34}));
  EXPECT_EQ(can::select_baudrate(Controller::plc, 6, given).registers, (BitTimingRegisters{0x40, 0x34}));
  EXPECT_EQ(can::select_baudrate(Controller::omega, 3, given).registers, (BitTimingRegisters{0x03, 0x1C}));
  EXPECT_EQ(can::select_baudrate(Controller::omega, 4, given).registers, (BitTimingRegisters{0x01, 0x1C}));
  EXPECT_EQ(can::select_baudrate(Controller::omega, 5, given).registers, (BitTimingRegisters{0x00, 0x1C}));
}

TEST(BaudrateSelection, AnythingElseIs125KbitWithTheInputError) {
  const BitTimingRegisters given{0x12, 0x34};
  for (unsigned value = 1; value < 256; ++value) {
    const auto us_baudrate = static_cast<std::uint8_t>(value);
    const auto plc = can::select_baudrate(Controller::plc, us_baudrate, given);
    const auto omega = can::select_baudrate(Controller::omega, us_baudrate, given);
    if (value < 3 || value > 6) {
      EXPECT_EQ(plc, (can::BaudrateSelection{{0x47, 0x34}, 0x0002})) << value;
    } else {
      EXPECT_EQ(plc.error, 0) << value;
    }
    if (value < 3 || value > 5) {
      EXPECT_EQ(omega, (can::BaudrateSelection{{0x03, 0x1C}, 0x0002})) << value;
    } else {
      EXPECT_EQ(omega.error, 0) << value;
    }
  }
}

}  // namespace
