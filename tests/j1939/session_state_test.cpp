// Every (state, event) of a message in packets against the table in docs/j1939.md.

#include "j1939/session_state.h"

#include <gtest/gtest.h>

#include "support/documented_table.h"

namespace j1939 {
namespace {

TEST(SessionStates, FollowTheDocumentedTable) {
  ::test::expect_documented<SessionState, SessionEvent>(J1939_DOC, "<!-- states of a message in packets -->",
                                                        kSessionStates, kSessionEvents);
}

TEST(SessionStates, EachEnds) {
  for (unsigned state = 0; state < kSessionStates; ++state) {
    const auto from = static_cast<SessionState>(state);
    EXPECT_EQ(next(from, SessionEvent::ended).has_value(), from != SessionState::free) << name(from);
  }
}

}  // namespace
}  // namespace j1939
