// Every kind of wrong frame that can come from the bus: it is counted by its kind, nothing goes on the bus
// because of it, and no job ends otherwise.
#include "cansync/supervision/strays.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <numeric>
#include <string>
#include <vector>

#include "master_rig.h"

namespace cansync::test {
namespace {

/// When a wrong frame comes.
enum class Moment { while_asked, when_nobody_is_asked };

struct BadFrame {
  std::string kind;
  can::Frame frame;
  Moment moment = Moment::while_asked;
  std::function<std::uint64_t(const MasterCounters&)> counter;
};

void PrintTo(const BadFrame& bad, std::ostream* out) {
  *out << bad.kind;
}

can::Frame frame(std::uint32_t id, std::uint8_t dlc, std::array<std::uint8_t, 8> data = {}) {
  return {.id = id, .dlc = dlc, .data = data};
}
can::Frame extended(can::Frame frame) {
  frame.extended = true;
  return frame;
}
can::Frame remote(can::Frame frame) {
  frame.remote = true;
  return frame;
}
can::Frame error(can::Frame frame) {
  frame.error = true;
  return frame;
}

auto rejected(DecodeError error) {
  return [error](const MasterCounters& counters) { return counters.rejected[static_cast<unsigned>(error)]; };
}
auto unexpected(Unexpected kind) {
  return [kind](const MasterCounters& counters) {
    return counters.unexpected_by_kind[static_cast<unsigned>(kind)];
  };
}

/// All that can be seen of a run: what was sent in each interval, and how the jobs ended.
struct Seen {
  std::vector<std::vector<Telegram>> sent;
  std::map<JobId, ParameterResult> parameters;
  std::map<JobId, TransferResult> transfers;
  std::vector<std::uint8_t> uploaded;
  MasterCounters counters;
};

constexpr unsigned kIntervals = 60;

Telegram answer_transfer(const Telegram& telegram) {
  if (const auto* begin = std::get_if<TransferInitialise>(&telegram))
    return TransferReply{begin->slave, begin->length, false, false, 0, {}};
  const auto& block = std::get<UploadBlock>(telegram);
  const auto byte = static_cast<std::uint8_t>(block.offset.value());
  return TransferReply{block.slave, block.offset, false, false, 6, {byte, 1, 2, 3, 4, 5}};
}

std::optional<Telegram> answer_all(const Telegram& telegram) {
  if (const auto* reference = std::get_if<ReferenceTelegram>(&telegram))
    return ActualTelegram{reference->channel, slave(reference->polled), 4, {1, 2, 3, 4}};
  if (const auto* command = std::get_if<ParameterCommand>(&telegram)) {
    if (command->kind != ParameterCommand::Kind::read) return MasterRig::written_reply(*command);
    return MasterRig::word_reply(*command, command->number.value() == 301 ? 0x8000 : 0x1234);
  }
  if (std::holds_alternative<ActionCommand>(telegram)) return std::nullopt;
  return answer_transfer(telegram);
}

/// A line at work: reference values, reads, writes and an upload; `bad` comes each time its moment is there.
Seen run(const BadFrame* bad) {
  MasterRig rig(settings_for(3));
  const auto disturb = [&](Moment moment) {
    if (bad != nullptr && bad->moment == moment)
      rig.master.receive(bad->frame, std::chrono::microseconds(300));
  };
  Seen seen;
  seen.uploaded.resize(40);
  rig.answer = answer_all;
  rig.activate();
  rig.answer = [&](const Telegram& telegram) {
    // The answer to the last command has been taken when the first reference telegram goes out.
    const bool reference = std::holds_alternative<ReferenceTelegram>(telegram);
    if (!std::holds_alternative<ActionCommand>(telegram))
      disturb(reference ? Moment::when_nobody_is_asked : Moment::while_asked);
    return answer_all(telegram);
  };
  EXPECT_EQ(rig.master.submit(ReferenceUpdate{Channel::one, {5, 6, 7, 8}, 15, 0, 1000}), Refusal::none);
  for (JobId id = 1; id <= 6; ++id) {
    ParameterRequest request{
        .id = id, .slave = slave(static_cast<unsigned>(id % 3)), .number = parameter(100)};
    request.write = id % 2 == 0;
    request.format = ParameterFormat::word;
    EXPECT_EQ(rig.master.submit(request), Refusal::none);
  }
  TransferRequest upload{.id = 7, .slave = slave(1), .address = 0x1000};
  upload.data = seen.uploaded;
  EXPECT_EQ(rig.master.submit(upload), Refusal::none);
  for (unsigned i = 0; i < kIntervals; ++i) {
    rig.step();
    seen.sent.push_back(rig.sent);
  }
  seen.parameters = rig.told.parameters;
  seen.transfers = rig.told.transfers;
  seen.counters = rig.master.counters();
  return seen;
}

std::uint64_t sum(const auto& counters) {
  return std::accumulate(counters.begin(), counters.end(), std::uint64_t{0});
}

class BadFrames : public testing::TestWithParam<BadFrame> {};

TEST_P(BadFrames, IsCountedByItsKindAndChangesNothing) {
  const Seen quiet = run(nullptr);
  ASSERT_EQ(quiet.parameters.size(), 6u);
  ASSERT_EQ(quiet.transfers.size(), 1u);
  ASSERT_EQ(quiet.counters.unexpected + sum(quiet.counters.rejected), 0u);

  const Seen seen = run(&GetParam());
  EXPECT_EQ(seen.sent, quiet.sent) << "nothing more, less or else on the bus";
  ASSERT_EQ(seen.parameters.size(), 6u);
  for (const auto& [id, result] : seen.parameters) {
    EXPECT_EQ(result.outcome, Outcome::done) << id;
    EXPECT_EQ(result.value, quiet.parameters.at(id).value) << id;
    EXPECT_EQ(result.intervals, quiet.parameters.at(id).intervals) << id;
  }
  ASSERT_EQ(seen.transfers.size(), 1u);
  EXPECT_EQ(seen.transfers.at(7).outcome, Outcome::done);
  EXPECT_EQ(seen.transfers.at(7).intervals, quiet.transfers.at(7).intervals);
  EXPECT_EQ(seen.uploaded, quiet.uploaded);

  const std::uint64_t counted = GetParam().counter(seen.counters);
  EXPECT_GT(counted, 10u);
  EXPECT_EQ(sum(seen.counters.rejected) + seen.counters.unexpected, counted) << "as one kind alone";
  EXPECT_EQ(sum(seen.counters.unexpected_by_kind), seen.counters.unexpected);
}

constexpr auto kOther = Moment::when_nobody_is_asked;
constexpr can::Frame kAnswer100 = {.id = 0x581, .dlc = 6, .data = {0x00, 100, 1, 2}};

INSTANTIATE_TEST_SUITE_P(
    Rejected, BadFrames,
    testing::Values(BadFrame{"foreign", frame(0x700, 8), kOther, rejected(DecodeError::not_for_us)},
                    BadFrame{"foreign_extended", extended(frame(0x18DAF110, 8)), kOther,
                             rejected(DecodeError::not_for_us)},
                    BadFrame{"extended", extended(frame(0x581, 6, kAnswer100.data)), Moment::while_asked,
                             rejected(DecodeError::extended)},
                    BadFrame{"remote", remote(frame(0x301, 0)), kOther, rejected(DecodeError::remote)},
                    BadFrame{"remote_while_asked", remote(frame(0x581, 0)), Moment::while_asked,
                             rejected(DecodeError::remote)},
                    BadFrame{"extended_remote", extended(remote(frame(0x581, 0))), Moment::while_asked,
                             rejected(DecodeError::remote)},
                    BadFrame{"error_frame", error(frame(0x580, 8)), Moment::while_asked,
                             rejected(DecodeError::error_frame)},
                    BadFrame{"slave_number", frame(0x5A0, 6, kAnswer100.data), Moment::while_asked,
                             rejected(DecodeError::wrong_slave)},
                    BadFrame{"actual_slave_number", frame(0x320, 8), kOther,
                             rejected(DecodeError::wrong_slave)},
                    BadFrame{"answer_of_one_byte", frame(0x581, 1, {3}), Moment::while_asked,
                             rejected(DecodeError::wrong_length)},
                    BadFrame{"answer_of_odd_length", frame(0x581, 5, kAnswer100.data), Moment::while_asked,
                             rejected(DecodeError::wrong_length)},
                    BadFrame{"length_over_8", frame(0x581, 15, kAnswer100.data), Moment::while_asked,
                             rejected(DecodeError::wrong_length)},
                    BadFrame{"actual_values_of_odd_length", frame(0x301, 3), kOther,
                             rejected(DecodeError::wrong_length)}),
    [](const auto& of) { return of.param.kind; });

INSTANTIATE_TEST_SUITE_P(Unexpected, BadFrames,
                         testing::Values(BadFrame{"other_number", frame(0x581, 6, {0x00, 99, 1, 2}), kOther,
                                                  unexpected(Unexpected::unasked)},
                                         BadFrame{"slave_that_is_not_there", frame(0x59F, 6, kAnswer100.data),
                                                  Moment::while_asked, unexpected(Unexpected::wrong_slave)},
                                         BadFrame{"actual_values_unasked", frame(0x381, 8), kOther,
                                                  unexpected(Unexpected::unasked)},
                                         BadFrame{"block_unasked",
                                                  frame(0x581, 8, {0x80, 6, 9, 9, 9, 9, 9, 9}), kOther,
                                                  unexpected(Unexpected::unasked)}),
                         [](const auto& of) { return of.param.kind; });

// --- kinds that depend on what was before

class Answers : public testing::Test {
 protected:
  MasterRig rig{settings_for(3)};

