#include "cansync/telegram/mapping.h"

#include <gtest/gtest.h>

#include <random>

namespace cansync {
namespace {

constexpr unsigned kSeed = 4711;

TEST(Register, ExampleLowWordOfValueThree) {
  EXPECT_EQ(from_register(0x0D), (WordMapping{true, false, 3}));
  EXPECT_EQ(to_register({true, false, 3}), 0x0D);
}

TEST(Register, KnownBytes) {
  EXPECT_EQ(from_register(0x00), WordMapping{});
  EXPECT_EQ(from_register(0x01), (WordMapping{true, false, 0}));
  EXPECT_EQ(from_register(0x03), (WordMapping{true, true, 0}));
  EXPECT_EQ(from_register(0x1F), (WordMapping{true, true, 7}));
  EXPECT_EQ(to_register({true, true, 7}), 0x1F);
  EXPECT_EQ(to_register({}), 0x00);
}

TEST(Register, EveryByteIsTakenOrRefused) {
  unsigned taken = 0;
  for (unsigned byte = 0; byte < 256; ++byte) {
    const auto word = from_register(static_cast<std::uint8_t>(byte));
    const bool assigned = (byte & 1u) != 0;
    const bool right = byte == 0 || (assigned && byte < 0x20);  // values over 7 and bit 7 begin at 0x20
    EXPECT_EQ(word.has_value(), right) << byte;
    if (!word) continue;
    ++taken;
    EXPECT_EQ(to_register(*word), byte);
  }
  EXPECT_EQ(taken, 17u);  // 8 values x 2 words, and unused
}

TEST(Register, UnusedWordHasNoStrayBits) {
  EXPECT_EQ(to_register({false, true, 5}), 0x00);
}

TEST(Arrays, ExampleOfTheManual) {
  const std::array<int, 4> numbers = {0, 0, 2, 3};
  const std::array<bool, 4> high = {false, true, false, false};
  const auto mapping = from_arrays(numbers, high);
  ASSERT_TRUE(mapping);
  EXPECT_EQ(to_register(mapping->word[0]), 0x01);
  EXPECT_EQ(to_register(mapping->word[1]), 0x03);
  EXPECT_EQ(to_register(mapping->word[2]), 0x09);
  EXPECT_EQ(to_register(mapping->word[3]), 0x0D);
  const Values values = {0x11223344, 0xDEADBEEF, 0xAAAA5566, 0xBBBB7788};
  EXPECT_EQ(pack(*mapping, values), (std::array<std::uint16_t, 4>{0x3344, 0x1122, 0x5566, 0x7788}));
}

TEST(Arrays, UnusedWords) {
  const std::array<int, 4> numbers = {-1, 7, -1, -1};
  const std::array<bool, 4> high = {false, true, false, false};
  const auto mapping = from_arrays(numbers, high);
  ASSERT_TRUE(mapping);
  EXPECT_EQ(mapping->word[0], WordMapping{});
  EXPECT_EQ(mapping->word[1], (WordMapping{true, true, 7}));
  EXPECT_EQ(mapping->used_words(), 2);
  EXPECT_EQ(mapping->value_mask(), 0x80);
}

TEST(Arrays, Refused) {
  const std::array<bool, 4> low = {};
  for (const int number : {-128, -2, 8, 31, 256}) {
    for (unsigned position = 0; position < 4; ++position) {
      std::array<int, 4> numbers = {0, 1, 2, 3};
      numbers[position] = number;
      EXPECT_FALSE(from_arrays(numbers, low)) << number << " at " << position;
    }
  }
  const std::array<int, 4> unused = {-1, -1, -1, -1};
  EXPECT_EQ(from_arrays(unused, std::array<bool, 4>{false, false, true, false}), from_arrays(unused, low))
      << "beside -1 the flag means nothing";
  EXPECT_TRUE(from_arrays(unused, low));
}

TEST(Fit, ValuesBelongToTheirTelegram) {
  for (unsigned value = 0; value < 8; ++value) {
    TelegramMapping mapping;
    mapping.word[2] = {true, true, static_cast<std::uint8_t>(value)};
    EXPECT_EQ(values_fit(mapping, Channel::one), value < 4) << value;
    EXPECT_EQ(values_fit(mapping, Channel::two), value >= 4) << value;
  }
  EXPECT_TRUE(values_fit({}, Channel::one));
  EXPECT_TRUE(values_fit({}, Channel::two));
}

TEST(Pack, UnassignedWordsAreZeroAndWhatIsNotCarriedOfAValueBecomesZero) {
  TelegramMapping mapping;
  mapping.word[1] = {true, true, 6};
  Values values = {0, 0, 0, 0, 0, 0x77777777, 0xCAFE1234, 0};
  EXPECT_EQ(pack(mapping, values), (std::array<std::uint16_t, 4>{0, 0xCAFE, 0, 0}));
  const std::array<std::uint16_t, 4> words = {1, 0xBEEF, 3, 4};
  unpack(mapping, words, values);
  EXPECT_EQ(values, (Values{0, 0, 0, 0, 0, 0x77777777, 0xBEEF0000, 0}));
}

TEST(WordMask, ALowWordAloneIsAWord) {
  EXPECT_EQ(word_mask({default_mapping(Channel::one), default_mapping(Channel::two)}), 0);
  ProcessMapping mapping;
  mapping[0].word[0] = {true, false, 0};  // low word alone
  mapping[0].word[1] = {true, true, 1};   // high word alone
  mapping[0].word[2] = {true, true, 2};   // both, not side by side
  mapping[1].word[0] = {true, false, 7};  // low word twice
  mapping[1].word[3] = {true, false, 7};
  mapping[0].word[3] = {true, false, 2};
  EXPECT_EQ(word_mask(mapping), 0b1000'0001);
}

TEST(NumberOf, HasTheWidthAndTheSignOfTheValue) {
  EXPECT_EQ(number_of(0xFF9C, true, true), -100);
  EXPECT_EQ(number_of(0xFF9C, true, false), 65436);
  EXPECT_EQ(number_of(0x1234FF9C, true, true), -100);
  EXPECT_EQ(number_of(0xFF9C, false, true), 65436);
  EXPECT_EQ(number_of(0xFFFFFF9C, false, true), -100);
  EXPECT_EQ(number_of(0xFFFFFF9C, false, false), 4294967196);
}

TEST(FitsWord, TakesSixteenBitsWithAndWithoutSign) {
  for (const std::uint32_t value : {0u, 0xFFFFu, 0xFFFF8000u, 0xFFFFFFFFu}) EXPECT_TRUE(fits_word(value));
  for (const std::uint32_t value : {0x10000u, 70'000u, 0xFFFF7FFFu, 0x80000000u}) {
    EXPECT_FALSE(fits_word(value)) << value;
  }
}

TEST(Pack, ShortTelegramLeavesTheRest) {
  const TelegramMapping mapping = default_mapping(Channel::one);
  Values values = {0x11111111, 0x22222222};
  const std::array<std::uint16_t, 3> words = {0xAAAA, 0xBBBB, 0xCCCC};
  unpack(mapping, words, values);
  EXPECT_EQ(values[0], 0xBBBBAAAAu);
  EXPECT_EQ(values[1], 0x2222CCCCu);
  unpack(mapping, std::span<const std::uint16_t>{}, values);
  EXPECT_EQ(values[0], 0xBBBBAAAAu);
}

TEST(Pack, MoreThanFourWordsAreNotRead) {
  Values values = {};
  const std::array<std::uint16_t, 6> words = {1, 2, 3, 4, 5, 6};
  unpack(default_mapping(Channel::one), words, values);
  EXPECT_EQ(values, (Values{0x00020001, 0x00040003}));
}

TEST(Pack, UnpackBringsBackWhatIsMappedWhole) {
  std::mt19937 random(kSeed);
  for (int i = 0; i < 10'000; ++i) {
    Values values;
    for (auto& value : values) value = static_cast<std::uint32_t>(random());
    Values copy = {};
    for (const Channel channel : {Channel::one, Channel::two}) {
      const TelegramMapping mapping = default_mapping(channel);
      unpack(mapping, pack(mapping, values), copy);
    }
    for (const unsigned value : {0u, 1u, 4u, 5u}) ASSERT_EQ(copy[value], values[value]) << "seed " << kSeed;
    for (const unsigned value : {2u, 3u, 6u, 7u}) ASSERT_EQ(copy[value], 0u);
  }
}

/// Word by word: each half that came is put in its place, and a half without a word is 0.
Values taken_word_by_word(const TelegramMapping& mapping, std::span<const std::uint16_t> words,
                          Values values) {
  Values carried = {};
  for (unsigned i = 0; i < kWords; ++i) {
    const WordMapping& entry = mapping.word[i];
    if (!entry.assigned) continue;
    const unsigned shift = entry.high ? 16 : 0;
    carried[entry.value] |= 0xFFFFu << shift;
    if (i >= words.size()) continue;
    values[entry.value] &= ~(0xFFFFu << shift);
    values[entry.value] |= std::uint32_t{words[i]} << shift;
  }
  for (unsigned i = 0; i < kValues; ++i) values[i] &= carried[i] == 0 || words.empty() ? ~0u : carried[i];
  return values;
}

TEST(Pack, AnyMappingIsTakenWordByWord) {
  std::mt19937 random(kSeed);
  for (int i = 0; i < 10'000; ++i) {
    TelegramMapping mapping;
    for (WordMapping& word : mapping.word) {
      const auto chance = static_cast<std::uint32_t>(random());
      // Four values, so that halves meet and the same half comes twice.
      if (chance % 4 != 0) word = {true, (chance & 8) != 0, static_cast<std::uint8_t>((chance >> 4) % 4)};
    }
    Values values;
    for (auto& value : values) value = static_cast<std::uint32_t>(random());
    std::array<std::uint16_t, kWords> all;
    for (auto& word : all) word = static_cast<std::uint16_t>(random());
    const auto words = std::span<const std::uint16_t>(all).first(random() % (kWords + 1));
    const Values expected = taken_word_by_word(mapping, words, values);
    unpack(mapping, words, values);
    ASSERT_EQ(values, expected) << "seed " << kSeed << ", round " << i << ", " << words.size() << " words";
  }
}

TEST(Default, LowWordFirst) {
  const TelegramMapping one = default_mapping(Channel::one);
  EXPECT_EQ(to_register(one.word[0]), 0x01);
  EXPECT_EQ(to_register(one.word[1]), 0x03);
  EXPECT_EQ(to_register(one.word[2]), 0x05);
  EXPECT_EQ(to_register(one.word[3]), 0x07);
  const TelegramMapping two = default_mapping(Channel::two);
  EXPECT_EQ(to_register(two.word[0]), 0x11);
  EXPECT_EQ(to_register(two.word[3]), 0x17);
  EXPECT_TRUE(values_fit(one, Channel::one));
  EXPECT_TRUE(values_fit(two, Channel::two));
  EXPECT_EQ(one.used_words(), 4);
  EXPECT_EQ(two.value_mask(), 0x30);
}

}  // namespace
}  // namespace cansync
