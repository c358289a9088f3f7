#include "sync/gpio.h"

#include <gtest/gtest.h>

#include "sync/fake_system.h"

namespace {

using namespace sync_line;
using namespace sync_line::test;
using std::chrono::microseconds;

GpioLine line(Edge edge = Edge::falling, std::uint32_t number = 3) {
  return {FakeSystem::kChip, number, edge};
}

std::string refused_output(FakeSystem& system, const GpioLine& wanted) {
  return refusal([&] { GpioOutput(system, wanted, "sync.gpio_chip", "sync.gpio_line"); });
}

TEST(GpioOutput, AFallingEdgeIsAnActiveLowLineThatStartsInactive) {
  FakeSystem system;
  GpioOutput output(system, line(), "sync.gpio_chip", "sync.gpio_line");
  EXPECT_EQ(system.requested.num_lines, 1U);
  EXPECT_EQ(system.requested.offsets[0], 3U);
  EXPECT_EQ(system.requested.config.flags,
            static_cast<std::uint64_t>(GPIO_V2_LINE_FLAG_OUTPUT | GPIO_V2_LINE_FLAG_ACTIVE_LOW));
  ASSERT_EQ(system.requested.config.num_attrs, 1U);
  EXPECT_EQ(system.requested.config.attrs[0].mask, 1U);
  EXPECT_EQ(system.requested.config.attrs[0].attr.id,
            static_cast<std::uint32_t>(GPIO_V2_LINE_ATTR_ID_OUTPUT_VALUES));
  EXPECT_EQ(system.requested.config.attrs[0].attr.values, 0U);
  EXPECT_STREQ(system.requested.consumer, "cansyncd SYNC");
}

TEST(GpioOutput, ARisingEdgeIsAnActiveHighLine) {
  FakeSystem system;
  GpioOutput output(system, line(Edge::rising), "sync.gpio_chip", "sync.gpio_line");
  EXPECT_EQ(system.requested.config.flags, static_cast<std::uint64_t>(GPIO_V2_LINE_FLAG_OUTPUT));
}

TEST(GpioOutput, OnePulseIsTwoSystemCalls) {
  FakeSystem system;
  GpioOutput output(system, line(), "sync.gpio_chip", "sync.gpio_line");
  EXPECT_TRUE(output.idle()) << "idle already: nothing to do";
  EXPECT_TRUE(output.pulse());
  system.now += microseconds(300);
  EXPECT_TRUE(output.idle());
  EXPECT_TRUE(output.idle());
  ASSERT_EQ(system.levels.size(), 2U);
  EXPECT_TRUE(system.levels[0].second);
  EXPECT_FALSE(system.levels[1].second);
  EXPECT_EQ(system.levels[1].first - system.levels[0].first, Time(microseconds(300)));
}

TEST(GpioOutput, AFailureIsToldAndEnds) {
  FakeSystem system;
  GpioOutput output(system, line(), "sync.gpio_chip", "sync.gpio_line");
  system.control_error[GPIO_V2_LINE_SET_VALUES_IOCTL] = ENODEV;
  EXPECT_FALSE(output.pulse());
  EXPECT_EQ(output.error(), ENODEV);
  system.control_error.clear();
  EXPECT_TRUE(output.pulse());
  EXPECT_EQ(output.error(), 0);
}

TEST(GpioOutput, RefusalsNameOptionDeviceAndRemedy) {
  FakeSystem system;
  GpioLine elsewhere = line();
  elsewhere.chip = "/dev/gpiochip7";
  EXPECT_EQ(refused_output(system, elsewhere),
            "sync.gpio_chip: /dev/gpiochip7: No such file or directory; plug the hardware in or load its "
            "driver, or name another device");
  system.open_error[FakeSystem::kChip] = EACCES;
  const std::string rights = refused_output(system, line());
  EXPECT_NE(rights.find("sync.gpio_chip: /dev/gpiochip0: Permission denied; give the daemon's user"),
            std::string::npos)
      << rights;
  system.open_error.clear();
  system.busy_lines = {3};
  const std::string busy = refused_output(system, line());
  EXPECT_NE(busy.find("sync.gpio_line: /dev/gpiochip0 line 3: Device or resource busy; another program"),
            std::string::npos)
      << busy;
  EXPECT_EQ(refused_output(system, line(Edge::falling, 8)),
            "sync.gpio_line: found 8; /dev/gpiochip0 has lines 0..7");
  system.control_error[GPIO_GET_CHIPINFO_IOCTL] = ENOTTY;
  EXPECT_NE(refused_output(system, line()).find("no device of that kind"), std::string::npos);
  EXPECT_EQ(system.open_files, 0U) << "a refusal leaves nothing open";
}

TEST(GpioInput, HandsOverTheKernelsTimeStampsInOrder) {
  FakeSystem system;
  GpioInput input(system, line(Edge::rising), "sync.input_chip", "sync.input_line");
  EXPECT_TRUE(system.nonblocking);
  EXPECT_EQ(system.requested.config.flags,
            static_cast<std::uint64_t>(GPIO_V2_LINE_FLAG_INPUT | GPIO_V2_LINE_FLAG_EDGE_RISING))
      << "no clock flag: the time stamps are on CLOCK_MONOTONIC";
  Time at{0};
  EXPECT_FALSE(input.take(Time{0}, at));
  for (int i = 1; i <= 20; ++i) system.edge_at(microseconds(i));
  for (int i = 1; i <= 20; ++i) {
    ASSERT_TRUE(input.take(Time{0}, at)) << i;
    EXPECT_EQ(at, Time(microseconds(i)));
  }
  EXPECT_FALSE(input.take(Time{0}, at));
  EXPECT_EQ(input.error(), 0);
}

TEST(GpioInput, OneEdgeCostsOneRead) {
  FakeSystem system;
  GpioInput input(system, line(), "sync.input_chip", "sync.input_line");
  Time at{0};
  system.edge_at(microseconds(1));
  EXPECT_TRUE(input.take(Time{0}, at));
  EXPECT_FALSE(input.take(Time{0}, at));
  EXPECT_EQ(system.reads, 1U);
}

TEST(GpioInput, AFailingReadIsTold) {
  FakeSystem system;
  GpioInput input(system, line(), "sync.input_chip", "sync.input_line");
  Time at{0};
  system.read_error = ENODEV;
  EXPECT_FALSE(input.take(Time{0}, at));
  EXPECT_EQ(input.error(), ENODEV);
  system.read_error = 0;
  EXPECT_FALSE(input.take(Time{0}, at));
  EXPECT_EQ(input.error(), 0);
}

}  // namespace
