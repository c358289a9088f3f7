// Identifiers, NAMEs, filters and diagnostic messages, byte by byte. Rows of docs/j1939.md.
#include "j1939/identifier.h"

#include <gtest/gtest.h>

#include <vector>

#include "j1939/diagnostics.h"
#include "j1939/name.h"
#include "j1939/pgn_filter.h"

namespace j1939 {
namespace {

TEST(Identifier, LayoutOfPriorityReservedPageFormatSpecificAndSource) {
  // Electronic engine controller 1 of the engine, as every description of J1939 shows it.
  const Identifier engine{3, false, false, 0xF0, 0x04, 0x00};
  EXPECT_EQ(compose(engine), 0x0CF00400u);
  EXPECT_EQ(parse(0x0CF00400u), engine);
  // Each field alone, at its place.
  EXPECT_EQ(compose(Identifier{7, false, false, 0, 0, 0}), 7u << 26);
  EXPECT_EQ(compose(Identifier{0, true, false, 0, 0, 0}), 1u << 25);
  EXPECT_EQ(compose(Identifier{0, false, true, 0, 0, 0}), 1u << 24);
  EXPECT_EQ(compose(Identifier{0, false, false, 0xFF, 0, 0}), 0xFFu << 16);
  EXPECT_EQ(compose(Identifier{0, false, false, 0, 0xFF, 0}), 0xFFu << 8);
  EXPECT_EQ(compose(Identifier{0, false, false, 0, 0, 0xFF}), 0xFFu);
  EXPECT_EQ(compose(Identifier{15, false, false, 0, 0, 0}), 7u << 26) << "only three bits";
  for (const std::uint32_t bits : {0u, 0x1FFFFFFFu, 0x15555555u, 0x0AAAAAAAu, 0x18EEFF80u})
    EXPECT_EQ(compose(parse(bits)), bits);
}

TEST(Identifier, BelowPf240ThePsIsTheDestination) {
  const Identifier torque = parse(0x0C000B03u);  // TSC1 from 3 to 11
  EXPECT_EQ(pgn_of(torque), 0u);
  EXPECT_EQ(destination_of(torque), 0x0B);
  const Identifier last = parse(0x18EF1122u);
  EXPECT_EQ(pgn_of(last), 0xEF00u);
  EXPECT_EQ(destination_of(last), 0x11);
  EXPECT_EQ(identifier_of(0xEF00, 6, 0x11, 0x22), last);
  EXPECT_TRUE(has_destination(0xEF00));
  EXPECT_FALSE(is_pgn(0xEF11)) << "its lowest byte is no part of the number";
}

TEST(Identifier, FromPf240OnThePsIsTheGroupExtension) {
  const Identifier first = parse(0x18F00403u);
  EXPECT_EQ(pgn_of(first), 0xF004u);
  EXPECT_EQ(destination_of(first), kGlobalAddress);
  EXPECT_EQ(identifier_of(0xF004, 6, 0x55, 0x03), first) << "the destination has no place";
  EXPECT_FALSE(has_destination(0xF000));
  EXPECT_TRUE(is_pgn(0xFFFF));
}

TEST(Identifier, BothPageBitsBelongToTheNumberOfTheGroup) {
  EXPECT_EQ(pgn_of(parse(0x19FECA00u)), 0x1FECAu);
  EXPECT_EQ(pgn_of(parse(0x1AFECA00u)), 0x2FECAu);
  EXPECT_EQ(compose(identifier_of(0x3FECA, 6, 255, 0)), 0x1BFECA00u);
  EXPECT_FALSE(is_pgn(0x40000));
}

TEST(Name, FieldsStandAtTheirBits) {
  const NameFields all{0x1FFFFF, 0x7FF, 7, 0x1F, 0xFF, 0x7F, 0xF, 7, true};
  EXPECT_EQ(compose(all), ~Name{0} & ~(Name{1} << 48)) << "bit 48 is reserved";
  EXPECT_EQ(fields_of(compose(all)), all);
  EXPECT_EQ(compose(NameFields{.identity = 1}), 1u);
  EXPECT_EQ(compose(NameFields{.manufacturer = 1}), Name{1} << 21);
  EXPECT_EQ(compose(NameFields{.ecu_instance = 1}), Name{1} << 32);
  EXPECT_EQ(compose(NameFields{.function_instance = 1}), Name{1} << 35);
  EXPECT_EQ(compose(NameFields{.function = 1}), Name{1} << 40);
  EXPECT_EQ(compose(NameFields{.vehicle_system = 1}), Name{1} << 49);
  EXPECT_EQ(compose(NameFields{.vehicle_system_instance = 1}), Name{1} << 56);
  EXPECT_EQ(compose(NameFields{.industry_group = 1}), Name{1} << 60);
  EXPECT_EQ(compose(NameFields{.arbitrary_address = true}), Name{1} << 63);
}

TEST(PgnFilter, TheFirstRangeThatTakesAMessageCounts) {
  PgnFilter filter;
  ASSERT_TRUE(filter.add({0xFEF0, 0xFEFF, std::nullopt}));
  ASSERT_TRUE(filter.add({0xF000, 0xFFFF, Address{7}}));
  EXPECT_EQ(filter.match(0xFEF0, 1), 0);
  EXPECT_EQ(filter.match(0xFEFF, 7), 0);
  EXPECT_EQ(filter.match(0xF004, 7), 1);
  EXPECT_EQ(filter.match(0xF004, 8), std::nullopt);
  EXPECT_EQ(filter.match(0xEF00, 7), std::nullopt);
  for (std::size_t i = 2; i < PgnFilter::kMostRanges; ++i) EXPECT_TRUE(filter.add({}));
  EXPECT_FALSE(filter.add({}));
}

TEST(Diagnostics, LampsAndCodesOfActiveFaults) {
  // SPN 1208, FMI 3, 10 times; the example of J1939-73. Amber lamp on, flashing fast.
  const std::vector<std::uint8_t> one = {0x04, 0xF7, 0xB8, 0x04, 0x03, 0x0A, 0xFF, 0xFF};
  ASSERT_EQ(trouble_codes_in(one), 1u);
  EXPECT_EQ(trouble_code(one, 0), (TroubleCode{1208, 3, 10, false}));
  const auto lamps = lamps_of(one);
  ASSERT_TRUE(lamps);
  EXPECT_EQ(lamps->amber_warning, Lamp::on);
  EXPECT_EQ(lamps->flash[2], LampFlash::fast);
  EXPECT_EQ(lamps->flash[0], LampFlash::steady);
  EXPECT_EQ(lamps->malfunction, Lamp::off);
  const std::vector<std::uint8_t> largest = {0, 0, 0xFF, 0xFF, 0xFE, 0xFF, 1, 0, 0x20, 0x81};
  ASSERT_EQ(trouble_codes_in(largest), 2u);
  EXPECT_EQ(trouble_code(largest, 0), (TroubleCode{0x7FFFF, 30, 127, true}));
  EXPECT_EQ(trouble_code(largest, 1), (TroubleCode{0x10001, 0, 1, true}));
}

TEST(Diagnostics, NoFaultsAndWhatIsTooShort) {
  EXPECT_EQ(trouble_codes_in(std::vector<std::uint8_t>{0, 0xFF, 0, 0, 0, 0, 0xFF, 0xFF}), 0u);
  EXPECT_EQ(trouble_codes_in(std::vector<std::uint8_t>{0, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}), 0u);
  EXPECT_EQ(trouble_codes_in(std::vector<std::uint8_t>{0, 0, 1, 1, 1}), 0u);
  EXPECT_EQ(trouble_codes_in(std::vector<std::uint8_t>(1785, 1)), kMostTroubleCodes);
  EXPECT_FALSE(lamps_of(std::vector<std::uint8_t>{0}));
}

}  // namespace
}  // namespace j1939
