#include "cansync_slave/dds/topics.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <string_view>

#include "cansync_slave/dds/convert.h"
#include "cansync_slave/dds/validate.h"

namespace cansync_slave::dds {
namespace {

/// QoS in the words of the document.
std::string in_words(const TopicQos& qos) {
  std::string words = qos.reliable ? "reliable" : "best effort";
  words += qos.keep_all ? fmt::format(", keep all: {} samples, {} keys, {} a key", qos.max_samples,
                                      qos.max_instances, qos.max_samples_per_instance)
                        : fmt::format(", keep last {}", qos.depth);
  if (qos.transient_local) words += ", transient local";
  if (qos.exclusive) words += ", exclusive";
  return words;
}

TEST(SlaveTopics, DocumentShowsTheTable) {
  std::ifstream file(CANSYNC_SLAVE_DOC);
  const std::string document{std::istreambuf_iterator<char>(file), {}};
  for (const TopicInfo* topic : all_topics()) {
    const std::string key = topic->type->m_nkeys == 0 ? "–" : topic->type->m_keys[0].m_name;
    const std::string row = fmt::format("| `{}` | {} | {} | {} |", topic->name,
                                        topic->from_daemon ? "daemon" : "clients", key, in_words(topic->qos));
    EXPECT_NE(document.find(row), std::string::npos) << "docs/cansync-slave.md has no row: " << row;
  }
}

TEST(SlaveTopics, EachHasItsOwnNameAndTheTypeOfThatName) {
  std::set<std::string_view> names;
  for (const TopicInfo* topic : all_topics()) {
    EXPECT_TRUE(names.insert(topic->name).second) << topic->name;
    const bool of_every_protocol = std::string_view(topic->type->m_typename).starts_with("gateway::");
    EXPECT_EQ(topic->type->m_typename,
              fmt::format("{}::{}", of_every_protocol ? "gateway" : "cansync_slave", topic->name));
  }
}

TEST(SlaveConvert, TelegramsFillTheirHalfAndSayWhichCame) {
  ReceivedValues received;
  received.words = 0x02;
  received.took(cansync::Channel::one, {1, 2, 3, 4}, 7, 1000);
  received.took(cansync::Channel::two, {1, 2, 3, 4, 5, 6, 7, 8}, 8, 2000);
  const auto sample = references_received(received, 3);
  EXPECT_EQ(sample.arrived, 2);
  EXPECT_EQ(sample.ever, 3);
  EXPECT_EQ(sample.words, 2);
  EXPECT_EQ(sample.interval[0], 7u);
  EXPECT_EQ(sample.interval[1], 8u);
  EXPECT_EQ(sample.raw[4], 5u);
  EXPECT_EQ(sample.receive_time, 2000);
  EXPECT_EQ(sample.lost, 3u);
  cansync::ProcessMapping mapping;
  mapping[0] = cansync::default_mapping(cansync::Channel::one);
  mapping[1].word[3] = *cansync::from_register(0x1D);
  const auto monitored = monitored_values(*cansync::SlaveNumber::from(31), received, mapping);
  EXPECT_EQ(monitored.slave, 31);
  EXPECT_EQ(std::to_array(monitored.mapping),
            (std::array<std::uint8_t, 8>{0x01, 0x03, 0x05, 0x07, 0, 0, 0, 0x1D}));
}

TEST(SlaveValidate, AReleaseOutOfItsRangeIsRefusedWithTheRange) {
  cansync_slave_ActualRelease release = {};
  release.telegram = 1;
  EXPECT_FALSE(check(release));
  release.telegram = 3;
  EXPECT_EQ(check(release)->reason, "telegram 3: out of range; allowed 1 or 2");
  release.telegram = 2;
  release.valid = 0x10;
  EXPECT_EQ(check(release)->cause, gateway_CAUSE_FIELD);
  release.valid = 0x0F;
  release.wait_intervals = kMostWaitIntervals + 1;
  EXPECT_EQ(check(release)->reason, "wait_intervals 1001: out of range; allowed 0..1000, 0 = 1");
}

}  // namespace
}  // namespace cansync_slave::dds
