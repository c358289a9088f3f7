#include <gtest/gtest.h>

#include <string>

#include "cli/layer2/dump_filter.h"
#include "cli/layer2/send_frames.h"
#include "cli/text/values.h"

namespace {

using namespace cansync::cli;

can::Frame frame(std::uint32_t id, bool extended = false, bool remote = false) {
  can::Frame made;
  made.id = id;
  made.extended = extended;
  made.remote = remote;
  return made;
}

TEST(DumpFilter, TakesEverythingUntilSomethingIsNamed) {
  const DumpFilter filter;
  EXPECT_TRUE(filter.takes(frame(0)));
  EXPECT_TRUE(filter.takes(frame(0x1FFFFFFF, true, true)));
}

TEST(DumpFilter, IdentifiersAreRangesAndMasksOfOneWidth) {
  DumpFilter filter;
  filter.add_identifiers("123,200-2FF,480:7F0");
  filter.add_identifiers("18DAF100:1FFFFF00");
  for (const std::uint32_t taken : {0x123u, 0x200u, 0x2FFu, 0x480u, 0x48Fu})
    EXPECT_TRUE(filter.takes(frame(taken))) << taken;
  for (const std::uint32_t other : {0x122u, 0x124u, 0x1FFu, 0x300u, 0x47Fu, 0x490u})
    EXPECT_FALSE(filter.takes(frame(other))) << other;
  EXPECT_FALSE(filter.takes(frame(0x123, true)));
  EXPECT_TRUE(filter.takes(frame(0x18DAF1FE, true)));
  EXPECT_FALSE(filter.takes(frame(0x18DAF200, true)));
}

TEST(DumpFilter, KindsAreApart) {
  DumpFilter data;
  data.set_kind("data");
  EXPECT_TRUE(data.takes(frame(1)));
  EXPECT_FALSE(data.takes(frame(1, false, true)));
  DumpFilter remote;
  remote.set_kind("remote");
  EXPECT_FALSE(remote.takes(frame(1)));
  EXPECT_TRUE(remote.takes(frame(1, true, true)));
}

TEST(DumpFilter, WhatIsWrongIsTold) {
  for (const char* wrong : {"", "1", "12345", "800", "20000000", "xyz", "123-", "-123", "200-100",
                            "123-00000200", "123:0", "123,", "123:00000FFF", "123-456-789"}) {
    DumpFilter filter;
    EXPECT_THROW(filter.add_identifiers(wrong), UsageError) << wrong;
  }
  DumpFilter filter;
  EXPECT_THROW(filter.set_kind("error"), UsageError);
}

TEST(SentFrame, IsWrittenAsCanUtilsDo) {
  can::Frame wanted = frame(0x123);
  wanted.dlc = 3;
  wanted.data = {1, 2, 0xFF};
  EXPECT_EQ(parse_sent_frame("123#0102FF"), wanted);
  EXPECT_EQ(parse_sent_frame("123#01.02.fF"), wanted);
  EXPECT_EQ(parse_sent_frame("0x123#0102FF"), wanted);
  EXPECT_EQ(parse_sent_frame("00000123#"), frame(0x123, true));
  wanted = frame(0x7FF, false, true);
  EXPECT_EQ(parse_sent_frame("7FF#R"), wanted);
  wanted.dlc = 8;
  EXPECT_EQ(parse_sent_frame("7FF#R8"), wanted);
}

TEST(SentFrame, WhatIsWrongIsTold) {
  for (const char* wrong : {"",        "#",         "123",       "12#",        "1234#",
                            "800#",    "20000000#", "20000001#", "0x12#",      "123#0",
                            "123#0.1", "123#01.",   "123#.01",   "123#01..02", "123#010203040506070809",
                            "123#R9",  "123#zz",    "123##1",    "123#01#02",  "12.3#01"})
    EXPECT_THROW(parse_sent_frame(wrong), UsageError) << wrong;
}

}  // namespace
