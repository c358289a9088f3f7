#include <gtest/gtest.h>

#include <functional>
#include <set>

#include "daemon/access.h"
#include "gateway_rig.h"

/// Who may change what, and what is written down of it.
namespace cansyncd {
namespace {

using cansync::Outcome;

constexpr std::uint8_t kElementValue = 7;

cansync_ParameterRequest parameter(std::uint64_t number, bool write, std::uint32_t value = 0) {
  auto request = TestClient::request<cansync_ParameterRequest>(number);
  request.write = write;
  request.slave = 1;
  request.number = 100;
  request.element = kElementValue;
  request.format = cansync_FORMAT_AS_SLAVE_SAYS;
  request.value = value;
  return request;
}

cansync_TransferRequest upload(std::uint64_t number) {
  auto request = TestClient::request<cansync_TransferRequest>(number);
  request.slave = 1;
  request.address = 0x1000;
  request.length = 4;
  return request;
}

std::array<std::uint8_t, 3> abc = {'a', 'b', 'c'};

cansync_TransferRequest download(std::uint64_t number) {
  auto request = upload(number);
  request.direction = cansync_DIRECTION_DOWNLOAD;
  request.length = abc.size();
  request.data = {static_cast<std::uint32_t>(abc.size()), static_cast<std::uint32_t>(abc.size()), abc.data(),
                  false};
  return request;
}

constexpr cansync_CommandKind kCommands[] = {
    cansync_COMMAND_CONTROL_WORD,   cansync_COMMAND_BROADCAST,       cansync_COMMAND_MODE,
    cansync_COMMAND_POLLING,        cansync_COMMAND_CHANNEL_CURSORS, cansync_COMMAND_REFERENCE_MAPPING,
    cansync_COMMAND_ACTUAL_MAPPING, cansync_COMMAND_RELEASE};

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

cansync_Command command(std::uint64_t number, cansync_CommandKind kind) {
  auto sample = TestClient::request<cansync_Command>(number);
  sample.kind = kind;
  sample.slave = 2;
  sample.control_word = 0x000F;
  sample.priority = 1;
  sample.slave_mask = 0xF;
  sample.action = 128;
  sample.polling_one = 3;
  sample.polling_two = -2;
  sample.maximum_slave = -2;
  sample.cursor_control_word = -128;
  sample.cursor_parameter = -2;
  sample.cursor_transfer = -2;
  return sample;
}

MasterSnapshot in_operation() {
  MasterSnapshot master;
  master.state = cansync::State::active_master;
  return master;
}

Config read_only_config() {
  Config config = gateway_config();
  config.access.read_only = true;
  return config;
}

// --- rights

/// Every kind of request, told apart: one alternative of the variant that is missing fails the count.
TEST(Access, EveryKindOfRequestHasItsRight) {
  cansync::ParameterRequest read;
  cansync::ParameterRequest write;
  write.write = true;
  cansync::TransferRequest up;
  up.direction = cansync::TransferRequest::Direction::upload;
  cansync::TransferRequest down;
  down.direction = cansync::TransferRequest::Direction::download;
  struct Case {
    Request request;
    Right right;
    bool changes;
  };
  const Case cases[] = {
      {read, Right::engineer, false},
      {write, Right::engineer, true},
      {up, Right::engineer, false},
      {down, Right::engineer, true},
      {cansync::ControlWordRequest{}, Right::operate, true},
      {cansync::BroadcastRequest{}, Right::operate, true},
      {cansync::ReferenceUpdate{}, Right::operate, true},
      {Cancel{}, Right::operate, false},
      {StopRelease{}, Right::operate, false},
      {ModeRequest{}, Right::engineer, true},
      {SetPolling{}, Right::engineer, true},
      {SetCursors{}, Right::engineer, true},
      {SetReferenceMapping{}, Right::engineer, true},
      {SetActualMapping{}, Right::engineer, true},
      {ReleaseSlave{}, Right::engineer, true},
  };
  Config open = gateway_config();
  const Config closed = read_only_config();
  std::set<std::size_t> kinds;
  for (const Case& c : cases) {
    kinds.insert(c.request.index());
    EXPECT_EQ(needed_right(c.request), c.right) << c.request.index();
    EXPECT_EQ(changes_something(c.request), c.changes) << c.request.index();
    EXPECT_FALSE(read_only_refusal(c.request, open));
    EXPECT_EQ(read_only_refusal(c.request, closed).has_value(), c.changes) << c.request.index();
  }
  EXPECT_EQ(kinds.size(), std::variant_size_v<Request>);
}

// --- read-only

TEST(ReadOnly, WritesDownloadsAndEveryCommandAreRefusedAndReadsAndUploadsGoOn) {
  GatewayRig rig(read_only_config());
  rig.tell(in_operation());
  std::uint64_t number = 1;
  const auto expect_refused = [](const auto& reply) {
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->code, cansync_REPLY_REFUSED);
    EXPECT_NE(std::string_view(reply->reason).find("access.read_only"), std::string_view::npos);
  };
  rig.client.write(parameter(number, true, 5));
  expect_refused(rig.client.reply<cansync_ParameterReply>(number++));
  rig.client.write(download(number));
  const auto transfer = rig.transfer_reply(number++);
  ASSERT_TRUE(transfer);
  EXPECT_EQ(transfer->reply.code, cansync_REPLY_REFUSED);
  for (const auto kind : kCommands) {
    rig.client.write(command(number, kind));
    expect_refused(rig.client.reply<cansync_CommandReply>(number++));
  }
  EXPECT_EQ(rig.exchange.requests.size(), 0u);
  EXPECT_EQ(rig.journal.with("CANSYNC_CLIENT", "tester").size(), number - 1) << "each refusal has its entry";

