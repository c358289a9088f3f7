#include "can/pcapng.h"

#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <vector>

#include "can/pcapng_reader.h"
#include "flagged_frames.h"

namespace can {
namespace {

using std::chrono::nanoseconds;
using test::data_frame;
using test::error;
using test::extended;
using test::remote;

/// Bytes written as hexadecimal digits; blanks do not count.
std::string bytes(const std::string& digits) {
  std::string compact;
  for (const char c : digits)
    if (c != ' ') compact += c;
  std::string out;
  for (std::size_t i = 0; i + 1 < compact.size(); i += 2)
    out += static_cast<char>(std::stoi(compact.substr(i, 2), nullptr, 16));
  return out;
}

// The bytes below are the fields of figures 9 (section header), 10 (interface description) and 11 (enhanced
// packet) of draft-ietf-opsawg-pcapng and of the page of LINKTYPE_CAN_SOCKETCAN, written out by hand.
const char* const kSection =
    "0A0D0D0A 2C000000 4D3C2B1A 0100 0000 FFFFFFFFFFFFFFFF"  // type, length 44, order, 1.0, length not told
    "0400 0500 7472616365 000000"                            // shb_userappl "trace", padded
    "0000 0000 2C000000";                                    // end of options, length
const char* const kInterface =
    "01000000 28000000 E300 0000 10000000"  // type, length 40, 227, reserved, snapshot length 16
    "0200 0400 63616E30"                    // if_name "can0"
    "0900 0100 09 000000"                   // if_tsresol: 10^-9 s
    "0000 0000 28000000";
TEST(Pcapng, SectionHeaderIsAsTheDraftDrawsIt) {
  EXPECT_EQ(PcapngWriter::begin("trace"), bytes(kSection));
}

TEST(Pcapng, FirstFrameOfAnInterfaceDescribesIt) {
  PcapngWriter writer;
  // 0x0000000100000002 ns.
  const std::string got =
      writer.frame(nanoseconds(0x100000002), "can0", data_frame(0x503, {0x71, 0x2D, 0, 0}));
  const std::string packet = bytes(
      "06000000 30000000 00000000 01000000 02000000"  // type, length 48, interface 0, time high, time low
      "10000000 10000000"                             // captured, original length
      "00000503 04 00 0000 712D0000 00000000"         // identifier big endian, length, no FD flags
      "30000000");
  EXPECT_EQ(got, bytes(kInterface) + packet);
  EXPECT_EQ(writer.frame(nanoseconds(0x100000002), "can0", data_frame(0x503, {0x71, 0x2D, 0, 0})), packet)
      << "described once";
}

TEST(Pcapng, KindsHaveTheirFlags) {
  PcapngWriter writer;
  (void)writer.frame(nanoseconds(0), "can0", {});
  const auto header = [&writer](const Frame& told) {
    return writer.frame(nanoseconds(0), "can0", told).substr(28, 5);
  };
  EXPECT_EQ(header(extended(data_frame(0x123, {1}))), bytes("80000123 01"));
  EXPECT_EQ(header(remote(data_frame(0x101, {0, 0}))), bytes("40000101 02"));
  EXPECT_EQ(header(extended(remote(data_frame(0x12345, {})))), bytes("C0012345 00"));
  EXPECT_EQ(header(extended(remote(data_frame(0x123, {})))), bytes("C0000123 00"));
  EXPECT_EQ(header(error(data_frame(0x008, {0, 0, 0, 0, 0, 0, 0, 0}))), bytes("20000008 08"));
}

TEST(Pcapng, InterfacesAreNumberedInTheirOrder) {
  PcapngWriter writer;
  (void)writer.frame(nanoseconds(0), "sync", {});
  (void)writer.frame(nanoseconds(0), "can0", {});
  EXPECT_EQ(writer.frame(nanoseconds(0), "sync", {}).substr(8, 4), bytes("00000000"));
  EXPECT_EQ(writer.frame(nanoseconds(0), "can0", {}).substr(8, 4), bytes("01000000"));
}

TEST(Pcapng, NegativeTimesCountAsZeroAndLongDataAsEight) {
  PcapngWriter writer;
  (void)writer.frame(nanoseconds(0), "can0", {});
  Frame wrong = data_frame(0x101, {1, 2, 3, 4, 5, 6, 7, 8});
  wrong.dlc = 15;
  const std::string got = writer.frame(nanoseconds(-1), "can0", wrong);
  EXPECT_EQ(got.substr(12, 8), bytes("0000000000000000"));
  EXPECT_EQ(got.substr(28, 16), bytes("00000101 08 000000 0102030405060708"));
}

/// Everything in a capture that is fed in pieces of `step` bytes.
std::vector<PcapngReader::Item> read_all(const std::string& file, std::size_t step, std::size_t& left) {
  PcapngReader reader;
  std::vector<PcapngReader::Item> out;
  for (std::size_t at = 0; at < file.size(); at += step) {
    reader.feed(std::string_view(file).substr(at, step));
    while (auto item = reader.next()) out.push_back(*item);
  }
  left = reader.unfinished();
  return out;
}

TEST(PcapngReader, ReadsWhatIsWrittenInPiecesOfAnySize) {
  PcapngWriter writer;
  const std::vector<Frame> frames{data_frame(0x080, {}),
                                  data_frame(0x101, {1, 2, 3, 4, 5, 6, 7, 8}),
                                  extended(data_frame(0x12345, {9})),
                                  remote(data_frame(0x101, {0, 0})),
                                  extended(remote(data_frame(0x101, {}))),
                                  extended(remote(data_frame(0x12345, {0}))),
                                  error(data_frame(0x008, {0, 0, 0, 0, 0, 0, 0, 1}))};
  std::string file = PcapngWriter::begin("test");
  for (std::size_t i = 0; i < frames.size(); ++i)
    file += writer.frame(nanoseconds(1'500'000'000 + 1000 * static_cast<int>(i)), i == 0 ? "sync" : "can0",
                         frames[i]);
  for (std::size_t step = 1; step <= file.size(); ++step) {
    std::size_t left = 0;
    const auto items = read_all(file, step, left);
    EXPECT_EQ(left, 0u);
    ASSERT_EQ(items.size(), frames.size()) << step;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const auto* line = std::get_if<CandumpLine>(&items[i]);
      ASSERT_NE(line, nullptr);
      EXPECT_EQ(line->frame, frames[i]);
      EXPECT_EQ(line->interface, i == 0 ? "sync" : "can0");
      EXPECT_EQ(line->time, std::chrono::microseconds(1'500'000 + static_cast<int>(i)));
    }
  }
}

TEST(PcapngReader, ReadsTheOtherByteOrderMicrosecondsAndUnknownBlocks) {
  const std::string file = bytes(
      "0A0D0D0A 0000001C 1A2B3C4D 0001 0000 FFFFFFFFFFFFFFFF 0000001C00000005 00000010 "
      "00000000 00000010"                              // a block that is passed over
      "00000001 00000014 00E3 0000 00000000 00000014"  // no options: microseconds, no name
      "00000006 00000030 00000000 00000000 000F4241 00000010 0000001000000301 02 00 0000 ABCD000000000000 "
      "00000030");
  std::size_t left = 0;
  const auto items = read_all(file, file.size(), left);
  ASSERT_EQ(items.size(), 1u);
  const auto& line = std::get<CandumpLine>(items[0]);
  EXPECT_EQ(line.time, std::chrono::microseconds(1'000'001));
  EXPECT_EQ(line.interface, "if0");
  EXPECT_EQ(line.frame, data_frame(0x301, {0xAB, 0xCD}));
}

TEST(PcapngReader, NamesWhatItCannotRead) {
  const std::string head = PcapngWriter::begin("t");
  const auto first = [&head](const std::string& rest) {
    std::size_t left = 0;
    const auto items = read_all(head + bytes(rest), 7, left);
    const auto* error = items.empty() ? nullptr : std::get_if<PcapngError>(&items[0]);
    return error == nullptr ? std::string("nothing") : error->message;
  };
  EXPECT_EQ(first("01000000 14000000 0100 0000 00000000 14000000"),
            "block 2: interface if0 has link type 1; only 227 (CAN) is read, its packets are left out");
  EXPECT_EQ(
      first("01000000 14000000 7100 0000 00000000 14000000"),
      "block 2: interface if0 has link type 113 (Linux cooked capture, as of the interface 'any'); only 227 (CAN) is "
      "read, its packets are left out; capture the CAN interface itself");
  EXPECT_EQ(first("06000000 20000000 00000000 00000000 00000000 00000000 00000000 20000000"),
            "block 2: a packet of interface 0, which is not described");
  EXPECT_EQ(first("06000000 03000000 00000000"),
            "block 2: length 3; allowed are 12 to 268435456 in steps of 4. This is no pcapng capture");
  EXPECT_EQ(first("05000000 10000000 00000000 14000000"), "block 2: its two lengths differ");
}

/// One packet of interface 0 in an enhanced block of 48 or more bytes.
std::string enhanced(const std::string& packet, std::uint8_t bytes_in_it) {
  const unsigned padded = (bytes_in_it + 3u) / 4u * 4u;
  const auto little = [](unsigned number) {
    std::string out;
    for (unsigned i = 0; i < 4; ++i) out += static_cast<char>((number >> (8 * i)) & 0xFF);
    return out;
  };
  std::string data = bytes(packet);
  data.resize(padded);
  const std::string length = little(32 + padded);
  return little(6) + length + little(0) + little(0) + little(7) + little(bytes_in_it) + little(bytes_in_it) +
         data + length;
}

// struct can_frame and struct canfd_frame of linux/can.h: 16 and 72 bytes; kernels leave bytes 5 to 7 of the first
// as they were.
TEST(PcapngReader, TheSizeOfAPacketTellsClassicFramesFromCanFd) {
  const std::string head = bytes(kSection) + bytes(kInterface);
  const auto only = [&head](const std::string& packet) {
    std::size_t left = 0;
    auto items = read_all(head + packet, 4096, left);
    EXPECT_EQ(items.size(), 1u);
    return items.at(0);
  };
  const auto garbage = only(enhanced("00000301 02 FF FFFF ABCD 1122 33445566", 16));
  ASSERT_TRUE(std::holds_alternative<CandumpLine>(garbage)) << std::get<PcapngError>(garbage).message;
  EXPECT_EQ(std::get<CandumpLine>(garbage).frame, data_frame(0x301, {0xAB, 0xCD}));
  const auto wrong = [&only](const std::string& packet, std::uint8_t size) {
    const auto item = only(enhanced(packet, size));
    return std::holds_alternative<PcapngError>(item) ? std::get<PcapngError>(item).message : "nothing";
  };
  EXPECT_EQ(wrong("00000123 0C 00 0000 000102030405060708090A0B", 72),
            "block 3: a CAN FD frame, which is no CAN 2.0 frame");
  EXPECT_EQ(wrong("00000123 04 04 0000 00010203", 12), "block 3: a CAN FD frame, which is no CAN 2.0 frame");
  EXPECT_EQ(wrong("00000321 80 03 0300 CDAB0000 0A0B0C", 15),
            "block 3: a CAN XL frame, which is no CAN 2.0 frame");
  EXPECT_EQ(wrong("00000123 09 00 0000 0001020304050607", 16), "block 3: a packet that is no CAN 2.0 frame");
}

TEST(PcapngReader, ABlockThatIsTooLongIsToldAndLeftOut) {
  const std::string begin = bytes("04000000 08001000");  // name resolution of 1 MiB and 8 bytes
  const std::string block = begin + std::string((1u << 20) - 4, 'x') + bytes("08001000");
  const std::string packet = enhanced("00000301 02 00 0000 ABCD 1122 33445566", 16);
  const std::string head = bytes(kSection) + bytes(kInterface);
  for (const std::size_t step : {std::size_t{4093}, std::size_t{1} << 22}) {
    std::size_t left = 0;
    const auto items = read_all(head + block + packet, step, left);
    ASSERT_EQ(items.size(), 2u) << step;
    EXPECT_EQ(std::get<PcapngError>(items[0]).message,
              "block 3: length 1048584, which is over 1048576; it is left out");
    EXPECT_FALSE(std::get<PcapngError>(items[0]).fatal);
    EXPECT_EQ(std::get<CandumpLine>(items[1]).frame, data_frame(0x301, {0xAB, 0xCD}));
    EXPECT_EQ(left, 0u);
  }
  std::size_t left = 0;
  EXPECT_EQ(read_all(head + block.substr(0, 2000), 4096, left).size(), 1u);
  EXPECT_EQ(left, 2000u) << "it is cut off";
  const auto wrong = read_all(head + begin + std::string(1u << 20, 'x') + packet, 1u << 22, left);
  ASSERT_EQ(wrong.size(), 2u);
  EXPECT_EQ(std::get<PcapngError>(wrong[1]).message, "block 3: its two lengths differ");
}

// The blocks of sections 4.4 and appendix A of the draft.
TEST(PcapngReader, ReadsSimpleAndObsoletePackets) {
  const std::string file =
      bytes(kSection) + bytes(kInterface) +
      bytes(
          "02000000 30000000 0000 0000 00000000 40420F00 10000000 10000000"  // 1,000,000 ns
          "00000301 02 000000 ABCD0000 00000000 30000000"
          "03000000 20000000 10000000"
          "00000302 01 000000 EF000000 00000000 20000000");
  std::size_t left = 0;
  const auto items = read_all(file, 11, left);
  ASSERT_EQ(items.size(), 2u);
  for (const auto& item : items) ASSERT_TRUE(std::holds_alternative<CandumpLine>(item));
  EXPECT_EQ(std::get<CandumpLine>(items[0]).frame, data_frame(0x301, {0xAB, 0xCD}));
  EXPECT_EQ(std::get<CandumpLine>(items[0]).time, std::chrono::microseconds(1000));
  EXPECT_EQ(std::get<CandumpLine>(items[1]).frame, data_frame(0x302, {0xEF}));
  EXPECT_EQ(std::get<CandumpLine>(items[1]).time, std::chrono::microseconds(1000))
      << "it has none of its own";
}

TEST(PcapngReader, PacketsThatLieAreNotBelieved) {
  PcapngWriter writer;
  const std::string described = PcapngWriter::begin("t") + writer.frame(nanoseconds(0), "can0", {});
  const std::string good = writer.frame(nanoseconds(0), "can0", data_frame(0x101, {1, 2}));
  const auto second = [&described](const std::string& packet) {
    std::size_t left = 0;
    const auto items = read_all(described + packet, 100, left);
    const auto* error = items.size() < 2 ? nullptr : std::get_if<PcapngError>(&items[1]);
    return error == nullptr ? std::string("nothing") : error->message;
  };
  std::string longer = good;
  longer[20] = 17;
  EXPECT_EQ(second(longer), "block 4: a packet longer than its block");
  std::string data = good;
  data[32] = 9;
  EXPECT_EQ(second(data), "block 4: a packet that is no CAN 2.0 frame");
}

TEST(PcapngReader, GarbageNeitherCrashesNorFillsMemory) {
  std::string file = PcapngWriter::begin("t");
  std::uint32_t state = 1;
  for (int i = 0; i < 20000; ++i) {
    state = state * 1664525 + 1013904223;
    file += static_cast<char>(state >> 24);
  }
  for (std::size_t cut = 0; cut < 64; ++cut) {
    std::size_t left = 0;
    const auto items = read_all(file.substr(0, file.size() - cut), 61, left);
    ASSERT_FALSE(items.empty());
  }
}

}  // namespace
}  // namespace can
