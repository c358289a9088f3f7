// Every (state, event) of a slave against the table in docs/cansync-protocol.md.

#include "cansync/supervision/slave_state.h"

#include <gtest/gtest.h>

#include <set>

#include "support/documented_table.h"

namespace cansync {
namespace {

constexpr SlaveState state_at(unsigned index) {
  return static_cast<SlaveState>(index);
}
constexpr SlaveEvent event_at(unsigned index) {
  return static_cast<SlaveEvent>(index);
}

TEST(SlaveStates, FollowTheDocumentedTable) {
  ::test::expect_documented<SlaveState, SlaveEvent>(CANSYNC_PROTOCOL_DOC, "<!-- states of a slave -->",
                                                    kSlaveStates, kSlaveEvents);
}

TEST(SlaveStates, EachIsReachedFromTheFirst) {
  std::set<SlaveState> reached = {SlaveState::absent};
  for (std::size_t before = 0; before != reached.size();) {
    before = reached.size();
    for (const SlaveState state : std::set<SlaveState>(reached)) {
      for (unsigned event = 0; event < kSlaveEvents; ++event) {
        if (const auto to = next(state, event_at(event))) reached.insert(*to);
      }
    }
  }
  EXPECT_EQ(reached.size(), kSlaveStates);
}

TEST(SlaveStates, OneThatWasAwayIsReleasedByItsListAlone) {
  for (unsigned event = 0; event < kSlaveEvents; ++event) {
    for (unsigned from = 0; from < kSlaveStates; ++from) {
      if (next(state_at(from), event_at(event)) != SlaveState::released) continue;
      const bool first_time =
          state_at(from) == SlaveState::starting && event_at(event) == SlaveEvent::synchronized;
      const bool list = is_held_out(state_at(from)) && event_at(event) == SlaveEvent::check_passed;
      EXPECT_TRUE(first_time || list) << name(state_at(from)) << ", " << name(event_at(event));
    }
  }
}

TEST(SlaveStates, WhatIsNoEventChangesNothing) {
  for (unsigned from = 0; from < kSlaveStates; ++from) {
    EXPECT_FALSE(next(state_at(from), event_at(kSlaveEvents))) << name(state_at(from));
  }
}

}  // namespace
}  // namespace cansync