  rig.client.write(parameter(number, false));
  const auto read = rig.expect_request<cansync::ParameterRequest>();
  EXPECT_FALSE(read.write);
  rig.answer(ParameterDone{read.id, {.value = 7}});
  const auto answered = rig.client.reply<cansync_ParameterReply>(number++);
  ASSERT_TRUE(answered);
  EXPECT_EQ(answered->code, cansync_REPLY_DONE);
  rig.client.write(upload(number));
  const auto up = rig.expect_request<cansync::TransferRequest>();
  rig.answer(TransferDone{up.id, {.bytes = 4}});
  const auto uploaded = rig.transfer_reply(number);
  ASSERT_TRUE(uploaded);
  EXPECT_EQ(uploaded->reply.code, cansync_REPLY_DONE);
}

cansync_ReferenceValues reference_values(std::uint8_t telegram) {
  cansync_ReferenceValues sample = {};
  sample.telegram = telegram;
  sample.valid = 1;
  sample.release_intervals = 1000;
  return sample;
}

TEST(ReadOnly, ReferenceValuesAreRefusedWithOneEventAndStatusTellsWhy) {
  GatewayRig rig(read_only_config());
  cansync::dds::DataSignal signal;
  cansync::dds::Writer<cansync_ReferenceValues> writer(rig.client.participant(), 0, &signal);
  ASSERT_TRUE(eventually(signal, [&] { return writer.matched() > 0; }));
  ASSERT_EQ(writer.write(reference_values(1)), DDS_RETCODE_OK);
  const auto refused = rig.client.wait_for<cansync_Event>(
      [](const auto& e) { return std::string_view(e.code) == "reference_refused"; });
  ASSERT_TRUE(refused);
  EXPECT_NE(std::string_view(refused->text).find("access.read_only"), std::string_view::npos);
  EXPECT_EQ(rig.exchange.requests.size(), 0u);
  EXPECT_TRUE(rig.client.wait_for<cansync_MasterStatus>([](const auto& s) { return s.read_only; }));
}

TEST(ReadOnly, SwitchedOnByReloadItWithdrawsReferenceValuesAndSwitchedOffItTakesRequestsAgain) {
  GatewayRig rig;
  rig.gateway->reload(read_only_config());
  // Both telegrams: values given before could be released for hours.
  EXPECT_EQ(rig.expect_request<StopRelease>().channel, cansync::Channel::one);
  EXPECT_EQ(rig.expect_request<StopRelease>().channel, cansync::Channel::two);
  EXPECT_TRUE(rig.client.wait_for<cansync_MasterStatus>([](const auto& s) { return s.read_only; }));
  rig.client.write(parameter(1, true));
  const auto refused = rig.client.reply<cansync_ParameterReply>(1);
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->code, cansync_REPLY_REFUSED);

  rig.client.all<cansync_MasterStatus>().clear();
  rig.gateway->reload(gateway_config());
  EXPECT_TRUE(rig.client.wait_for<cansync_MasterStatus>([](const auto& s) { return !s.read_only; }));
  rig.client.write(parameter(2, true));
  EXPECT_TRUE(rig.expect_request<cansync::ParameterRequest>().write);
}

