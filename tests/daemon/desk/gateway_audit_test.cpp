#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "access_requests.h"
#include "support/gateway_rig.h"

/// What is written down of requests that change something.
namespace cansyncd {
namespace {

using cansync::Outcome;

/// A kind that is new ends here without a value, and the compiler says so.
std::string_view action_of(cansync_CommandKind kind) {
  switch (kind) {
    case cansync_COMMAND_CONTROL_WORD:
      return "control_word";
    case cansync_COMMAND_BROADCAST:
      return "broadcast";
    case cansync_COMMAND_MODE:
      return "mode";
    case cansync_COMMAND_POLLING:
      return "polling";
    case cansync_COMMAND_CHANNEL_CURSORS:
      return "cursors";
    case cansync_COMMAND_REFERENCE_MAPPING:
      return "reference_mapping";
    case cansync_COMMAND_ACTUAL_MAPPING:
      return "actual_mapping";
    case cansync_COMMAND_RELEASE:
      return "release";
  }
  return "";
}

/// Takes every request that reaches the realtime side and answers it as done.
void answer_as_done(GatewayRig& rig) {
  const auto request = rig.next_request();
  ASSERT_TRUE(request);
  std::visit(
      [&](const auto& typed) {
        using Typed = std::decay_t<decltype(typed)>;
        if constexpr (std::is_same_v<Typed, cansync::ParameterRequest>) {
          rig.answer(ParameterDone{typed.id, {.value = typed.write ? typed.value : 41}});
        } else if constexpr (std::is_same_v<Typed, cansync::TransferRequest>) {
          rig.answer(TransferDone{typed.id, {}});
        } else if constexpr (requires { typed.id; }) {
          rig.answer(CommandDone{typed.id, Outcome::done});
        }
      },
      *request);
}

TEST(Audit, EachChangeHasExactlyOneEntryWithWhoWhatOldNewAndResult) {
  GatewayRig rig;
  rig.tell(in_operation());
  std::uint64_t number = 1;
  const auto entry_of = [&](std::uint64_t request) {
    const auto entries = rig.journal.wait_for("CANSYNC_REQUEST", std::to_string(request));
    EXPECT_EQ(entries.size(), 1u) << request;
    return entries.empty() ? KeptJournal::Entry{} : entries.front();
  };

  rig.client.write(parameter(number, false));
  answer_as_done(rig);
  ASSERT_TRUE(rig.client.reply<cansync_ParameterReply>(number));
  EXPECT_TRUE(rig.journal.changes().empty()) << "a read changes nothing";

  rig.client.write(parameter(++number, true, 42));
  answer_as_done(rig);
  ASSERT_TRUE(rig.client.reply<cansync_ParameterReply>(number));
  const auto write = entry_of(number);
  EXPECT_EQ(write.field("BUS"), "testbus");
  EXPECT_EQ(write.field("CLIENT"), "tester");
  EXPECT_EQ(write.field("CANSYNC_PARTICIPANT").size(), 32u);
  EXPECT_EQ(write.field("CANSYNC_ACTION"), "parameter_write");
  EXPECT_EQ(write.field("SLAVE"), "1");
  EXPECT_EQ(write.field("PARAMETER"), "100");
  EXPECT_EQ(write.field("EVENT"), "request_done");
  EXPECT_EQ(write.field("CANSYNC_WHAT"), "parameter 100");
  EXPECT_EQ(write.field("CANSYNC_OLD"), "41");
  EXPECT_EQ(write.field("CANSYNC_NEW"), "42");
  EXPECT_EQ(write.field("CANSYNC_RESULT"), "done");
  EXPECT_TRUE(write.message.starts_with(
      "parameter_write slave 1 'feeder' parameter 100 = 42 (before: 41) by 'tester'"))
      << write.message;
  EXPECT_TRUE(write.message.ends_with("(01000000): done")) << write.message;

  rig.client.write(download(++number));
  answer_as_done(rig);
  ASSERT_TRUE(rig.transfer_reply(number));
  const auto down = entry_of(number);
  EXPECT_EQ(down.field("CANSYNC_ACTION"), "download");
  EXPECT_EQ(down.field("CANSYNC_OLD"), "not known");
  EXPECT_EQ(down.field("CANSYNC_NEW"),
            "3 bytes, SHA-256 ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");

  for (const auto kind : kCommands) {
    rig.client.write(command(++number, kind));
    answer_as_done(rig);
    ASSERT_TRUE(rig.client.reply<cansync_CommandReply>(number));
    EXPECT_EQ(entry_of(number).field("CANSYNC_ACTION"), action_of(kind));
    EXPECT_EQ(entry_of(number).field("CANSYNC_RESULT"), "done");
  }
}

TEST(Audit, OldValuesAreThoseLastSet) {
  GatewayRig rig;
  rig.tell(in_operation());
  const std::pair<cansync_CommandKind, std::string_view> cases[] = {
      {cansync_COMMAND_CONTROL_WORD, "0x000F"},
      {cansync_COMMAND_POLLING, "1 slave 3, 2 automatic, maximum slave 0"},
      {cansync_COMMAND_MODE, cansync::name(cansync::State::active_master)},
      {cansync_COMMAND_REFERENCE_MAPPING, "00 00 00 00 00 00 00 00"},
  };
  std::uint64_t number = 0;
  for (const auto& [kind, old_value] : cases) {
    for (unsigned round = 0; round < 2; ++round) {
      rig.client.write(command(++number, kind));
      answer_as_done(rig);
      ASSERT_TRUE(rig.client.reply<cansync_CommandReply>(number));
    }
    EXPECT_EQ(rig.journal.with("CANSYNC_REQUEST", std::to_string(number)).front().field("CANSYNC_OLD"),
              old_value);
  }
}

TEST(Audit, AWriteWithoutAnswerLeavesTheOldValueNotKnown) {
  GatewayRig rig;
  rig.client.write(parameter(1, true, 5));
  answer_as_done(rig);
  ASSERT_TRUE(rig.client.reply<cansync_ParameterReply>(1));
  rig.client.write(parameter(2, true, 6));
  rig.answer(
      ParameterDone{rig.expect_request<cansync::ParameterRequest>().id, {.outcome = Outcome::no_answer}});
  ASSERT_TRUE(rig.client.reply<cansync_ParameterReply>(2));
  rig.client.write(parameter(3, true, 7));
  answer_as_done(rig);
  ASSERT_TRUE(rig.client.reply<cansync_ParameterReply>(3));
  const auto all = rig.journal.changes();
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(all[0].field("CANSYNC_OLD"), "not known");
  EXPECT_EQ(all[1].field("CANSYNC_OLD"), "5");
  EXPECT_EQ(all[1].field("CANSYNC_RESULT"), "no answer");
  EXPECT_EQ(all[2].field("CANSYNC_OLD"), "not known");
}

TEST(Audit, RefusedRequestsAreRecordedWithTheReasonAndAsEvents) {
  GatewayRig rig;
  auto wrong = parameter(1, true, 5);
  wrong.slave = 9;
  rig.client.write(wrong);
  ASSERT_TRUE(rig.client.reply<cansync_ParameterReply>(1));
  rig.client.write(command(2, cansync_COMMAND_MODE));
  rig.answer(Refused{rig.expect_request<ModeRequest>().id, cansync::Refusal::wrong_state});
  ASSERT_TRUE(rig.client.reply<cansync_CommandReply>(2));
  const auto all = rig.journal.changes();
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].field("SLAVE"), "9");
  EXPECT_NE(all[0].field("CANSYNC_RESULT").find("refused: slave_not_configured: slave"), std::string::npos)
      << all[0].message;
  EXPECT_NE(all[1].field("CANSYNC_RESULT").find("refused: wrong_state: state"), std::string::npos)
      << all[1].message;
  const auto event = rig.client.wait_for<gateway_Event>(
      [](const auto& e) { return std::string_view(e.code) == "request_refused"; });
  ASSERT_TRUE(event);
  EXPECT_STREQ(event->client, "tester");
  EXPECT_STREQ(event->action, "parameter_write");
  EXPECT_STREQ(event->new_value, "5");
  EXPECT_EQ(event->severity, gateway_SEVERITY_WARNING);
}

TEST(Audit, AFloodOfRefusalsIsCountedAndAcceptedRequestsAreNot) {
  GatewayRig rig;
  constexpr std::uint64_t kMany = 1000;
  for (std::uint64_t i = 1; i <= kMany; ++i) {
    auto wrong = parameter(i, true);
    wrong.slave = 9;
    rig.client.write(wrong);
    // More than may wait at once are refused unread, so that nobody knows what they would have changed.
    if (i % 50 == 0) {
      ASSERT_TRUE(rig.client.reply<cansync_ParameterReply>(i));
    }
  }
  // Every refusal is either an entry of its own or in a count.
  ASSERT_TRUE(eventually(rig.client.signal(), [&] {
    std::uint64_t told = rig.journal.with("CANSYNC_ACTION", "parameter_write").size();
    for (const auto& entry : rig.journal.all()) {
      const std::string counted = entry.field("CANSYNC_REFUSED");
      if (!counted.empty()) told += std::stoull(counted);
    }
    return told == kMany;
  }));
  EXPECT_LT(rig.journal.changes().size(), kMany);
}

}  // namespace
}  // namespace cansyncd
