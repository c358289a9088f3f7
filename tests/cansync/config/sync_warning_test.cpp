// A line that is to run and has no SYNC.
#include "cansync/config/check_sync.h"
#include "config_text.h"

namespace cansyncd {
namespace {

std::string warning(const std::string& options) {
  return sync_warning(good("[bus]\ninterface = \"can7\"\n" + options + kSmallest));
}

TEST(SyncWarning, ALineThatRunsOnACanInterfaceWithoutSyncIsWarnedOf) {
  const std::string found = warning("");
  EXPECT_TRUE(found.starts_with("warning: no SYNC: startup.target is \"active\"")) << found;
  EXPECT_NE(found.find("no drive on can7 locks"), std::string::npos) << found;
  EXPECT_TRUE(found.ends_with("another source\n")) << found;
}

TEST(SyncWarning, SyncFromOrForThisComputerAndLinesThatDoNotRunAreNot) {
  for (const char* fine :
       {"[sync]\noutput = \"can\"\n", "[sync]\noutput = \"gpio\"\n", "[sync]\ninput = \"pps\"\n",
        "[sync]\ninput = \"gpio\"\n", "[startup]\ntarget = \"setup\"\n", "[startup]\ntarget = \"none\"\n"})
    EXPECT_EQ(warning(fine), "") << fine;
  EXPECT_EQ(sync_warning(good("[bus]\ninterface = \"sim\"\n")), "");
}

}  // namespace
}  // namespace cansyncd
