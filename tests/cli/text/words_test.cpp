#include "cli/text/words.h"

#include <gtest/gtest.h>

namespace cansync::cli {
namespace {

using Texts = std::vector<std::string>;

Texts texts(std::string_view line) {
  Texts out;
  for (const Word& word : split_words(line)) out.push_back(word.text);
  return out;
}

std::size_t wrong_column(std::string_view line) {
  try {
    static_cast<void>(split_words(line));
  } catch (const WordError& error) {
    return error.column();
  }
  return 0;
}

TEST(Words, StandBetweenBlanks) {
  EXPECT_EQ(texts("read winder 100"), (Texts{"read", "winder", "100"}));
  EXPECT_EQ(texts(" \tread\t 1  \r"), (Texts{"read", "1"}));
  EXPECT_EQ(texts(""), Texts{});
  EXPECT_EQ(texts("  \t"), Texts{});
}

TEST(Words, ACommentBeginsWhereAWordWould) {
  EXPECT_EQ(texts("# all"), Texts{});
  EXPECT_EQ(texts("read 1 # why"), (Texts{"read", "1"}));
  EXPECT_EQ(texts("a#b '#'"), (Texts{"a#b", "#"}));
}

TEST(Words, QuotationsKeepBlanks) {
  EXPECT_EQ(texts(R"('a b' "c d")"), (Texts{"a b", "c d"}));
  EXPECT_EQ(texts(R"(a'b 'c"d e")"), (Texts{"ab cd e"}));
  EXPECT_EQ(texts(R"('' "")"), (Texts{"", ""}));
  EXPECT_EQ(texts(R"('\n' "\"\\\n")"), (Texts{R"(\n)", R"("\\n)"}));
  EXPECT_EQ(texts(R"("it's" 'say "x"')"), (Texts{"it's", R"(say "x")"}));
}

TEST(Words, ABackslashTakesTheNextCharacterAsItIs) {
  EXPECT_EQ(texts(R"(a\ b \# \\ \')"), (Texts{"a b", "#", "\\", "'"}));
}

TEST(Words, KnowTheirColumns) {
  const auto words = split_words("  read 'a b'  x");
  ASSERT_EQ(words.size(), 3u);
  EXPECT_EQ(words[0].column, 3u);
  EXPECT_EQ(words[1].column, 8u);
  EXPECT_EQ(words[2].column, 15u);
}

TEST(Words, WhatDoesNotEndIsWrong) {
  EXPECT_EQ(wrong_column("read 'a"), 6u);
  EXPECT_EQ(wrong_column("\"a\\\""), 1u);
  EXPECT_EQ(wrong_column("read \\"), 6u);
  EXPECT_EQ(wrong_column("read 'a' \"b\""), 0u);
}

TEST(EditDistance, CountsLettersAndSwaps) {
  EXPECT_EQ(edit_distance("status", "status"), 0u);
  EXPECT_EQ(edit_distance("sttus", "status"), 1u);
  EXPECT_EQ(edit_distance("satus", "status"), 1u);
  EXPECT_EQ(edit_distance("tsatus", "status"), 1u) << "swapped";
  EXPECT_EQ(edit_distance("", "read"), 4u);
}

TEST(DidYouMean, OnlyWordsThatAreNear) {
  const std::vector<std::string> words = {"read", "write", "wait", "set"};
  EXPECT_EQ(did_you_mean("raed", words), "; did you mean 'read'?");
  EXPECT_EQ(did_you_mean("wirte", words), "; did you mean 'write'?");
  EXPECT_EQ(did_you_mean("sat", words), "; did you mean 'set'?");
  EXPECT_EQ(did_you_mean("xyz", words), "");
  EXPECT_EQ(did_you_mean("frobnicate", words), "");
}

}  // namespace
}  // namespace cansync::cli
