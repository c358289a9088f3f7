#include <gtest/gtest.h>

#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

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

FindingList of_slaves(std::initializer_list<unsigned> slaves, const char* fault) {
  FindingList list;
  for (const unsigned slave : slaves)
    list.add_slave(
        Level::error, "drive fault",
        {slave, "slave " + std::to_string(slave) + ": " + fault, fault, "cansync control {slaves} WORD"});
  return list;
}

TEST(DoctorGroups, SlavesWithTheSameFaultAreOneLineWithTheirNumbers) {
  FindingList list = of_slaves({0, 1, 2, 5}, "over temperature");
  list.add(of_slaves({3}, "undervoltage").take());
  list.warning("missed", "3 telegrams left out", "cansync timing");
  const std::vector<Finding> shown = grouped(std::move(list).take());
  ASSERT_EQ(shown.size(), 3u);
  EXPECT_EQ(shown[0].found, "4 slaves (0-2,5): over temperature");
  EXPECT_EQ(shown[0].remedy, "cansync control 0-2,5 WORD");
  EXPECT_EQ(shown[1].found, "slave 3: undervoltage");
  EXPECT_EQ(shown[1].remedy, "cansync control 3 WORD");
  EXPECT_EQ(shown[2].found, "3 telegrams left out");
}

TEST(DoctorGroups, TheFirstErrorIsFixedFirstAndTheStateThatWaitsForSlavesAfterThem) {
  FindingList list;
  list.ok("daemon", "serves bus can0");
  list.warning("kernel", "not a realtime one", "install one");
  std::vector<Finding> all = FindingList(list).take();
  EXPECT_EQ(first_to_fix(all)->topic, "kernel");
  list.error("operating state", "waits for slaves", "fix the slaves");
  all = FindingList(list).take();
  EXPECT_EQ(first_to_fix(all)->topic, "operating state");
  list.add(of_slaves({3}, "undervoltage").take());
  all = std::move(list).take();
  EXPECT_EQ(first_to_fix(all)->topic, "drive fault");
  all.clear();
  EXPECT_EQ(first_to_fix(all), nullptr);
}

}  // namespace
}  // namespace cansync::cli
