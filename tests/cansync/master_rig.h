#pragma once

#include <gtest/gtest.h>

#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cansync/channel/jobs.h"
#include "cansync/master.h"
#include "cansync/settings/timing.h"
#include "cansync/telegram/telegram.h"

namespace cansync::test {

inline SlaveNumber slave(unsigned n) {
  return *SlaveNumber::from(n);
}
inline ParameterNumber parameter(unsigned n) {
  return *ParameterNumber::from(n);
}

/// Settings for slaves 0..count-1, ready for every test to change.
inline MasterSettings settings_for(unsigned count, BitRate rate = BitRate::mbit1) {
  MasterSettings settings;
  settings.bit_rate = rate;
  settings.process.maximum_slave = slave(count - 1);
  // The rig's slaves answer what a test is about; open_transfers_test has this switched on.
  settings.command_channel.cancel_at_start = false;
  settings.startup.census = false;  // who_is_there_test has this switched on
  for (unsigned i = 0; i < count; ++i) settings.slaves[i].configured = true;
  return settings;
}

/// Everything the master told, in order.
struct Recorder : MasterListener {
  std::vector<std::pair<SlaveNumber, ActualValues>> actual;
  std::vector<State> states;
  std::map<JobId, ParameterResult> parameters;
  std::map<JobId, TransferResult> transfers;
  std::map<JobId, Outcome> commands;
  std::vector<MasterEvent> events;
  std::vector<LimitViolation> beyond_limits;
  std::map<JobId, std::uint32_t> progress;
  std::map<unsigned, SlaveStatus> statuses;  ///< the newest of each slave
  unsigned terminal = 0;

  void actual_values(SlaveNumber number, const ActualValues& values) noexcept override {
    actual.emplace_back(number, values);
  }
  void slave_status(SlaveNumber number, const SlaveStatus& status) noexcept override {
    statuses[number.value()] = status;
  }
  void state_changed(State, State to, ControlCommand) noexcept override { states.push_back(to); }
  void parameter_done(JobId id, const ParameterResult& result) noexcept override {
    once(parameters, id, result);
  }
  void transfer_progress(JobId id, std::uint32_t bytes) noexcept override { progress[id] = bytes; }
  void transfer_done(JobId id, const TransferResult& result) noexcept override {
    once(transfers, id, result);
  }
  void command_done(JobId id, Outcome outcome) noexcept override { once(commands, id, outcome); }
  void event(const MasterEvent& event) noexcept override { events.push_back(event); }
  void reference_beyond_limit(Channel, const LimitViolation& beyond) noexcept override {
    beyond_limits.push_back(beyond);
  }

  unsigned count(MasterEvent::Code code) const {
    unsigned n = 0;
    for (const MasterEvent& event : events) n += event.code == code ? 1 : 0;
    return n;
  }

 private:
  template <class Result>
  void once(std::map<JobId, Result>& results, JobId id, const Result& result) {
    ++terminal;
    EXPECT_TRUE(results.emplace(id, result).second) << "job " << id << " ended twice";
  }
};

/// A line without a bus: runs the master interval by interval, and answers its telegrams by `answer`. Answers
/// to a command reach the master in the next interval before its command, those to a reference telegram at
/// once.
class MasterRig {
 public:
  explicit MasterRig(const MasterSettings& settings) : master(settings, told) {}

  Recorder told;
  Master master;
  /// What the slaves answer; the default reports every slave as synchronized and answers nothing else.
  std::function<std::optional<Telegram>(const Telegram&)> answer = [](const Telegram& t) {
    return status_only(t);
  };
  /// What a second drive of the same number answers to a command, right after the first.
  std::function<std::optional<Telegram>(const ParameterCommand&)> second_answer;
  /// Every telegram sent in the last interval, in slot order.
  std::vector<Telegram> sent;
  /// The next interval's command is left out.
  bool leave_out_command = false;
  /// Commands are handed over and never seen on the bus, as when nobody acknowledges.
  bool lose_echoes = false;
  IntervalNumber next_interval = 0;

  static std::optional<Telegram> status_only(const Telegram& telegram) {
    const auto* command = std::get_if<ParameterCommand>(&telegram);
    if (command == nullptr || command->kind != ParameterCommand::Kind::read ||
        command->number.value() != 301) {
      return std::nullopt;
    }
    return word_reply(*command, 0x8000);
  }

