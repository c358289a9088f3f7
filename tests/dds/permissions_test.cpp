#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <string>

#include "cansync/dds/topics.h"
#include "cansync_slave/dds/topics.h"
#include "j1939/dds/topics.h"
#include "layer2/dds/topics.h"

namespace gateway::dds {
namespace {

using Names = std::set<std::string>;

/// The topics of every protocol that the daemon writes, or that clients write.
Names topics(bool from_daemon) {
  Names names;
  for (const auto all : {cansync::dds::all_topics(), cansync_slave::dds::all_topics(),
                         layer2::dds::all_topics(), j1939::dds::all_topics()}) {
    for (const TopicInfo* topic : all) {
      if (topic->from_daemon == from_daemon) names.emplace(topic->name);
    }
  }
  if (!from_daemon) names.emplace(cansync::dds::kEngineerCommandTopic.name);
  return names;
}

/// What the template of a role has in "publish" or "subscribe".
Names granted(const std::string& role, const std::string& part) {
  std::ifstream file(fmt::format("{}/permissions-{}.xml", CANSYNC_SECURITY_TEMPLATES, role));
  std::string text{std::istreambuf_iterator<char>(file), {}};
  const std::size_t begin = text.find("<" + part + ">");
  if (begin == std::string::npos) return {};
  text = text.substr(begin, text.find("</" + part + ">") - begin);
  Names names;
  const std::regex topic("<topic>([^<]*)</topic>");
  for (std::sregex_iterator it(text.begin(), text.end(), topic), end; it != end; ++it) {
    EXPECT_TRUE(names.insert((*it)[1]).second) << role << ": " << (*it)[1] << " twice";
  }
  return names;
}

TEST(Permissions, TheDaemonHasEveryTopicInItsDirection) {
  EXPECT_EQ(granted("daemon", "publish"), topics(kFromDaemon));
  Names read = topics(kFromClients);
  read.emplace(topic_info<gateway_GatewayStatus>.name);  // of a second daemon on its bus
  EXPECT_EQ(granted("daemon", "subscribe"), read);
}

TEST(Permissions, AnEngineerHasEveryTopicInTheOther) {
  EXPECT_EQ(granted("engineer", "publish"), topics(kFromClients));
  EXPECT_EQ(granted("engineer", "subscribe"), topics(kFromDaemon));
}

TEST(Permissions, AViewerReadsAndWritesNothing) {
  EXPECT_EQ(granted("viewer", "publish"), Names{});
  Names read = topics(kFromDaemon);
  read.erase("JobEndReply");  // to engineers alone
  EXPECT_EQ(granted("viewer", "subscribe"), read);
}

TEST(Permissions, AnOperatorRunsWhatIsSetUp) {
  EXPECT_EQ(granted("operator", "subscribe"), granted("viewer", "subscribe"));
  EXPECT_EQ(granted("operator", "publish"),
            (Names{"ReferenceValues", "Command", "JobCancel", "ActualRelease", "SendRequest", "ImageOutputs",
                   "RunLead", "MessageRequest"}));
}

}  // namespace
}  // namespace gateway::dds
