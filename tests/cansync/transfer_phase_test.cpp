// Every (phase, event) of a transfer against the table in docs/cansync-protocol.md.

#include "cansync/channel/transfer_phase.h"

#include <gtest/gtest.h>

#include "support/documented_table.h"

namespace cansync {
namespace {

constexpr TransferPhase phase_at(unsigned index) {
  return static_cast<TransferPhase>(index);
}
constexpr TransferEvent event_at(unsigned index) {
  return static_cast<TransferEvent>(index);
}

TEST(TransferPhases, FollowTheDocumentedTable) {
  ::test::expect_documented<TransferPhase, TransferEvent>(
      CANSYNC_PROTOCOL_DOC, "<!-- phases of a transfer -->", kTransferPhases, kTransferEvents);
}

TEST(TransferPhases, EachEndsAndNoneGoesOnAfterTheEnd) {
  for (unsigned phase = 0; phase < kTransferPhases; ++phase) {
    const bool over = phase_at(phase) == TransferPhase::ended;
    EXPECT_EQ(next(phase_at(phase), TransferEvent::ended).has_value(), !over) << name(phase_at(phase));
    for (unsigned event = 0; over && event < kTransferEvents; ++event) {
      EXPECT_FALSE(next(phase_at(phase), event_at(event))) << name(event_at(event));
    }
  }
}

TEST(TransferPhases, BytesGoOverOnlyAfterTheSlaveHasBegunTheBlock) {
  for (unsigned phase = 0; phase < kTransferPhases; ++phase) {
    for (unsigned event = 0; event < kTransferEvents; ++event) {
      if (next(phase_at(phase), event_at(event)) != TransferPhase::body) continue;
      const bool begun = phase_at(phase) == TransferPhase::initialise
                             ? event_at(event) == TransferEvent::accepted
                             : phase_at(phase) == TransferPhase::body;
      EXPECT_TRUE(begun) << name(phase_at(phase)) << ", " << name(event_at(event));
    }
  }
}

TEST(TransferPhases, WhatIsNoEventChangesNothing) {
  for (unsigned phase = 0; phase < kTransferPhases; ++phase) {
    EXPECT_FALSE(next(phase_at(phase), event_at(kTransferEvents))) << name(phase_at(phase));
  }
}

}  // namespace
}  // namespace cansync
