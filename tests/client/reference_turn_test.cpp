#include "client/src/reference_turn.h"

#include <gtest/gtest.h>

#include <vector>

namespace cansync::client {
namespace {

constexpr RepeatedTelegram kValues = {{1, 2, 3, 4}, 0b1111};

/// Telegrams that were written, and what the turn said; those in `failing` cannot be written.
struct Turn {
  explicit Turn(const std::array<RepeatedTelegram, 2>& telegrams, unsigned failing = 0)
      : failed(write_turn(telegrams, [&](std::uint8_t telegram, const RepeatedTelegram&) {
          written.push_back(telegram);
          return (failing >> telegram & 1u) != 0 ? "telegram " + std::to_string(telegram) : std::string();
        })) {}
  std::vector<std::uint8_t> written;
  std::string failed;
};

TEST(ReferenceTurn, ATelegramThatFailsLeavesTheOtherItsTurn) {
  const Turn turn({kValues, kValues}, 0b010);
  EXPECT_EQ(turn.written, (std::vector<std::uint8_t>{1, 2}));
  EXPECT_EQ(turn.failed, "telegram 1");
}

TEST(ReferenceTurn, WhatFailedFirstIsTold) {
  EXPECT_EQ(Turn({kValues, kValues}, 0b110).failed, "telegram 1");
  EXPECT_EQ(Turn({kValues, kValues}, 0b100).failed, "telegram 2");
  EXPECT_EQ(Turn({kValues, kValues}).failed, "");
}

TEST(ReferenceTurn, ATelegramWithoutValuesIsNotWritten) {
  EXPECT_EQ(Turn({RepeatedTelegram{}, kValues}).written, (std::vector<std::uint8_t>{2}));
  EXPECT_EQ(Turn({kValues, RepeatedTelegram{}}).written, (std::vector<std::uint8_t>{1}));
  EXPECT_TRUE(Turn({RepeatedTelegram{}, RepeatedTelegram{}}).written.empty());
}

}  // namespace
}  // namespace cansync::client
