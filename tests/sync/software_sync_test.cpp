#include "sync/software_sync.h"

#include <gtest/gtest.h>

namespace {

using namespace sync_line;

TEST(SoftwareSync, IsAStandardFrameWithoutData) {
  const can::Frame frame = software_sync(0x80);
  EXPECT_EQ(frame.id, 0x80U);
  EXPECT_EQ(frame.dlc, 0U);
  EXPECT_TRUE(is_software_sync(frame, 0x80));
  EXPECT_FALSE(is_software_sync(frame, 0x81));
  can::Frame other = frame;
  other.dlc = 1;
  EXPECT_FALSE(is_software_sync(other, 0x80));
  other = frame;
  other.remote = true;
  EXPECT_FALSE(is_software_sync(other, 0x80));
}

TEST(SoftwareSync, TheEdgeIsTheBeginningOfTheFrame) {
  can::ReceivedFrame received;
  received.frame = software_sync(0x80);
  received.end = std::chrono::milliseconds(5);
  const unsigned bits = can::frame_bits(received.frame) - can::kInterframeBits;
  ASSERT_GE(bits, 44U);
  EXPECT_EQ(received.end - edge_of(received, 1'000'000), std::chrono::microseconds(bits));
  EXPECT_EQ(received.end - edge_of(received, 125'000), std::chrono::microseconds(bits) * 8);
}

}  // namespace
