#include "layer2/dds/convert.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <set>
#include <string>

#include "can/flagged_frames.h"
#include "dds/bounded_text.h"

namespace layer2::dds {
namespace {

using can::test::data_frame;
using can::test::extended;
using can::test::remote;

constexpr RequestKey kKey = {{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16}, 42};

TEST(Convert, FramesOfEveryKindComeBackTheSame) {
  for (const can::Frame& frame : can::test::four_kinds()) EXPECT_EQ(to_core(to_idl(frame)), frame);
}

TEST(Convert, AFrameFieldByField) {
  const layer2_CanFrame frame = to_idl(extended(data_frame(0x18DAF110, {0x02, 0x10, 0x03})));
  EXPECT_EQ(frame.identifier, 0x18DAF110u);
  EXPECT_TRUE(frame.extended);
  EXPECT_FALSE(frame.remote);
  EXPECT_EQ(frame.length, 3);
  const std::uint8_t data[8] = {0x02, 0x10, 0x03};
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(frame.data[i], data[i]) << i;
}

TEST(Convert, WhatIsNotSentIsZero) {
  layer2_CanFrame frame = {};
  frame.identifier = 0x7FF;
  frame.length = 2;
  for (std::uint8_t& byte : frame.data) byte = 0xAA;
  EXPECT_EQ(to_core(frame), data_frame(0x7FF, {0xAA, 0xAA}));
  frame.remote = true;
  EXPECT_EQ(to_core(frame), remote(data_frame(0x7FF, {0, 0})));
}

TEST(Convert, NumbersOutOfRangeAreCut) {
  layer2_CanFrame frame = {};
  frame.identifier = 0xFFFFFFFF;
  frame.length = 255;
  const can::Frame narrow = to_core(frame);
  EXPECT_EQ(narrow.id, 0x7FFu);
  EXPECT_EQ(narrow.dlc, 8);
  frame.extended = true;
  EXPECT_EQ(to_core(frame).id, 0x1FFFFFFFu);
}

TEST(Convert, ARequestWithoutATimeHasTheDefault) {
  layer2_SendRequest request = {};
  request.content = to_idl(data_frame(0x123, {1}));
  const SendOrder order = to_core(request, 5, std::chrono::milliseconds(250));
  EXPECT_EQ(order.id, 5u);
  EXPECT_EQ(order.frame, data_frame(0x123, {1}));
  EXPECT_EQ(order.timeout, std::chrono::milliseconds(250));
  request.timeout = 7;
  EXPECT_EQ(to_core(request, 5, std::chrono::milliseconds(250)).timeout, std::chrono::milliseconds(7));
}

TEST(Convert, AReceivedFrameHasItsTimeAndItsRange) {
  const layer2_ReceivedFrame received = received_frame(data_frame(0x181, {9}), 1234, 63, true);
  EXPECT_EQ(received.received.identifier, 0x181u);
  EXPECT_EQ(received.receive_time, 1234);
  EXPECT_EQ(received.range_index, 63);
}

TEST(Convert, EachOutcomeHasItsCodeAndAReason) {
  const std::pair<Outcome, gateway_ReplyCode> codes[] = {{Outcome::done, gateway_REPLY_DONE},
                                                         {Outcome::no_answer, gateway_REPLY_NO_ANSWER},
                                                         {Outcome::timeout, gateway_REPLY_TIMEOUT},
                                                         {Outcome::cancelled, gateway_REPLY_CANCELLED},
                                                         {Outcome::stopped, gateway_REPLY_MASTER_STOPPED},
                                                         {Outcome::displaced, gateway_REPLY_REPLACED},
                                                         {Outcome::deleted, gateway_REPLY_CANCELLED}};
  for (const auto& [outcome, code] : codes) {
    const layer2_SendReply reply = send_reply(kKey, {42, outcome, Time{5}, Obstacle::none}, 99);
    EXPECT_EQ(reply.code, code);
    EXPECT_EQ(reply.request, 42u);
    EXPECT_EQ(reply.client[15], 16);
    EXPECT_EQ(reply.sent_time, outcome == Outcome::done ? 99 : 0);
    EXPECT_EQ(text(reply.reason).empty(), outcome == Outcome::done);
  }
}

TEST(Convert, EachObstacleHasAReasonOfItsOwnThatFits) {
  std::set<std::string_view> reasons;
  for (const Obstacle obstacle :
       {Obstacle::none, Obstacle::queue_full, Obstacle::bus_off, Obstacle::interface_down,
        Obstacle::not_delivered, Obstacle::window_closed}) {
    const std::string_view reason = reason_of(Outcome::timeout, obstacle);
    EXPECT_LT(reason.size(), std::size_t{gateway_TEXT});
    EXPECT_TRUE(reasons.insert(reason).second) << reason;
  }
}

TEST(Convert, AClosedWindowIsToldWithWhatHelps) {
  const std::string_view reason = reason_of(Outcome::timeout, Obstacle::window_closed);
  EXPECT_NE(reason.find("synchronous window was closed"), std::string_view::npos) << reason;
  for (const char* helps : {"window.end_us", "window.repeat_us", "timeout"})
    EXPECT_NE(reason.find(helps), std::string_view::npos) << reason;
}

TEST(Convert, AnObjectThatTimedOutSaysWhatKeptItsFrameFromTheBus) {
  const ObjectAnswer answer{.id = 42, .outcome = Outcome::timeout, .obstacle = Obstacle::not_delivered};
  const layer2_ObjectReply reply = object_reply(kKey, answer, 0);
  EXPECT_EQ(reply.code, gateway_REPLY_TIMEOUT);
  EXPECT_EQ(text(reply.reason), reason_of(Outcome::timeout, Obstacle::not_delivered));
}

TEST(Convert, ARefusalHasItsCauseAndReason) {
  const layer2_SendReply reply = send_refused(kKey, {gateway_CAUSE_LENGTH, "content.length 9: out of range"});
  EXPECT_EQ(reply.code, gateway_REPLY_REFUSED);
  EXPECT_EQ(reply.cause, gateway_CAUSE_LENGTH);
  EXPECT_EQ(text(reply.reason), "content.length 9: out of range");
  EXPECT_EQ(reply.request, 42u);
}

/// QoS in the words of the document.
std::string in_words(const TopicQos& qos) {
  std::string words = qos.reliable ? "reliable" : "best effort";
  words += qos.keep_all ? fmt::format(", keep all: {} samples, {} keys, {} a key", qos.max_samples,
                                      qos.max_instances, qos.max_samples_per_instance)
                        : fmt::format(", keep last {}", qos.depth);
  if (qos.transient_local) words += ", transient local";
  if (qos.owned) {
    words += fmt::format(", one writer at a time, liveliness {} ms offered, {} ms asked for",
                         qos.offered_lease / DDS_MSECS(1), qos.lease / DDS_MSECS(1));
  }
  return words;
}

TEST(Topics, DocumentShowsTheTable) {
  std::ifstream file(CANSYNC_LAYER2_DOC);
  const std::string document{std::istreambuf_iterator<char>(file), {}};
  for (const TopicInfo* topic : all_topics()) {
    std::string key = topic->type->m_nkeys == 0 ? "–" : "";
    for (std::uint32_t i = 0; i < topic->type->m_nkeys; ++i)
      key += std::string(i == 0 ? "" : ", ") + topic->type->m_keys[i].m_name;
    const std::string row = fmt::format("| `{}` | {} | {} | {} |", topic->name,
                                        topic->from_daemon ? "daemon" : "clients", key, in_words(topic->qos));
    EXPECT_NE(document.find(row), std::string::npos) << "docs/layer2.md has no row: " << row;
  }
}

TEST(Topics, EachHasItsOwnNameAndTheTypeOfThatName) {
  std::set<std::string_view> names;
  for (const TopicInfo* topic : all_topics()) {
    EXPECT_TRUE(names.insert(topic->name).second) << topic->name;
    const bool of_every_protocol = std::string_view(topic->type->m_typename).starts_with("gateway::");
    EXPECT_EQ(topic->type->m_typename,
              fmt::format("{}::{}", of_every_protocol ? "gateway" : "layer2", topic->name));
    EXPECT_EQ(topic->qos.keep_all, topic->qos.max_samples > 0) << topic->name;
  }
  EXPECT_EQ(names.size(), 22u);
}

}  // namespace
}  // namespace layer2::dds
