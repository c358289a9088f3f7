#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include "dds/bounded_text.h"
#include "j1939/dds/convert.h"
#include "j1939/dds/texts.h"
#include "j1939/dds/topics.h"

namespace j1939::dds {
namespace {

using gateway::dds::text;
using std::chrono::milliseconds;

const gateway::dds::RequestKey kKey = {{1, 2, 3}, 42};

j1939_MessageRequest asked(std::vector<std::uint8_t>& data) {
  j1939_MessageRequest request = {};
  request.pgn = 0xEF00;
  request.priority = 5;
  request.destination = 0x21;
  request.data._length = static_cast<std::uint32_t>(data.size());
  request.data._buffer = data.data();
  return request;
}

TEST(MessageConvert, ARequestBecomesAnOrderWithItsOwnMemory) {
  std::vector<std::uint8_t> data = {1, 2, 3};
  std::vector<std::uint8_t> memory;
  const Order order = to_core(asked(data), 7, milliseconds(1000), kMostBytes, memory);
  EXPECT_EQ(order.id, 7u);
  EXPECT_EQ(order.kind, OrderKind::send);
  EXPECT_EQ(order.number, 0xEF00u);
  EXPECT_EQ(order.priority, 5);
  EXPECT_EQ(order.destination, 0x21);
  EXPECT_EQ(order.timeout, milliseconds(1000));
  EXPECT_EQ(memory, data);
  EXPECT_EQ(order.memory.data(), memory.data());
}

TEST(MessageConvert, TheDefaultTimeGrowsWithThePacketsAndAGivenOneDoesNot) {
  std::vector<std::uint8_t> data(1785);
  std::vector<std::uint8_t> memory;
  j1939_MessageRequest request = asked(data);
  EXPECT_EQ(to_core(request, 1, milliseconds(1000), kMostBytes, memory).timeout,
            milliseconds(1000 + 255 * 200));
  request.timeout = 30;
  EXPECT_EQ(to_core(request, 1, milliseconds(1000), kMostBytes, memory).timeout, milliseconds(30));
}

TEST(MessageConvert, ARequestForAGroupHasRoomForItsAnswer) {
  std::vector<std::uint8_t> none;
  std::vector<std::uint8_t> memory;
  j1939_MessageRequest request = asked(none);
  request.kind = j1939_MESSAGE_ASK;
  EXPECT_EQ(to_core(request, 1, milliseconds(1000), kMostBytes, memory).memory.size(), kMostBytes);
  request.destination = 255;
  EXPECT_EQ(to_core(request, 1, milliseconds(1000), kMostBytes, memory).memory.size(), 0u);
}

TEST(MessageConvert, EachOutcomeHasItsCodeAndAReasonThatFits) {
  std::vector<std::uint8_t> answer = {4, 5, 6};
  for (const auto& [outcome, code] : std::vector<std::pair<Outcome, gateway_ReplyCode>>{
           {Outcome::done, gateway_REPLY_DONE},
           {Outcome::refused, gateway_REPLY_SLAVE_ERROR},
           {Outcome::aborted, gateway_REPLY_SLAVE_ERROR},
           {Outcome::no_answer, gateway_REPLY_NO_ANSWER},
           {Outcome::timeout, gateway_REPLY_TIMEOUT},
           {Outcome::cancelled, gateway_REPLY_CANCELLED},
           {Outcome::address_lost, gateway_REPLY_MASTER_STOPPED},
           {Outcome::stopped, gateway_REPLY_MASTER_STOPPED}}) {
    const auto reply = message_reply(kKey, {.outcome = outcome, .code = 2, .size = 3}, 99, answer);
    EXPECT_EQ(reply.code, code);
    EXPECT_EQ(reply.request, 42u);
    EXPECT_EQ(reply.client[2], 3);
    EXPECT_EQ(text(reply.reason).empty(), outcome == Outcome::done);
    EXPECT_LT(reason_of({.outcome = outcome}).size(), std::size_t{gateway_TEXT});
    EXPECT_EQ(reply.data._length, outcome == Outcome::done ? 3u : 0u);
    EXPECT_EQ(reply.sent_time, outcome == Outcome::done ? 99 : 0);
  }
}

TEST(MessageConvert, AReceivedMessageKeepsEverything) {
  const std::vector<std::uint8_t> data = {9, 8};
  const auto out = received_message({0xFEF1, 3, 0x21, 255, Transport::broadcast, Time{5}, data}, 123456, 7);
  EXPECT_EQ(out.pgn, 0xFEF1u);
  EXPECT_EQ(out.priority, 3);
  EXPECT_EQ(out.source, 0x21);
  EXPECT_EQ(out.destination, 255);
  EXPECT_EQ(out.transport, j1939_TRANSPORT_BROADCAST);
  EXPECT_EQ(out.receive_time, 123456);
  EXPECT_EQ(out.range_index, 7);
  EXPECT_EQ(out.data._length, 2u);
  EXPECT_EQ(out.data._buffer[1], 8);
}

TEST(MessageConvert, FaultsOfADiagnosticMessage) {
  const std::vector<std::uint8_t> message = {0x44, 0xFF, 0xB8, 0x04, 0x03, 0x0A, 0x01, 0x00, 0x02, 0x7F};
  std::vector<j1939_TroubleCode> memory;
  j1939_FaultList list = {};
  ASSERT_TRUE(fault_list(message, 0x21, true, 55, memory, list));
  EXPECT_EQ(list.source, 0x21);
  EXPECT_TRUE(list.active);
  EXPECT_EQ(list.malfunction_lamp, 1);
  EXPECT_EQ(list.amber_warning_lamp, 1);
  EXPECT_EQ(list.red_stop_lamp, 0);
  ASSERT_EQ(list.codes._length, 2u);
  EXPECT_EQ(list.codes._buffer[0].spn, 1208u);
  EXPECT_EQ(list.codes._buffer[0].fmi, 3);
  EXPECT_EQ(list.codes._buffer[0].occurrences, 10);
  EXPECT_EQ(list.codes._buffer[1].occurrences, 127);
  EXPECT_FALSE(fault_list(std::vector<std::uint8_t>{1}, 0x21, true, 55, memory, list));
}

/// QoS in the words of the document.
std::string qos_in_words(const TopicQos& qos) {
  std::string words = qos.reliable ? "reliable" : "best effort";
  words += qos.keep_all ? fmt::format(", keep all: {} samples, {} keys, {} a key", qos.max_samples,
                                      qos.max_instances, qos.max_samples_per_instance)
                        : fmt::format(", keep last {}", qos.depth);
  if (qos.transient_local) words += ", transient local";
  return words;
}

TEST(MessageTopics, DocumentShowsTheTable) {
  std::ifstream file(CANSYNC_J1939_DOC);
  const std::string document{std::istreambuf_iterator<char>(file), {}};
  for (const TopicInfo* topic : all_topics()) {
    const std::string key = topic->type->m_nkeys == 0 ? "–" : topic->type->m_keys[0].m_name;
    const std::string row =
        fmt::format("| `{}` | {} | {} | {} |", topic->name, topic->from_daemon ? "daemon" : "clients", key,
                    qos_in_words(topic->qos));
    EXPECT_NE(document.find(row), std::string::npos) << "docs/j1939.md has no row: " << row;
  }
}

TEST(MessageTopics, EachHasItsOwnNameAndTheTypeOfThatName) {
  std::set<std::string_view> names;
  for (const TopicInfo* topic : all_topics()) {
    EXPECT_TRUE(names.insert(topic->name).second) << topic->name;
    const bool of_every_protocol = std::string_view(topic->type->m_typename).starts_with("gateway::");
    EXPECT_EQ(topic->type->m_typename,
              fmt::format("{}::{}", of_every_protocol ? "gateway" : "j1939", topic->name));
  }
  EXPECT_EQ(names.size(), 15u);
}

}  // namespace
}  // namespace j1939::dds
