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
  if (qos.owned) words += ", one writer at a time";
  return words;
}

TEST(SlaveTopics, DocumentShowsTheTable) {
  std::ifstream file(CANSYNC_SLAVE_DOC);
  const std::string document{std::istreambuf_iterator<char>(file), {}};
  for (const TopicInfo* topic : all_topics()) {
    std::string key = topic->type->m_nkeys == 0 ? "–" : "";
    for (std::uint32_t i = 0; i < topic->type->m_nkeys; ++i)
      key += std::string(i == 0 ? "" : ", ") + topic->type->m_keys[i].m_name;
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

/// A sample that is refused, and the same as the text of the refusal allows it.
template <class T>
void expect_remedy(const T& good, void (*spoil)(T&), std::string_view text, void (*allow)(T&)) {
  T asked = good;
  spoil(asked);
  const auto refused = check(asked);
  ASSERT_TRUE(refused) << text;
  EXPECT_NE(refused->reason.find(text), std::string::npos) << refused->reason;
  allow(asked);
  EXPECT_FALSE(check(asked)) << text;
}

TEST(SlaveValidate, WhatATextAllowsIsTaken) {
  using R = cansync_slave_ActualRelease;
  R release = {};
  release.telegram = 1;
  expect_remedy<R>(
      release, [](R& r) { r.telegram = 0; }, "allowed 1 or 2", [](R& r) { r.telegram = 2; });
  expect_remedy<R>(
      release, [](R& r) { r.valid = 0x10; }, "allowed 0..0x0F", [](R& r) { r.valid = 0x0F; });
  expect_remedy<R>(
      release, [](R& r) { r.wait_intervals = 1001; }, "allowed 0..1000",
      [](R& r) { r.wait_intervals = 1000; });

  using C = cansync_slave_SlaveCommand;
  C mapping = {};
  mapping.kind = cansync_slave_SLAVE_COMMAND_MAPPING;
  expect_remedy<C>(
      mapping, [](C& c) { c.reference_mapping[0] = 0x11; }, "a value of 0..3",
      [](C& c) { c.reference_mapping[0] = 0x0F; });
  expect_remedy<C>(
      mapping, [](C& c) { c.actual_mapping[4] = 0x0D; }, "a value of 4..7",
      [](C& c) { c.actual_mapping[4] = 0x11; });
  C listen = {};
  listen.kind = cansync_slave_SLAVE_COMMAND_LISTEN;
  expect_remedy<C>(
      listen, [](C& c) { c.other = 32; }, "allowed 0..31", [](C& c) { c.other = 31; });

  using A = cansync_slave_ApplicationAnswer;
  static std::uint16_t parameter = 0;
  A answer = {};
  answer.parameters._buffer = &parameter;
  answer.parameters._length = answer.parameters._maximum = 1;
  expect_remedy<A>(
      answer, [](A&) { parameter = 4096; }, "allowed 0..4095", [](A&) { parameter = 4095; });
  expect_remedy<A>(
      answer, [](A& a) { a.length = 4096; }, "allowed 0..4095", [](A& a) { a.length = 4095; });
  expect_remedy<A>(
      answer,
      [](A& a) {
        a.kind = cansync_slave_ANSWER_BLOCK_REFUSED;
        a.error = 0x00FF;
      },
      "allowed 0x0100..0xFFFF", [](A& a) { a.error = 0x0100; });
}

}  // namespace
}  // namespace cansync_slave::dds