// --- what is written down

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
    const auto entries = rig.journal.with("CANSYNC_REQUEST", std::to_string(request));
    EXPECT_EQ(entries.size(), 1u) << request;
    return entries.empty() ? KeptJournal::Entry{} : entries.front();
  };

  rig.client.write(parameter(number, false));
  answer_as_done(rig);
  ASSERT_TRUE(rig.client.reply<cansync_ParameterReply>(number));
  EXPECT_TRUE(rig.journal.all().empty()) << "a read changes nothing";

  rig.client.write(parameter(++number, true, 42));
  answer_as_done(rig);
  ASSERT_TRUE(rig.client.reply<cansync_ParameterReply>(number));
  const auto write = entry_of(number);
  EXPECT_EQ(write.field("CANSYNC_BUS"), "testbus");
  EXPECT_EQ(write.field("CANSYNC_CLIENT"), "tester");
  EXPECT_EQ(write.field("CANSYNC_PARTICIPANT").size(), 32u);
  EXPECT_EQ(write.field("CANSYNC_ACTION"), "parameter_write");
  EXPECT_EQ(write.field("CANSYNC_SLAVE"), "1");
  EXPECT_EQ(write.field("CANSYNC_WHAT"), "parameter 100");
  EXPECT_EQ(write.field("CANSYNC_OLD"), "41");
  EXPECT_EQ(write.field("CANSYNC_NEW"), "42");
  EXPECT_EQ(write.field("CANSYNC_RESULT"), "done");
  EXPECT_NE(write.message.find("by 'tester' (01000000): done"), std::string::npos) << write.message;

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
  const auto all = rig.journal.all();
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
  const auto all = rig.journal.all();
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].field("CANSYNC_SLAVE"), "9");
  EXPECT_NE(all[0].field("CANSYNC_RESULT").find("refused: slave"), std::string::npos) << all[0].message;
  EXPECT_NE(all[1].field("CANSYNC_RESULT").find("refused: state"), std::string::npos) << all[1].message;
  const auto event = rig.client.wait_for<cansync_Event>(
      [](const auto& e) { return std::string_view(e.code) == "request_refused"; });
  ASSERT_TRUE(event);
  EXPECT_STREQ(event->client, "tester");
  EXPECT_STREQ(event->action, "parameter_write");
  EXPECT_STREQ(event->new_value, "5");
  EXPECT_EQ(event->severity, cansync_SEVERITY_WARNING);
}

TEST(Audit, AFloodOfRefusalsIsCountedAndAcceptedRequestsAreNot) {
  GatewayRig rig;
  constexpr std::uint64_t kMany = 1000;
  for (std::uint64_t i = 1; i <= kMany; ++i) {
    auto wrong = parameter(i, true);
    wrong.slave = 9;
    rig.client.write(wrong);
  }
  ASSERT_TRUE(rig.client.reply<cansync_ParameterReply>(kMany));
  // Every refusal is either an entry of its own or in a count.
  ASSERT_TRUE(eventually(rig.client.signal(), [&] {
    std::uint64_t told = rig.journal.with("CANSYNC_ACTION", "parameter_write").size();
    for (const auto& entry : rig.journal.all()) {
      const std::string counted = entry.field("CANSYNC_REFUSED");
      if (!counted.empty()) told += std::stoull(counted);
    }
    return told == kMany;
  }));
  EXPECT_LT(rig.journal.all().size(), kMany);
}

// --- the journal itself

std::vector<std::string> sent_fields;
int keep_fields(const iovec* parts, int count) {
  for (int i = 0; i < count; ++i)
    sent_fields.emplace_back(static_cast<const char*>(parts[i].iov_base), parts[i].iov_len);
  return 0;
}

TEST(JournalEntry, FieldsStayFieldsAndControlCharactersDoNotEndThem) {
  Journal journal(keep_fields);
  journal.write("written", {{"CANSYNC_CLIENT", "a\nPRIORITY=0"}, {"CANSYNC_SLAVE", "3"}});
  const std::vector<std::string> expected = {"MESSAGE=written", "PRIORITY=5", "SYSLOG_IDENTIFIER=cansyncd",
                                             "CANSYNC_CLIENT=a?PRIORITY=0", "CANSYNC_SLAVE=3"};
  EXPECT_EQ(sent_fields, expected);
}

}  // namespace
}  // namespace cansyncd
