#include <gtest/gtest.h>

#include <string_view>

#include "text/foreign_file.h"
#include "text/json.h"
#include "text/visible.h"

namespace text {
namespace {

using namespace std::string_view_literals;

TEST(ForeignFile, FormatsAreRecognizedByTheirBeginning) {
  const std::pair<std::string_view, std::string_view> files[] = {
      {"version https://git-lfs.github.com/spec/v1\n", "Git LFS"},
      {"\xFF\xFE"
       "B\0O\0"sv,
       "UTF-16"},
      {"LOGG\x90\0"sv, "BLF"},
      {";$FILEVERSION=2.0\n", "TRC"},
      {"date Mon Nov 2 10:00:00.000 2026\n", "ASC"},
      {"base hex  timestamps absolute\n", "ASC"},
      {"Time Stamp,ID,Extended,Dir,Bus,LEN,D1\n", "SavvyCAN CSV"},
      {"\xD4\xC3\xB2\xA1\x02\0\x04\0"sv, "libpcap"},
      {"\xEF\xBB\xBF<?xml version=\"1.0\"?>\n<NetworkDefinition>", "KCD"},
      {"  {\n \"messages\": []}", "JSON"},
      {"a\0b"sv, "no text"},
  };
  for (const auto& [content, name] : files)
    EXPECT_NE(recognized_text(content).find(name), std::string::npos)
        << name << ": " << recognized_text(content);
}

TEST(ForeignFile, OwnFormatsAreNot) {
  for (const std::string_view content :
       {"VERSION \"\"\n\nNS_ :\n"sv, "(1700000000.000000) can0 123#00\n"sv, "  can0  123   [1]  00\n"sv,
        "[[message]]\nname = \"A\"\n"sv, ""sv, "# comment\n"sv})
    EXPECT_EQ(recognized_text(content), "") << content;
}

TEST(Visible, InJsonTheyAreEscapesOfTheSameValue) {
  EXPECT_EQ(json_string("a\x1b[2J\x7f\xc2\x9bz\xc2\xb0"), "\"a\\u001b[2J\\u007f\\u009bz\xc2\xb0\"");
}

TEST(Visible, ControlCharactersAreWritten) {
  EXPECT_EQ(visible("a\x1b[31mb\x07\n\x7f"), "a\\x1b[31mb\\x07\\x0a\\x7f");
  EXPECT_EQ(visible("a\nb", "\n"), "a\nb");
  EXPECT_EQ(visible("\xC2\x9B"
                    "31m"),
            "\\x9b31m")
      << "a C1 sequence introducer in UTF-8";
  EXPECT_EQ(visible("\xC2\xB0"
                    "C \xE2\x82\xAC"),
            "\xC2\xB0"
            "C \xE2\x82\xAC");
}

TEST(Visible, WhatAPeerSaysIsBoundedAsciiWithoutACutEscape) {
  EXPECT_EQ(visible_ascii("a\x1b[2J\xC3\xBC~"sv, 40), "a\\x1b[2J\\xc3\\xbc~");
  EXPECT_EQ(visible_ascii("abcd", 4), "abcd");
  EXPECT_EQ(visible_ascii("abcde", 4), "abcd");
  EXPECT_EQ(visible_ascii("abc\x07"sv, 4), "abc");
}

}  // namespace
}  // namespace text
