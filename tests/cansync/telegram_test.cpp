// The codec as a whole: what is rejected and why, and that encode and decode are each other's inverse.

#include "cansync/telegram/telegram.h"

#include <gtest/gtest.h>

#include <optional>
#include <random>
#include <utility>
#include <vector>

namespace cansync {
namespace {

constexpr unsigned kSeed = 20240613;

can::Frame frame_of(std::uint32_t id, unsigned dlc, std::uint8_t first = 0) {
  can::Frame frame;
  frame.id = id;
  frame.dlc = static_cast<std::uint8_t>(dlc);
  if (dlc > 0) frame.data[0] = first;
  return frame;
}

std::optional<DecodeError> error_of(const can::Frame& frame) {
  const Decoded decoded = decode(frame);
  const auto* error = std::get_if<DecodeError>(&decoded);
  return error == nullptr ? std::nullopt : std::optional(*error);
}

// What the tables of M 3.2.1 allow, written down a second time and in another way: as a mask of lengths.
constexpr unsigned lengths(std::initializer_list<unsigned> list) {
  unsigned mask = 0;
  for (const unsigned dlc : list) mask |= 1u << dlc;
  return mask;
}

unsigned command_lengths(unsigned first) {
  if (first < 0x80) return lengths({4, 6, 8});
  switch (first >> 4) {
    case 0x9:  // initialise upload
    case 0xD:  // initialise download
    case 0xE:  // download body
    case 0xF:  // download last
      return lengths({8});
    case 0xA:  // upload body
    case 0xB:  // upload last
      return lengths({2});
    default:
      return 0;  // mode 00
  }
}

unsigned reply_lengths(unsigned first) {
  switch ((first >> 4) & ~1u) {  // bit 4 is free
    case 0x0:
      return lengths({2, 4, 6, 8});
    case 0x2:
      return lengths({4, 6});
    case 0x8:
      return lengths({2, 8});
    case 0xA:
      return lengths({4});
    case 0x4:
    case 0x6:
    case 0xC:
    case 0xE:
      return lengths({2, 3, 4, 5, 6, 7, 8});
    default:
      return 0;
  }
}

// Without two bytes there is no first byte to judge.
std::optional<DecodeError> expected_error(unsigned allowed, unsigned dlc) {
  if (((allowed >> dlc) & 1u) != 0) return std::nullopt;
  return allowed == 0 && dlc >= 2 ? DecodeError::reserved_bits : DecodeError::wrong_length;
}

TEST(Identifier, IsAChannelAndANumber) {
  // M 3.2.1: seven bits of number below four of channel.
  EXPECT_EQ(identifier::channel_of(0x51F), identifier::command);
  EXPECT_EQ(identifier::participant_of(0x51F), 31u);
  EXPECT_EQ(identifier::channel_of(0x1FF), identifier::reference_two);
  EXPECT_EQ(identifier::participant_of(0x1FF), kPollNobody);
  EXPECT_NE(identifier::channel_of(0x1000'0500), identifier::command)
      << "a longer identifier is of no channel";
}

TEST(SlaveMask, IsGoneThroughFromTheLowestOnAsItWas) {
  const auto seen = [](SlaveMask mask) {
    std::vector<unsigned> slaves;
    for (const SlaveNumber slave : mask) slaves.push_back(slave.value());
    return slaves;
  };
  EXPECT_TRUE(seen({}).empty());
  EXPECT_EQ(seen({0x8000'0105}), (std::vector<unsigned>{0, 2, 8, 31}));
  EXPECT_EQ(seen(SlaveMask::all()).size(), std::size_t{kSlaves});
  SlaveMask left{0b1110};
  unsigned turns = 0;
  for (const SlaveNumber slave : left) {
    left.set(slave, false);
    left.set(*SlaveNumber::from(20));
    ++turns;
  }
  EXPECT_EQ(turns, 3u);
}

TEST(Lengths, ActionCommandTakesEightAlone) {
  for (unsigned dlc = 0; dlc <= 8; ++dlc) {
    can::Frame frame = frame_of(identifier::action, dlc);
    frame.data[4] = 1;
    const auto expected = dlc == 8 ? std::nullopt : std::optional(DecodeError::wrong_length);
    EXPECT_EQ(error_of(frame), expected) << dlc;
  }
}

TEST(Lengths, ProcessDataTakesWholeWords) {
  for (const std::uint32_t base : {0x100u, 0x180u, 0x300u, 0x380u}) {
    for (unsigned dlc = 0; dlc <= 8; ++dlc) {
      for (unsigned n = 0; n < 32; ++n) {
        const auto expected = dlc % 2 == 0 ? std::nullopt : std::optional(DecodeError::wrong_length);
        EXPECT_EQ(error_of(frame_of(base + n, dlc)), expected) << base + n << " dlc " << dlc;
      }
    }
  }
}

TEST(Lengths, OfCommandsForEveryFirstByte) {
  for (unsigned first = 0; first < 256; ++first) {
    for (unsigned dlc = 0; dlc <= 8; ++dlc) {
      const can::Frame frame = frame_of(identifier::command + 17, dlc, static_cast<std::uint8_t>(first));
      const auto expected = expected_error(command_lengths(first), dlc);
      EXPECT_EQ(error_of(frame), expected) << "first byte " << first << " dlc " << dlc;
    }
  }
}

TEST(Lengths, OfRepliesForEveryFirstByte) {
  for (unsigned first = 0; first < 256; ++first) {
    for (unsigned dlc = 0; dlc <= 8; ++dlc) {
      const can::Frame frame = frame_of(identifier::response + 31, dlc, static_cast<std::uint8_t>(first));
      const auto expected = expected_error(reply_lengths(first), dlc);
      EXPECT_EQ(error_of(frame), expected) << "first byte " << first << " dlc " << dlc;
    }
  }
}

TEST(Lengths, OverEightAreWrongOnEveryChannel) {
  for (const std::uint32_t id : {0x010u, 0x100u, 0x180u, 0x300u, 0x380u, 0x500u, 0x580u}) {
    for (unsigned dlc = 9; dlc < 256; ++dlc) {
      EXPECT_EQ(error_of(frame_of(id, dlc, 0x40)), DecodeError::wrong_length) << id << " dlc " << dlc;
    }
  }
}

TEST(Reserved, ActionCommandZero) {
  for (unsigned command = 0; command < 256; ++command) {
    can::Frame frame = frame_of(identifier::action, 8);
    frame.data[4] = static_cast<std::uint8_t>(command);
    const auto expected = command == 0 ? std::optional(DecodeError::reserved_bits) : std::nullopt;
    EXPECT_EQ(error_of(frame), expected) << command;
  }
}

// Frames that are no standard data frames, and as what they are rejected.
const std::vector<std::pair<can::Frame, DecodeError>> kOtherKinds = {
    {{.extended = true}, DecodeError::extended},
    {{.remote = true}, DecodeError::remote},
    {{.extended = true, .remote = true}, DecodeError::remote},
    {{.error = true}, DecodeError::error_frame}};

// Every identifier, with a frame that is right on each channel but for the slave number.
TEST(Identifiers, EachOneIsToldApart) {
  for (std::uint32_t id = 0; id <= 0x7FF; ++id) {
    const std::uint32_t channel = id & 0x780u;
    const std::uint32_t n = id & 0x7Fu;
    can::Frame frame = frame_of(id, 8, 0x00);
    frame.data[4] = 1;
    std::optional<DecodeError> expected;
    const bool reference = channel == 0x100 || channel == 0x180;
    const bool with_slave = channel == 0x300 || channel == 0x380 || channel == 0x500 || channel == 0x580;
    if (id != 0x010 && !reference && !with_slave) expected = DecodeError::not_for_us;
    if (with_slave && n > 31) expected = DecodeError::wrong_slave;
    EXPECT_EQ(error_of(frame), expected) << std::hex << id;
    for (const auto& [flags, by_flags] : kOtherKinds) {
      frame.extended = flags.extended;
      frame.remote = flags.remote;
      frame.error = flags.error;
      const auto refused = expected == DecodeError::not_for_us ? DecodeError::not_for_us : by_flags;
      EXPECT_EQ(error_of(frame), refused) << std::hex << id;
    }
  }
}

TEST(Identifiers, BeyondElevenBitsAreNotForUs) {
  std::mt19937 random(kSeed);
  for (int i = 0; i < 10'000; ++i) {
    can::Frame frame = frame_of((random() & 0x1FFFFFFFu) | 0x800u, 8, 0x10);
    EXPECT_EQ(error_of(frame), DecodeError::not_for_us);
    frame.extended = true;
    EXPECT_EQ(error_of(frame), DecodeError::not_for_us);
  }
}

// --- random telegrams

class RandomTelegrams {
 public:
  explicit RandomTelegrams(unsigned seed) : random_(seed) {}

  Telegram next() {
    switch (below(9)) {
      case 0:
        return ActionCommand{{bits()}, static_cast<std::uint8_t>(1 + below(255)), byte(), word()};
      case 1:
        return words(ReferenceTelegram{channel(), static_cast<std::uint8_t>(below(128)), 0, {}});
      case 2:
        return words(ActualTelegram{channel(), slave(), 0, {}});
      case 3:
        return parameter_command();
      case 4:
        return TransferInitialise{
            slave(), static_cast<TransferInitialise::Direction>(below(2)), twelve(), bits(), {word()}};
      case 5:
        return UploadBlock{slave(), twelve(), below(2) == 1};
      case 6: {
        DownloadBlock block{slave(), twelve(), below(2) == 1, {}};
        for (auto& entry : block.data) entry = byte();
        return block;
      }
      case 7:
        return parameter_reply();
      default:
        return transfer_reply();
    }
  }

  std::uint32_t bits() { return static_cast<std::uint32_t>(random_()); }
  std::uint32_t below(std::uint32_t end) { return bits() % end; }
  std::uint8_t byte() { return static_cast<std::uint8_t>(bits()); }

 private:
  std::uint16_t word() { return static_cast<std::uint16_t>(bits()); }
  Channel channel() { return static_cast<Channel>(below(2)); }
  SlaveNumber slave() { return *SlaveNumber::from(below(32)); }
  BlockOffset twelve() { return *BlockOffset::from(below(4096)); }

  template <class T>
  T words(T telegram) {
    telegram.words = static_cast<std::uint8_t>(below(5));
    for (unsigned i = 0; i < telegram.words; ++i) telegram.word[i] = word();
    return telegram;
  }

  ParameterCommand parameter_command() {
    ParameterCommand command;
    command.slave = slave();
    command.kind = static_cast<ParameterCommand::Kind>(below(3));
    command.number = *ParameterNumber::from(below(4096));
    command.element = *Element::from(below(8));
    if (command.kind == ParameterCommand::Kind::write_word) command.value = word();
    if (command.kind == ParameterCommand::Kind::write_doubleword) command.value = bits();
    command.sub_slave = {word()};
    return command;
  }

  template <class Reply>
  Reply payload(Reply reply, std::initializer_list<unsigned> good, std::initializer_list<unsigned> error) {
    reply.slave = slave();
    reply.busy = below(3) == 0;
    reply.error = below(3) == 0;
    const auto& sizes = reply.error ? error : good;
    reply.payload_size = static_cast<std::uint8_t>(
        reply.busy ? below(7) : sizes.begin()[below(static_cast<std::uint32_t>(sizes.size()))]);
    for (unsigned i = 0; i < reply.payload_size; ++i) reply.payload[i] = byte();
    return reply;
  }

  ParameterReply parameter_reply() {
    ParameterReply reply;
    reply.number = *ParameterNumber::from(below(4096));
    return payload(reply, {0, 2, 4, 6}, {2, 4});
  }

  TransferReply transfer_reply() {
    TransferReply reply;
    reply.offset = twelve();
    return payload(reply, {0, 6}, {2});
  }

  std::mt19937 random_;
};

TEST(RoundTrip, RandomTelegramsComeBack) {
  RandomTelegrams random(kSeed);
  std::array<unsigned, std::variant_size_v<Telegram>> seen = {};
  for (int i = 0; i < 300'000; ++i) {
    const Telegram telegram = random.next();
    ++seen[telegram.index()];
    const can::Frame frame = encode(telegram);
    ASSERT_LE(frame.dlc, 8);
    ASSERT_TRUE(frame.is_standard_data());
    for (unsigned byte = frame.dlc; byte < 8; ++byte) ASSERT_EQ(frame.data[byte], 0);
    const Decoded decoded = decode(frame);
    ASSERT_TRUE(std::holds_alternative<Telegram>(decoded)) << "telegram " << i << ", seed " << kSeed;
    ASSERT_TRUE(std::get<Telegram>(decoded) == telegram) << "telegram " << i << ", seed " << kSeed;
  }
  for (const unsigned count : seen) EXPECT_GT(count, 10'000u);
}

TEST(RoundTrip, WhatDecodesEncodesToTheSameFrame) {
  RandomTelegrams random(kSeed + 1);
  unsigned decoded_frames = 0;
  for (int i = 0; i < 1'000'000; ++i) {
    // Half of the identifiers on the channels, so that enough frames get past the first check.
    static constexpr std::array<std::uint32_t, 7> kBases = {0x010, 0x100, 0x180, 0x300, 0x380, 0x500, 0x580};
    const std::uint32_t base = kBases[random.below(7)];
    const std::uint32_t id =
        random.below(2) == 0 ? random.below(0x800) : base + (base == 0x010 ? 0 : random.below(32));
    can::Frame frame = frame_of(id, random.below(9));
    for (unsigned byte = 0; byte < frame.dlc; ++byte) frame.data[byte] = random.byte();
    const Decoded decoded = decode(frame);
    const auto* telegram = std::get_if<Telegram>(&decoded);
    if (telegram == nullptr) continue;
    ++decoded_frames;
    if (std::holds_alternative<ParameterReply>(*telegram) || std::holds_alternative<TransferReply>(*telegram))
      frame.data[0] &= 0xEF;  // the free bit is not looked at, and sent as 0
    ASSERT_TRUE(encode(*telegram) == frame) << "frame " << i << ", seed " << kSeed + 1;
  }
  EXPECT_GT(decoded_frames, 100'000u);
}

TEST(Decode, IgnoresBytesBeyondTheLength) {
  can::Frame frame = frame_of(0x583, 4, 0x01);
  frame.data[4] = 0x77;
  frame.data[7] = 0x99;
  const Decoded decoded = decode(frame);
  const auto& reply = std::get<ParameterReply>(std::get<Telegram>(decoded));
  EXPECT_EQ(reply.payload, (std::array<std::uint8_t, 6>{}));
}

TEST(Encode, StaysInsideTheFrameForFieldsOutOfRange) {
  ReferenceTelegram reference{Channel::one, 255, 9, {1, 2, 3, 4}};
  EXPECT_EQ(encode(reference).dlc, 8);
  EXPECT_EQ(encode(reference).id, 0x17Fu);  // still channel one
  ActualTelegram actual{Channel::two, {}, 200, {1, 2, 3, 4}};
  EXPECT_EQ(encode(actual).dlc, 8);
  ParameterReply reply;
  reply.payload_size = 200;
  EXPECT_EQ(encode(reply).dlc, 8);
}

}  // namespace
}  // namespace cansync