  static Telegram word_reply(const ParameterCommand& asked, std::uint16_t word) {
    ParameterReply reply{asked.slave, asked.number, false, false, 4, {}};
    store_word(reply.payload.data(), word);
    store_word(reply.payload.data() + 2, asked.sub_slave.value);
    return reply;
  }
  static Telegram doubleword_reply(const ParameterCommand& asked, std::uint32_t value) {
    ParameterReply reply{asked.slave, asked.number, false, false, 6, {}};
    store_doubleword(reply.payload.data(), value);
    store_word(reply.payload.data() + 4, asked.sub_slave.value);
    return reply;
  }
  static Telegram written_reply(const ParameterCommand& asked) {
    ParameterReply reply{asked.slave, asked.number, false, false, 2, {}};
    store_word(reply.payload.data(), asked.sub_slave.value);
    return reply;
  }
  static Telegram busy_reply(const ParameterCommand& asked) {
    return ParameterReply{asked.slave, asked.number, true, false, 0, {}};
  }
  static Telegram error_reply(const ParameterCommand& asked, ParameterError error) {
    ParameterReply reply{asked.slave, asked.number, false, true, 4, {}};
    store_word(reply.payload.data(), static_cast<std::uint16_t>(error));
    store_word(reply.payload.data() + 2, asked.sub_slave.value);
    return reply;
  }

  /// Runs one interval.
  void step() {
    sent.clear();
    master.begin_interval(next_interval++);
    for (auto* response : {&response_, &second_response_}) {
      if (*response)
        master.receive(encode(*std::exchange(*response, std::nullopt)), std::chrono::microseconds(150));
    }
    for (const Slot slot : {Slot::reference_one, Slot::reference_two, Slot::command}) run_slot(slot);
  }
  void run(unsigned intervals) {
    for (unsigned i = 0; i < intervals; ++i) step();
  }
  /// Runs until `done` or `most` intervals; returns the intervals run.
  template <class Done>
  unsigned run_until(Done done, unsigned most = 10'000) {
    unsigned n = 0;
    bool finished = done();
    for (; !finished && n < most; ++n) {
      step();
      finished = done();
    }
    EXPECT_TRUE(finished) << "not within " << most << " intervals";
    return n;
  }

  void set_up() {
    EXPECT_EQ(master.control(ControlCommand::handshake), Refusal::none);
    EXPECT_EQ(master.control(ControlCommand::take_over_initialisation), Refusal::none);
    EXPECT_EQ(master.control(ControlCommand::start_synchronous), Refusal::none);
  }
  /// Into active operation, with every status word read once, so that no supervision is due.
  void activate() {
    set_up();
    run_until([this] { return master.control(ControlCommand::enable_active) == Refusal::none; }, 200);
    response_.reset();
  }

  /// The last interval's command, if one was sent.
  const Telegram* command() const {
    if (sent.empty() || std::holds_alternative<ReferenceTelegram>(sent.back())) return nullptr;
    return &sent.back();
  }

 private:
  void run_slot(Slot slot) {
    const auto frame = master.take(slot);
    if (!frame) return;
    if (slot == Slot::command && std::exchange(leave_out_command, false)) {
      master.left_out(slot);
      return;
    }
    master.sent(slot);
    if (slot != Slot::command || !lose_echoes) {
      master.transmitted(*frame, master.planned_start(slot) + std::chrono::microseconds(100));
    }
    const Decoded decoded = decode(*frame);
    ASSERT_TRUE(std::holds_alternative<Telegram>(decoded));
    sent.push_back(std::get<Telegram>(decoded));
    const auto reply = answer(sent.back());
    if (slot != Slot::command) {
      if (reply) master.receive(encode(*reply), std::chrono::microseconds(500));
      return;
    }
    const auto* command = std::get_if<ParameterCommand>(&sent.back());
    const auto second = second_answer && command != nullptr ? second_answer(*command) : std::nullopt;
    if (is_active(master.state())) {
      response_ = reply;
      second_response_ = second;
      return;
    }
    if (reply) master.receive(encode(*reply), std::chrono::microseconds(700));
    if (second) master.receive(encode(*second), std::chrono::microseconds(800));
  }

  std::optional<Telegram> response_;
  std::optional<Telegram> second_response_;
};

}  // namespace cansync::test
