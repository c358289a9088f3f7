#include "layer2/dds/validate.h"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <string_view>

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
  const std::string text = check(asked).value_or(gateway::dds::Denial{}).reason;
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
  EXPECT_EQ(check(request(0x7FF, false, 9))->cause, gateway_CAUSE_LENGTH);
  EXPECT_EQ(check(request(0x800, false, 0))->cause, gateway_CAUSE_FIELD);
  EXPECT_EQ(problem(request(0, false, 0, 3'600'001)),
            "timeout 3600001 ms: out of range; allowed 0..3600000 ms, 0 = the daemon's default");
}

TEST(Validate, EachFollowingFrameIsLookedAt) {
  layer2_SendRequest asked = request(0x7FF, false, 8);
  std::array<layer2_CanFrame, 2> following = {};
  asked.following._buffer = following.data();
  asked.following._length = asked.following._maximum = 2;
  EXPECT_EQ(problem(asked), "");
  following[1].length = 9;
  EXPECT_EQ(problem(asked), "following[1].length 9: out of range; allowed 0..8");
  following[0].identifier = 0x800;
  EXPECT_EQ(
      problem(asked),
      "following[0].identifier 0x800: out of range; allowed 0..0x7FF, or with extended up to 0x1FFFFFFF");
}

TEST(Validate, RefusalsOfTheStationHaveWords) {
  const auto expect = [](Refusal refusal, gateway_RefusalCause cause, std::string_view word) {
    const auto problem = explain(refusal, 64);
    ASSERT_TRUE(problem);
    EXPECT_EQ(problem->cause, cause);
    EXPECT_NE(problem->reason.find(word), std::string::npos) << problem->reason;
  };
  expect(Refusal::queue_full, gateway_CAUSE_QUEUE_FULL, "at most 64 frames may wait to be sent");
  expect(Refusal::too_late, gateway_CAUSE_STALE, "nothing was sent");
  expect(Refusal::not_led, gateway_CAUSE_WRONG_STATE, "module.run_follows");
  expect(Refusal::not_led, gateway_CAUSE_WRONG_STATE, "; start it, or let it say run");
  expect(Refusal::no_controller, gateway_CAUSE_BUS_UNAVAILABLE, "; set the interface up, or anew");
  expect(Refusal::reset_under_way, gateway_CAUSE_QUEUE_FULL, "; try again when that has ended");
  expect(Refusal::image_owned, gateway_CAUSE_WRONG_STATE, "ImageOutputs");
  expect(Refusal::bad_frame, gateway_CAUSE_FIELD, "0..8 bytes");
  expect(Refusal::stopped, gateway_CAUSE_STOPPING, "being stopped");
  EXPECT_FALSE(explain(Refusal::none, 64));
}

}  // namespace
}  // namespace layer2::dds
