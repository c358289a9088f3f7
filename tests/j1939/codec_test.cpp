// What nodes say to each other, byte by byte, both ways: the layouts of SAE J1939-21 and J1939-81.
#include "j1939/codec.h"

#include <gtest/gtest.h>

#include <vector>

#include "j1939/node_rig.h"

namespace j1939::test {
namespace {

/// From 0x21 to 0x80; the group 0xFEF2 stands in the last three bytes.
constexpr std::uint32_t kControl = 0x1CEC8021;
constexpr std::uint32_t kExtendedControl = 0x1CC88021;

struct Row {
  const char* what;
  can::Frame bytes;
  TransportControl fields;
};

std::vector<Row> rows() {
  return {
      {"RTS: 16, size, packets, most of a window",
       frame(kControl, {16, 20, 0, 3, 5, 0xF2, 0xFE, 0x00}),
       {false, 0xFEF2, RequestToSend{20, 3, 5}}},
      {"RTS of the longest",
       frame(kControl, {16, 0xF9, 0x06, 255, 255, 0xF2, 0xFE, 0x00}),
       {false, 0xFEF2, RequestToSend{1785, 255, 255}}},
      {"CTS: 17, packets, the first, reserved",
       frame(kControl, {17, 2, 3, 255, 255, 0xF2, 0xFE, 0x00}),
       {false, 0xFEF2, ClearToSend{2, 3}}},
      {"CTS that holds",
       frame(kControl, {17, 0, 255, 255, 255, 0xF2, 0xFE, 0x00}),
       {false, 0xFEF2, ClearToSend{0, 255}}},
      {"EOMA: 19, size, packets, reserved",
       frame(kControl, {19, 20, 0, 3, 255, 0xF2, 0xFE, 0x00}),
       {false, 0xFEF2, EndOfMessage{20, 3}}},
      {"BAM: 32, size, packets, reserved",
       frame(kControl, {32, 20, 0, 3, 255, 0xF2, 0xFE, 0x00}),
       {false, 0xFEF2, Announcement{20, 3}}},
      {"abort: 255, reason, reserved",
       frame(kControl, {255, 3, 255, 255, 255, 0xF2, 0xFE, 0x00}),
       {false, 0xFEF2, Abort{AbortReason::timeout}}},
      {"a group of the highest page",
       frame(kControl, {255, 1, 255, 255, 255, 0xCA, 0xFE, 0x03}),
       {false, 0x3FECA, Abort{AbortReason::busy}}},
      {"extended RTS: 20, size in four bytes",
       frame(kExtendedControl, {20, 0x04, 0x03, 0x02, 0x01, 0xF2, 0xFE, 0x00}),
       {true, 0xFEF2, RequestToSend{0x01020304}}},
      {"extended CTS: 21, packets, the first in three bytes",
       frame(kExtendedControl, {21, 2, 0x03, 0x02, 0x01, 0xF2, 0xFE, 0x00}),
       {true, 0xFEF2, ClearToSend{2, 0x010203}}},
      {"DPO: 22, packets, offset in three bytes",
       frame(kExtendedControl, {22, 2, 0x03, 0x02, 0x01, 0xF2, 0xFE, 0x00}),
       {true, 0xFEF2, DataOffset{2, 0x010203}}},
      {"extended EOMA: 23, size in four bytes",
       frame(kExtendedControl, {23, 0x04, 0x03, 0x02, 0x01, 0xF2, 0xFE, 0x00}),
       {true, 0xFEF2, EndOfMessage{0x01020304}}},
      {"extended abort",
       frame(kExtendedControl, {255, 12, 255, 255, 255, 0xF2, 0xFE, 0x00}),
       {true, 0xFEF2, Abort{AbortReason::wrong_offset}}},
  };
}

TEST(Codec, ConnectionManagementBothWays) {
  for (const Row& row : rows()) {
    EXPECT_EQ(transport_control_in(row.bytes), row.fields) << row.what;
    EXPECT_EQ(frame_of(row.fields, 0x21, 0x80), row.bytes) << row.what;
  }
  EXPECT_EQ(frame_of(rows()[0].fields, 0x21, 0x80, 3),
            frame(0x0CEC8021, {16, 20, 0, 3, 5, 0xF2, 0xFE, 0x00}));
}

TEST(Codec, EachFormKnowsItsOwnFirstBytesAndEightOfThem) {
  for (int first = 0; first < 256; ++first) {
    const bool plain = first == 16 || first == 17 || first == 19 || first == 32 || first == 255;
    const bool extended = (first >= 20 && first <= 23) || first == 255;
    EXPECT_EQ(transport_control_in(frame(kControl, {first, 0, 0, 0, 0, 0, 0, 0})).has_value(), plain)
        << first;
    EXPECT_EQ(transport_control_in(frame(kExtendedControl, {first, 0, 0, 0, 0, 0, 0, 0})).has_value(),
              extended)
        << first;
  }
  EXPECT_FALSE(transport_control_in(frame(kControl, {16, 20, 0, 3, 5, 0xF2, 0xFE})));
  EXPECT_FALSE(transport_control_in(frame(kControl, {})));
}

TEST(Codec, PacketsBothWays) {
  const std::vector<std::uint8_t> ten = counting(10);
  EXPECT_EQ(frame_of(Packet{1, ten}, false, 0x21, 0x80, 7), frame(0x1CEB8021, {1, 1, 2, 3, 4, 5, 6, 7}));
  const can::Frame last = frame(0x18C78021, {2, 8, 9, 10, 0xFF, 0xFF, 0xFF, 0xFF});
  EXPECT_EQ(frame_of(Packet{2, std::span(ten).subspan(7)}, true, 0x21, 0x80, 6), last);
  const auto packet = packet_in(last);
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->number, 2);
  EXPECT_EQ(std::vector(packet->data.begin(), packet->data.begin() + 3),
            (std::vector<std::uint8_t>{8, 9, 10}));
  EXPECT_FALSE(packet_in(frame(0x1CEB8021, {1, 1, 2})));
}

TEST(Codec, AcknowledgementsBothWays) {
  using Kind = Acknowledgement::Kind;
  for (const Kind kind : {Kind::positive, Kind::negative, Kind::denied, Kind::cannot_respond}) {
    const Acknowledgement said{kind, 0x21, 0x1FECA};
    const can::Frame bytes =
        frame(0x18E8FF80, {static_cast<int>(kind), 0xFF, 0xFF, 0xFF, 0x21, 0xCA, 0xFE, 0x01});
    EXPECT_EQ(frame_of(said, 0x80), bytes);
    EXPECT_EQ(acknowledgement_in(bytes.data), said);
  }
  EXPECT_FALSE(acknowledgement_in(std::vector<std::uint8_t>{4, 0xFF, 0xFF, 0xFF, 0x21, 0xCA, 0xFE, 0x00}));
  EXPECT_FALSE(acknowledgement_in(std::vector<std::uint8_t>{0, 0xFF, 0xFF, 0xFF, 0x21, 0xCA, 0xFE}));
}

TEST(Codec, RequestsBothWays) {
  EXPECT_EQ(request_frame(0x1FECA, 0x80, 0x21), frame(0x18EA2180, {0xCA, 0xFE, 0x01}));
  EXPECT_EQ(requested_in(std::vector<std::uint8_t>{0xCA, 0xFE, 0x01}), 0x1FECAu);
  EXPECT_EQ(requested_in(std::vector<std::uint8_t>{0xCA, 0xFE, 0x01, 0xFF}), 0x1FECAu)
      << "padded, as some do";
  EXPECT_FALSE(requested_in(std::vector<std::uint8_t>{0xCA, 0xFE}));
}

TEST(Codec, ClaimsAndCommandedAddresses) {
  EXPECT_EQ(claim_frame(compose(kFields), kOwn), own_claim(kOwn));
  const std::vector<std::uint8_t> name = {0x45, 0x23, 0xE1, 0x00, 0x00, 0x80, 0x00, 0x80};
  EXPECT_EQ(claimed_name_in(name), compose(kFields));
  EXPECT_FALSE(claimed_name_in(std::span(name).first(7)));
  std::vector<std::uint8_t> command = name;
  EXPECT_FALSE(commanded_address_in(command));
  command.push_back(0x33);
  EXPECT_EQ(commanded_address_in(command), (CommandedAddress{compose(kFields), 0x33}));
}

}  // namespace
}  // namespace j1939::test
