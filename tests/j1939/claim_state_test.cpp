// Every (state, event) of the address claim against the table in docs/j1939.md.

#include "j1939/claim_state.h"

#include <gtest/gtest.h>

#include "support/documented_table.h"

namespace j1939 {
namespace {

TEST(ClaimStates, FollowTheDocumentedTable) {
  ::test::expect_documented<ClaimState, ClaimEvent>(J1939_DOC, "<!-- states of the claim -->", kClaimStates,
                                                    kClaimEvents);
}

TEST(ClaimStates, AnAddressIsHadOnlyAfterAClaimThatNobodyDisturbed) {
  for (unsigned state = 0; state < kClaimStates; ++state) {
    for (unsigned event = 0; event < kClaimEvents; ++event) {
      if (next(static_cast<ClaimState>(state), static_cast<ClaimEvent>(event)) != ClaimState::claimed)
        continue;
      EXPECT_EQ(static_cast<ClaimState>(state), ClaimState::claiming);
      EXPECT_EQ(static_cast<ClaimEvent>(event), ClaimEvent::undisturbed);
    }
  }
}

}  // namespace
}  // namespace j1939
