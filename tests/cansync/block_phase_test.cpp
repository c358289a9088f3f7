// Every (phase, event) of a slave's block against the table in docs/cansync-slave.md.

#include "cansync/slave/block_phase.h"

#include <gtest/gtest.h>

#include "support/documented_table.h"

namespace cansync {
namespace {

TEST(BlockPhases, FollowTheDocumentedTable) {
  ::test::expect_documented<BlockPhase, BlockEvent>(CANSYNC_SLAVE_DOC, "<!-- phases of a block -->",
                                                    kBlockPhases, kBlockEvents);
}

TEST(BlockPhases, BytesAreMovedOnlyAfterTheApplicationHasBegunTheBlock) {
  for (unsigned phase = 0; phase < kBlockPhases; ++phase) {
    for (unsigned event = 0; event < kBlockEvents; ++event) {
      if (next(static_cast<BlockPhase>(phase), static_cast<BlockEvent>(event)) != BlockPhase::open) continue;
      EXPECT_EQ(static_cast<BlockEvent>(event), BlockEvent::begun);
    }
  }
}

}  // namespace
}  // namespace cansync
