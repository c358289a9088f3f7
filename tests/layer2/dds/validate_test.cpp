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

/// A request that is refused, and the same as the text of the refusal allows it.
template <class T>
void expect_remedy(const T& good, void (*spoil)(T&), std::string_view text, void (*allow)(T&)) {
  T asked = good;
  spoil(asked);
  const auto refused = check(asked);
  ASSERT_TRUE(refused) << text;
  EXPECT_NE(refused->reason.find(text), std::string::npos) << refused->reason;
  allow(asked);
  EXPECT_FALSE(check(asked)) << text;
}

TEST(Validate, WhatATextAllowsIsTaken) {
  using S = layer2_SendRequest;
  const S send = request(0x100, false, 8);
  expect_remedy<S>(
      send, [](S& r) { r.content.identifier = 0x800; }, "with extended up to 0x1FFFFFFF",
      [](S& r) { r.content.extended = true; });
  expect_remedy<S>(
      send, [](S& r) { r.content.length = 9; }, "allowed 0..8", [](S& r) { r.content.length = 8; });
  expect_remedy<S>(
      send, [](S& r) { r.timeout = 3'600'001; }, "allowed 0..3600000 ms",
      [](S& r) { r.timeout = 3'600'000; });

  using C = layer2_ControlRequest;
  C timer = {};
  timer.kind = layer2_CONTROL_SET_TIMER;
  timer.number = 1;
  timer.period = 1000;
  expect_remedy<C>(
      timer, [](C& r) { r.number = 17; }, "allowed 1..16", [](C& r) { r.number = 16; });
  expect_remedy<C>(
      timer, [](C& r) { r.period = 99; }, "allowed 100..3600000000 us", [](C& r) { r.period = 100; });
  expect_remedy<C>(
      timer, [](C& r) { r.phase = 3'600'000'001; }, "allowed 0..3600000000 us",
      [](C& r) { r.phase = 3'600'000'000; });
  C image = {};
  image.kind = layer2_CONTROL_WRITE_IMAGE;
  image.size = 1;
  expect_remedy<C>(
      image, [](C& r) { r.size = 0; }, "allowed 1..", [](C& r) { r.size = 1; });
  expect_remedy<C>(
      image, [](C& r) { r.address = DataMapping::kBytes; }, "allowed 0..",
      [](C& r) { r.address = DataMapping::kBytes - 1; });

  using O = layer2_ObjectRequest;
  O object = {};
  object.action = layer2_OBJECT_SEND;
  expect_remedy<O>(
      object, [](O& r) { r.number = 32; }, "allowed 0..31", [](O& r) { r.number = 31; });
  expect_remedy<O>(
      object, [](O& r) { r.every_time = true; }, "only with on_remote", [](O& r) { r.on_remote = true; });
  expect_remedy<O>(
      object, [](O& r) { r.content.remote = true; }, "read an object that receives with ask",
      [](O& r) {
        r.action = layer2_OBJECT_READ;
        r.release = r.ask = true;
      });
  O reading = {};
  reading.action = layer2_OBJECT_READ;
  expect_remedy<O>(
      reading, [](O& r) { r.ask = true; }, "only with release", [](O& r) { r.release = true; });
  static layer2_ObjectSettings settings = {};
  O configuring = {};
  configuring.action = layer2_OBJECT_CONFIGURE;
  configuring.settings._buffer = &settings;
  configuring.settings._length = configuring.settings._maximum = 1;
  expect_remedy<O>(
      configuring, [](O&) { settings.number = 32; }, "allowed 0..31", [](O&) { settings.number = 31; });
  expect_remedy<O>(
      configuring, [](O&) { settings.timeout = 3'600'001; }, "allowed 0..3600000 ms",
      [](O&) { settings.timeout = 3'600'000; });
  expect_remedy<O>(
      configuring, [](O&) { settings.identifier = 0x800; }, "with extended up to",
      [](O&) { settings.extended = true; });
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
