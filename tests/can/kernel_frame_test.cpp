#include "can/socketcan/kernel_frame.h"

#include <gtest/gtest.h>
#include <linux/can/error.h>

#include <optional>
#include <vector>

#include "flagged_frames.h"

namespace {

using can::FlagFilter;
using can::Frame;
using can::FrameFilter;
using can::test::data_frame;
using can::test::error;
using can::test::extended;
using can::test::remote;

TEST(KernelFrame, EachKindHasItsFlags) {
  EXPECT_EQ(to_kernel(data_frame(0x123, {1})).can_id, 0x123u);
  EXPECT_EQ(to_kernel(remote(data_frame(0x123, {}))).can_id, 0x123u | CAN_RTR_FLAG);
  EXPECT_EQ(to_kernel(extended(data_frame(0x123, {1}))).can_id, 0x123u | CAN_EFF_FLAG);
  EXPECT_EQ(to_kernel(extended(remote(data_frame(0x18DAF110, {})))).can_id,
            0x18DAF110u | CAN_EFF_FLAG | CAN_RTR_FLAG);
  EXPECT_EQ(to_kernel(error(data_frame(CAN_ERR_BUSOFF, {}))).can_id, CAN_ERR_BUSOFF | CAN_ERR_FLAG);
}

TEST(KernelFrame, EachKindComesBackAsItWas) {
  for (const Frame& frame : can::test::four_kinds()) {
    EXPECT_EQ(can::from_kernel(to_kernel(frame)), frame) << std::hex << to_kernel(frame).can_id;
  }
  const Frame failure = error(data_frame(CAN_ERR_PROT | CAN_ERR_CNT, {0, 1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(can::from_kernel(to_kernel(failure)), failure);
}

TEST(KernelFrame, AnErrorFrameHasNoOtherFlag) {
  can_frame raw{};
  raw.can_id = CAN_ERR_FLAG | CAN_EFF_FLAG | CAN_RTR_FLAG | CAN_ERR_CRTL;
  EXPECT_EQ(can::from_kernel(raw), error(data_frame(CAN_ERR_CRTL, {})));
}

TEST(KernelFrame, BytesBeyondTheLengthAndOfARemoteFrameAreZero) {
  can_frame raw{};
  raw.can_id = 0x123;
  raw.len = 2;
  for (auto& byte : raw.data) byte = 0xFF;
  EXPECT_EQ(can::from_kernel(raw), data_frame(0x123, {0xFF, 0xFF}));
  raw.can_id |= CAN_RTR_FLAG;
  EXPECT_EQ(can::from_kernel(raw), remote(data_frame(0x123, {0, 0})));
  raw.len = 15;
  EXPECT_EQ(can::from_kernel(raw).dlc, 8);
}

TEST(KernelFrame, OfATooLargeIdentifierTheLowerBitsCount) {
  EXPECT_EQ(to_kernel(data_frame(0x18DAF110, {})).can_id, 0x110u);
  EXPECT_EQ(to_kernel(extended(data_frame(0xFFFFFFFF, {}))).can_id, 0x1FFFFFFFu | CAN_EFF_FLAG);
}

/// As net/can/raw.c and af_can.c compare.
bool takes(const FrameFilter& filter, const Frame& frame) {
  const can_filter raw = to_kernel(filter);
  return (to_kernel(frame).can_id & raw.can_mask) == (raw.can_id & raw.can_mask);
}

/// Of the frames with the number 0x123, in the order standard data and remote, extended data and remote.
std::vector<bool> taken(FlagFilter extended_ones, FlagFilter remote_ones) {
  const FrameFilter filter{.identifier = 0x123, .extended = extended_ones, .remote = remote_ones};
  std::vector<bool> out;
  const std::vector<Frame> all = can::test::four_kinds();
  for (std::size_t i = 0; i < 4; ++i) out.push_back(takes(filter, all[i]));
  return out;
}

TEST(KernelFilter, TakesTheKindsItNames) {
  EXPECT_EQ(taken(FlagFilter::clear, FlagFilter::clear), (std::vector{true, false, false, false}));
  EXPECT_EQ(taken(FlagFilter::clear, FlagFilter::set), (std::vector{false, true, false, false}));
  EXPECT_EQ(taken(FlagFilter::set, FlagFilter::clear), (std::vector{false, false, true, false}));
  EXPECT_EQ(taken(FlagFilter::set, FlagFilter::set), (std::vector{false, false, false, true}));
  EXPECT_EQ(taken(FlagFilter::either, FlagFilter::clear), (std::vector{true, false, true, false}));
  EXPECT_EQ(taken(FlagFilter::clear, FlagFilter::either), (std::vector{true, true, false, false}));
  EXPECT_EQ(taken(FlagFilter::either, FlagFilter::either), (std::vector{true, true, true, true}));
}

TEST(KernelFilter, ComparesTheBitsOfItsMask) {
  const FrameFilter one{.identifier = 0x18DAF110, .extended = FlagFilter::set};
  EXPECT_TRUE(takes(one, extended(data_frame(0x18DAF110, {}))));
  EXPECT_FALSE(takes(one, extended(data_frame(0x18DAF111, {}))));
  const FrameFilter to_one{.identifier = 0x18DA0010, .mask = 0x1FFF00FF, .extended = FlagFilter::set};
  EXPECT_TRUE(takes(to_one, extended(data_frame(0x18DAF110, {}))));
  EXPECT_FALSE(takes(to_one, extended(data_frame(0x18DBF110, {}))));
  const FrameFilter range{.identifier = 0x180, .mask = 0x780};
  EXPECT_TRUE(takes(range, data_frame(0x1FF, {})));
  EXPECT_FALSE(takes(range, data_frame(0x200, {})));
  const FrameFilter any{.mask = 0, .extended = FlagFilter::either};
  EXPECT_TRUE(takes(any, extended(data_frame(0x1FFFFFFF, {}))));
  EXPECT_TRUE(takes(any, data_frame(0x7FF, {})));
}

TEST(KernelFilter, AnElevenBitIdentifierIsOneWithUpperBitsZero) {
  const FrameFilter filter{.identifier = 0x10000123, .extended = FlagFilter::either};
  EXPECT_FALSE(takes(filter, data_frame(0x123, {})));
}

}  // namespace
