#include "config/toml_guard.h"

#include <gtest/gtest.h>

#include <string>

namespace {

using config::too_deep_key;

std::string key(std::size_t parts) {
  std::string out = "a";
  for (std::size_t i = 1; i < parts; ++i) out += ".a";
  return out;
}

TEST(TooDeepKey, SixteenPartsAreAllowed) {
  EXPECT_FALSE(too_deep_key(""));
  EXPECT_FALSE(too_deep_key(key(16) + " = 1\n"));
  EXPECT_TRUE(too_deep_key(key(17) + " = 1\n"));
  EXPECT_FALSE(too_deep_key("[" + key(16) + "]\n"));
  EXPECT_TRUE(too_deep_key("[" + key(17) + "]\n"));
  EXPECT_TRUE(too_deep_key("[[" + key(17) + "]]\n"));
}

TEST(TooDeepKey, HasItsPlace) {
  const auto place = too_deep_key("# x\n[bus]\nname = \"\"\"\n\n\"\"\"\nb = {" + key(17) + " = 1}\n");
  ASSERT_TRUE(place);
  EXPECT_EQ(place->line, 6u);
  EXPECT_EQ(place->column, 7u);
}

TEST(TooDeepKey, BlanksAndQuotesBelongToAKey) {
  std::string out = "a";
  for (int i = 1; i < 17; ++i) out += i % 2 == 0 ? " . \"b.c\\\"\"" : "\t.\t'd.e'";
  EXPECT_TRUE(too_deep_key(out + " = 1\n"));
  EXPECT_TRUE(too_deep_key(out));
}

TEST(TooDeepKey, ManyDotsElsewhereAreNoKey) {
  std::string numbers = "a = [";
  for (int i = 0; i < 100; ++i) numbers += "1.5, ";
  EXPECT_FALSE(too_deep_key(numbers + "]\n"));
  const std::string dots(100, '.');
  EXPECT_FALSE(too_deep_key("a = \"" + dots + "\"\n"));
  EXPECT_FALSE(too_deep_key("a = '" + dots + "'\n"));
  EXPECT_FALSE(too_deep_key("a = \"\"\"" + dots + "\n\"" + dots + "\"\"\"\"\"\n"));
  EXPECT_FALSE(too_deep_key("a = '''" + dots + "\n'" + dots + "'''\n"));
  EXPECT_FALSE(too_deep_key("a = \"\\\"" + dots + "\"\n"));
  EXPECT_FALSE(too_deep_key("# " + dots + "\n"));
  EXPECT_FALSE(too_deep_key(key(9) + " = 1\n" + key(9) + " = 1\n"));
}

TEST(TooDeepKey, IsFoundBehindAStringThatHasEnded) {
  for (const char* before : {"a = \"x\"\n", "a = 'x'\n", "a = \"\"\"x\"\"\"\"\n", "a = '''x'''\n",
                             "a = \"\"\n", "a = \"\\\\\"\n", "a = '\\'\n", "a = \"\"\"\\\"\"\"\"\n"}) {
    EXPECT_TRUE(too_deep_key(before + key(17) + " = 1\n")) << before;
  }
}

TEST(TooDeepKey, AnyTextComesToAnEnd) {
  for (const char* text : {"\"", "'", "\"\"\"", "'''", "\"\\", "a.", "\"\"\"\\", "\0"})
    EXPECT_FALSE(too_deep_key(text));
}

}  // namespace
