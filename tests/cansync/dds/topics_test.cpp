#include "cansync/dds/topics.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <set>
#include <string>

namespace cansync::dds {
namespace {

std::string read_document() {
  std::ifstream file(CANSYNC_DDS_DOC);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// QoS in the words of the document.
std::string in_words(const TopicQos& qos) {
  std::string text = qos.reliable ? "reliable" : "best effort";
  text += qos.keep_all ? fmt::format(", keep all: {} samples, {} keys, {} a key", qos.max_samples,
                                     qos.max_instances, qos.max_samples_per_instance)
                       : fmt::format(", keep last {}", qos.depth);
  if (qos.transient_local) text += ", transient local";
  if (qos.owned)
    text += fmt::format(", one writer at a time, automatic liveliness {} ms", qos.lease / 1'000'000);
  return text;
}

TEST(Topics, DocumentShowsTheTable) {
  const std::string document = read_document();
  for (const TopicInfo* topic : all_topics()) {
    std::string key = topic->type->m_nkeys == 0 ? "–" : "";
    for (std::uint32_t i = 0; i < topic->type->m_nkeys; ++i)
      key += std::string(i == 0 ? "" : ", ") + topic->type->m_keys[i].m_name;
    const std::string row = fmt::format("| `{}` | {} | {} | {} |", topic->name,
                                        topic->from_daemon ? "daemon" : "clients", key, in_words(topic->qos));
    EXPECT_NE(document.find(row), std::string::npos) << "docs/dds-api.md has no row: " << row;
  }
}

TEST(Topics, EachHasItsOwnNameAndTheTypeOfThatName) {
  std::set<std::string_view> names;
  for (const TopicInfo* topic : all_topics()) {
    EXPECT_TRUE(names.insert(topic->name).second) << topic->name;
    const std::string_view type = topic == &kEngineerCommandTopic ? "Command" : topic->name;
    const bool of_every_protocol = std::string_view(topic->type->m_typename).starts_with("gateway::");
    EXPECT_EQ(topic->type->m_typename,
              fmt::format("{}::{}", of_every_protocol ? "gateway" : "cansync", type));
    EXPECT_LE(topic->type->m_nkeys, topic->qos.owned ? 2u : 1u);
    ASSERT_NE(topic->final_type, nullptr) << topic->name << " is missing with dds.types = \"final\"";
    EXPECT_EQ(topic->final_type->m_typename, std::string_view(topic->type->m_typename));
    EXPECT_EQ(topic->final_type->m_size, topic->type->m_size) << "the same struct";
  }
  EXPECT_EQ(names.size(), 23u);
}

TEST(Topics, BoundsAndLeasesHold) {
  for (const TopicInfo* topic : all_topics()) {
    const TopicQos& qos = topic->qos;
    // Nothing that is kept whole is kept without a bound, and nothing but state survives its writer's next
    // sample.
    EXPECT_EQ(qos.keep_all, qos.max_samples > 0) << topic->name;
    EXPECT_LE(qos.max_samples_per_instance, qos.max_samples) << topic->name;
    EXPECT_LE(qos.offered_lease, qos.lease) << topic->name;  // or our own writers would not match
  }
}

TEST(Topics, QosObjectsSayWhatTheTableSays) {
  const TopicInfo& references = topic_info<cansync_ReferenceValues>;
  const Qos reader = reader_qos(references);
  const Qos writer = writer_qos(references, 7);
  dds_ownership_kind_t ownership = DDS_OWNERSHIP_EXCLUSIVE;
  ASSERT_TRUE(dds_qget_ownership(reader.get(), &ownership));
  EXPECT_EQ(ownership, DDS_OWNERSHIP_SHARED) << "or the daemon would not see who waits";
  std::int32_t strength = 0;
  ASSERT_TRUE(dds_qget_ownership_strength(writer.get(), &strength));
  EXPECT_EQ(strength, 7);
  dds_liveliness_kind_t kind = DDS_LIVELINESS_MANUAL_BY_TOPIC;
  dds_duration_t lease = 0;
  ASSERT_TRUE(dds_qget_liveliness(reader.get(), &kind, &lease));
  EXPECT_EQ(kind, DDS_LIVELINESS_AUTOMATIC);
  EXPECT_EQ(lease, DDS_SECS(1));
  ASSERT_TRUE(dds_qget_liveliness(writer.get(), &kind, &lease));
  EXPECT_EQ(lease, DDS_MSECS(500));
  bool autodispose = true;
  ASSERT_TRUE(dds_qget_writer_data_lifecycle(writer.get(), &autodispose));
  EXPECT_FALSE(autodispose);

  const Qos events = writer_qos(topic_info<gateway_Event>);
  dds_history_kind_t history = DDS_HISTORY_KEEP_ALL;
  std::int32_t depth = 0;
  ASSERT_TRUE(
      dds_qget_durability_service(events.get(), nullptr, &history, &depth, nullptr, nullptr, nullptr));
  EXPECT_EQ(history, DDS_HISTORY_KEEP_LAST);
  EXPECT_EQ(depth, 100);
}

}  // namespace
}  // namespace cansync::dds
