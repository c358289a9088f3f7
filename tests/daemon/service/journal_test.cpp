#include "daemon/service/journal.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "daemon/service/log.h"
#include "daemon/service/service_log.h"
#include "support/kept_journal.h"

namespace cansyncd {
namespace {

std::vector<std::string> sent_fields;
int keep_fields(const iovec* parts, int count) {
  for (int i = 0; i < count; ++i)
    sent_fields.emplace_back(static_cast<const char*>(parts[i].iov_base), parts[i].iov_len);
  return 0;
}

TEST(JournalEntry, FieldsStayFieldsAndControlCharactersDoNotEndThem) {
  Journal journal(keep_fields);
  journal.write(LogPriority::notice, "slave_lost", "written",
                {{"CLIENT", "a\nPRIORITY=0"}, {"PARAMETER", ""}, {"SLAVE", "3"}});
  const std::vector<std::string> expected = {
      "MESSAGE=written",
      "PRIORITY=5",
      "SYSLOG_IDENTIFIER=cansyncd",
      "MESSAGE_ID=" + std::string(EventCode("slave_lost").message_id()),
      "EVENT=slave_lost",
      "CLIENT=a\\x0aPRIORITY=0",
      "SLAVE=3"};
  EXPECT_EQ(sent_fields, expected);
}

TEST(ServiceLog, EachEntryHasTheBusAndProblemsTheirPlace) {
  KeptJournal kept;
  const ServiceLog log("can0", kept);
  log.say(LogPriority::notice, "daemon_running", "running");
  log.problems({{{"/etc/cansync/can0.toml", 3, 14}, "bus.bit_rate", "found 1"}});
  const auto all = kept.all();
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].field("BUS"), "can0");
  EXPECT_EQ(all[0].field("EVENT"), "daemon_running");
  EXPECT_EQ(all[1].priority, LogPriority::error);
  EXPECT_EQ(all[1].message, "/etc/cansync/can0.toml:3:14: bus.bit_rate: found 1");
  const std::vector<std::pair<std::string, std::string>> expected = {
      {"EVENT", "configuration_wrong"},
      {"BUS", "can0"},
      {"CANSYNC_FILE", "/etc/cansync/can0.toml"},
      {"CANSYNC_LINE", "3"},
      {"CANSYNC_COLUMN", "14"},
      {"CANSYNC_OPTION", "bus.bit_rate"}};
  for (const auto& [name, value] : expected) EXPECT_EQ(all[1].field(name), value) << name;
}

TEST(ServiceLog, EachSentenceOfARefusalToStartIsAnEntry) {
  KeptJournal kept;
  ServiceLog("can0", kept).cannot_run("no such thing\nit helps to add it\n");
  const auto all = kept.all();
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].message, "cannot run: no such thing");
  EXPECT_EQ(all[1].message, "cannot run: it helps to add it");
  for (const auto& entry : all) {
    EXPECT_EQ(entry.field("EVENT"), "daemon_cannot_run");
    EXPECT_EQ(entry.priority, LogPriority::error);
  }
  KeptJournal wordless;
  ServiceLog("can0", wordless).cannot_run("");
  EXPECT_EQ(wordless.all().size(), 1u) << "a daemon never ends without a word";
}

TEST(ServiceLog, ManyProblemsAreCountedInOne) {
  KeptJournal kept;
  ServiceLog("can0", kept)
      .problems(std::vector<config::Problem>(23, config::Problem{{"f", 1, 1}, "", "wrong"}));
  ASSERT_EQ(kept.all().size(), 21u);
  EXPECT_EQ(kept.all().back().message, "and 3 more problems");
}

TEST(LogLine, KeepsThePriorityAsAMarkOrAWord) {
  EXPECT_EQ(line_of(LogPriority::error, "no bus", true), "<3>no bus\n");
  EXPECT_EQ(line_of(LogPriority::info, "a\x1b[31m\nb", true), "<6>a\\x1b[31m\\x0ab\n");
  EXPECT_EQ(line_of(LogPriority::error, "no bus", false), "error: no bus\n");
  EXPECT_EQ(line_of(LogPriority::warning, "slow", false), "warning: slow\n");
  EXPECT_EQ(line_of(LogPriority::notice, "running", false), "running\n");
  EXPECT_EQ(line_of(LogPriority::info, "running", false), "running\n");
}

}  // namespace
}  // namespace cansyncd
