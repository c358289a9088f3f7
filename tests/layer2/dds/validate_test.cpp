#include "layer2/dds/validate.h"

#include <gtest/gtest.h>

#include <string>

namespace layer2::dds {
namespace {

layer2_SendRequest request(std::uint32_t identifier, bool extended, std::uint8_t length,
                           std::uint32_t timeout = 0) {
  layer2_SendRequest out = {};
  out.content.identifier = identifier;
  out.content.extended = extended;
  out.content.length = length;
  out.timeout = timeout;
  return out;
}

std::string problem(const layer2_SendRequest& asked) {
  const std::string text = check(asked).value_or("");
  EXPECT_LE(text.size(), std::size_t{gateway_TEXT});
  return text;
}

TEST(Validate, WhatTheBusCanCarryPasses) {
  EXPECT_EQ(problem(request(0, false, 0)), "");
  EXPECT_EQ(problem(request(0x7FF, false, 8)), "");
  EXPECT_EQ(problem(request(0x1FFFFFFF, true, 8, 3'600'000)), "");
}

TEST(Validate, TextsNameFieldValueAndWhatIsAllowed) {
  EXPECT_EQ(problem(request(0x800, false, 0)),
            "content.identifier 0x800: out of range; allowed 0..0x7FF, or with extended up to 0x1FFFFFFF");
  EXPECT_EQ(problem(request(0x20000000, true, 0)),
            "content.identifier 0x20000000: out of range; allowed 0..0x1FFFFFFF");
  EXPECT_EQ(problem(request(0x7FF, false, 9)), "content.length 9: out of range; allowed 0..8");
  EXPECT_EQ(problem(request(0, false, 0, 3'600'001)),
            "timeout 3600001 ms: out of range; allowed 0..3600000 ms, 0 = the daemon's default");
}

TEST(Validate, RefusalsOfTheStationHaveWords) {
  EXPECT_EQ(explain(Refusal::queue_full, 64),
            "queue full: at most 64 frames may wait to be sent; try again when one has been");
  EXPECT_FALSE(explain(Refusal::bad_frame, 64).empty());
  EXPECT_FALSE(explain(Refusal::stopped, 64).empty());
}

}  // namespace
}  // namespace layer2::dds
