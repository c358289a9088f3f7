// The time base of a slave, with the SYNC inputs of a CAN interface.
#include "daemon/cansync_slave/realtime/sync_follower.h"

#include <gtest/gtest.h>

#include <chrono>

#include "sync/fake_system.h"
#include "sync/software_sync.h"

namespace cansyncd {
namespace {

using std::chrono::milliseconds;

/// Answers count from the newest edge until the intervals follow the input (M 3.2.0.1): without it they would
/// count from their request, and start after their slot.
TEST(SyncFollowerTest, TheNewestEdgeIsKnownBeforeIntervalsFollowIt) {
  sync_line::test::FakeSystem system;
  DaemonConfig config;
  config.bus.bits_per_second = 125000;
  config.sync.input = SyncInput::can;
  SyncLine line(config, milliseconds(8), system);
  SyncFollower follower(*line.following(), true, {&line, nullptr});
  EXPECT_FALSE(follower.newest());
  can::ReceivedFrame received;
  received.frame = sync_line::software_sync(config.sync.can_identifier);
  for (const can::Time edge : {milliseconds(20), milliseconds(28), milliseconds(39)}) {
    received.end = edge;
    received.end += received.end - sync_line::edge_of(received, config.bus.bits_per_second);
    ASSERT_TRUE(follower.take_frame(received));
    EXPECT_FALSE(follower.tracking());
    EXPECT_EQ(follower.newest(), edge);
  }
}

}  // namespace
}  // namespace cansyncd