  void SetUp() override {
    rig.answer = answer_all;
    rig.activate();
  }
  void receive(const Telegram& telegram) {
    rig.master.receive(encode(telegram), std::chrono::microseconds(300));
  }
  std::uint64_t count(Unexpected kind) const {
    return rig.master.counters().unexpected_by_kind[static_cast<unsigned>(kind)];
  }
  void read(JobId id, unsigned target, unsigned number) {
    ParameterRequest request{.id = id, .slave = slave(target), .number = parameter(number)};
    ASSERT_EQ(rig.master.submit(request), Refusal::none);
  }
};

TEST_F(Answers, OfAnotherNumberSlaveOrKindAreCounted) {
  read(1, 1, 100);
  rig.answer = [](const Telegram&) { return std::nullopt; };
  rig.step();
  receive(ParameterReply{slave(1), parameter(99), false, false, 4, {1}});
  receive(TransferReply{slave(1), {}, false, false, 0, {}});
  EXPECT_EQ(count(Unexpected::wrong_answer), 2u);
  receive(ParameterReply{slave(2), parameter(100), false, false, 4, {1}});
  EXPECT_EQ(count(Unexpected::wrong_slave), 1u);
  EXPECT_TRUE(rig.told.parameters.empty());
  receive(ParameterReply{slave(1), parameter(100), false, false, 4, {7}});
  EXPECT_EQ(rig.told.parameters.at(1).value, 7u);
}

TEST_F(Answers, ComingTwiceAreCountedAndTakenOnce) {
  read(1, 1, 100);
  rig.answer = [](const Telegram&) { return std::nullopt; };
  rig.step();
  for (int i = 0; i < 3; ++i) receive(ParameterReply{slave(1), parameter(100), false, false, 4, {7}});
  EXPECT_EQ(rig.told.terminal, 1u);
  EXPECT_EQ(count(Unexpected::duplicate), 2u);
  EXPECT_EQ(rig.master.counters().unexpected, 2u);
}

TEST_F(Answers, OfACancelledJobAreLate) {
  read(1, 1, 100);
  rig.answer = [](const Telegram&) { return std::nullopt; };
  rig.step();
  EXPECT_EQ(rig.master.cancel(1), Refusal::none);
  receive(ParameterReply{slave(1), parameter(100), false, false, 4, {7}});
  EXPECT_EQ(count(Unexpected::late), 1u);
  EXPECT_EQ(rig.told.parameters.at(1).outcome, Outcome::cancelled);
}

TEST_F(Answers, ComingAfterTheNextCommandAreLate) {
  ParameterRequest write{.id = 1, .write = true, .slave = slave(1), .number = parameter(100)};
  write.format = ParameterFormat::word;
  ASSERT_EQ(rig.master.submit(write), Refusal::none);
  rig.answer = [](const Telegram&) { return std::nullopt; };
  rig.step();
  read(2, 2, 200);
  rig.step();
  ASSERT_EQ(rig.told.parameters.at(1).outcome, Outcome::no_answer);
  receive(ParameterReply{slave(1), parameter(100), false, false, 2, {}});
  EXPECT_EQ(count(Unexpected::late), 1u);
  EXPECT_FALSE(rig.told.parameters.contains(2));
  EXPECT_EQ(rig.told.terminal, 1u);
}

TEST_F(Answers, ActualValuesOfTheIntervalBeforeAreLateAndTwiceAreDuplicates) {
  ASSERT_EQ(rig.master.set_polling(Channel::one, {Cursor::Kind::fixed, slave(1)}), Refusal::none);
  ASSERT_EQ(rig.master.submit(ReferenceUpdate{Channel::one, {}, 15, 0, 1000}), Refusal::none);
  rig.answer = [](const Telegram&) { return std::nullopt; };
  rig.step();  // slave 1 is asked and says nothing
  ASSERT_EQ(rig.master.set_polling(Channel::one, {Cursor::Kind::fixed, slave(2)}), Refusal::none);
  rig.step();
  const ActualTelegram late{Channel::one, slave(1), 4, {9, 9, 9, 9}};
  const std::uint64_t updates = rig.told.actual.size();
  receive(late);
  EXPECT_EQ(count(Unexpected::late), 1u);
  receive(late);
  EXPECT_EQ(count(Unexpected::wrong_slave), 1u) << "slave 2 is asked";
  EXPECT_EQ(rig.told.actual.size(), updates);
  const ActualTelegram right{Channel::one, slave(2), 4, {1, 2, 3, 4}};
  receive(right);
  receive(right);
  EXPECT_EQ(rig.told.actual.size(), updates + 1);
  EXPECT_EQ(count(Unexpected::duplicate), 1u);
}

}  // namespace
}  // namespace cansync::test
