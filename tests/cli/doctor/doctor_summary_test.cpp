#include <gtest/gtest.h>

#include "cli/doctor/doctor_findings.h"

namespace cansync::cli {
namespace {

Finding finding(Level level, const char* topic) {
  return {level, topic, "found", ""};
}

TEST(DoctorSummary, NamesWhatIsNotOkTheWorseFirstAndEachTopicOnce) {
  EXPECT_EQ(summary({finding(Level::ok, "daemon"), finding(Level::ok, "SYNC")}), "everything is ok");
  EXPECT_EQ(summary({finding(Level::warning, "missed"), finding(Level::ok, "SYNC")}), "1 warning: missed");
  EXPECT_EQ(summary({finding(Level::warning, "missed"), finding(Level::error, "drive fault"),
                     finding(Level::ok, "SYNC"), finding(Level::error, "drive fault"),
                     finding(Level::warning, "kernel")}),
            "2 errors: drive fault; 2 warnings: missed, kernel");
}

}  // namespace
}  // namespace cansync::cli
