#include "cansync/observe/command_watch.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "cansync/telegram/reply_payload.h"

namespace cansync::observe {
namespace {

constexpr std::uint32_t kBit15 = 0x8000;
/// Intervals.
constexpr int kAtOnce = 4;
constexpr Duration kStartUpAtMost = std::chrono::seconds(1);

auto key(const ParameterUse& use) {
  return std::tuple(use.slave.value(), use.sub_slave.value, use.number.value(), use.element.value());
}

auto key(const ParameterCommand& command) {
  return std::tuple(command.slave.value(), command.sub_slave.value, command.number.value(),
                    command.element.value());
}

}  // namespace

std::optional<std::size_t> add_step(Observation& out, Step step) {
  if (!out.steps.empty()) {
    Step& last = out.steps.back();
    const auto* action = std::get_if<ActionStep>(&step.what);
    const auto* before = std::get_if<ActionStep>(&last.what);
    if (action != nullptr && before != nullptr && action->action == before->action &&
        step.in_operation == last.in_operation) {
      ++last.count;
      return out.steps.size() - 1;
    }
  }
  if (out.steps.size() >= kMostSteps) {
    ++out.steps_over;
    return std::nullopt;
  }
  out.steps.push_back(std::move(step));
  return out.steps.size() - 1;
}

bool CommandWatch::starting_up(Duration since_first) const noexcept {
  return !out_.first_reference || (out_.start_up_until && since_first < *out_.start_up_until);
}

void CommandWatch::action(const ActionCommand& action, const OnBus& when) {
  // A master that waits for nobody gives reference values at once.
  if (action.command != kCommandControlWord && out_.first_reference && !out_.start_up_until &&
      when.since_first < *out_.first_reference + kAtOnce * times_.interval)
    out_.start_up_until = when.since_first + kStartUpAtMost;
  add_step(out_, {when.since_first, out_.first_reference.has_value(), 1, ActionStep{action}});
}

/// Whether the command before was answered.
void CommandWatch::settle(Asked& asked, SlaveNumber slave) {
  if (!asked.telegram || asked.answered) return;
  ++out_.slave[slave.value()].unanswered;
  const auto* command = std::get_if<ParameterCommand>(&*asked.telegram);
  if (command == nullptr || command->kind == ParameterCommand::Kind::read) return;
  if (asked.step) std::get<WriteStep>(out_.steps[*asked.step].what).end = StepEnd::unanswered;
  asked.lost_write = LostWrite{*command, asked.step, 0};
}

/// True when `command` is the write that was not answered; after some other commands it counts as given up.
bool CommandWatch::sent_again(Asked& asked, const ParameterCommand* command) {
  if (!asked.lost_write) return false;
  if (command != nullptr && *command == asked.lost_write->command) {
    ++out_.writes_repeated;
    asked.step = asked.lost_write->step;
    asked.lost_write.reset();
    return true;
  }
  if (++asked.lost_write->commands >= kCommandsUntilGivenUp) {
    ++out_.writes_not_repeated;
    asked.lost_write.reset();
  }
  return false;
}

void CommandWatch::command(SlaveNumber slave, const Telegram& telegram, const OnBus& when) {
  Asked& asked = asked_[slave.value()];
  settle(asked, slave);
  const auto* wanted = std::get_if<ParameterCommand>(&telegram);
  const bool repeated = asked.telegram && *asked.telegram == telegram && (!asked.answered || asked.busy);
  const bool again = sent_again(asked, wanted) || repeated;
  ++out_.slave[slave.value()].commands;
  // Reads may be of status words, and cancel telegrams wait for no turn.
  const bool job = wanted == nullptr ? telegram != Telegram(cancel_transfer(slave))
                                     : wanted->kind != ParameterCommand::Kind::read;
  if (job && out_.first_reference && when.at.known && out_.served.size() < kMostServed)
    out_.served.push_back({when.at.interval, slave});
  asked.telegram = telegram;
  asked.end = when.end;
  asked.answered = asked.busy = false;
  if (wanted != nullptr) return parameter(asked, *wanted, again, when);
  transfers_.command(telegram, again, when.since_first, when.at);
}

void CommandWatch::parameter(Asked& asked, const ParameterCommand& command, bool again, const OnBus& when) {
  asked.parameter = place_of(command);
  const bool read = command.kind == ParameterCommand::Kind::read;
  if (asked.parameter != kNowhere) {
    ParameterUse& use = out_.parameters[asked.parameter];
    if (!use.asked) use.asked = when.since_first;
    if (read && starting_up(when.since_first)) ++use.set_up_reads;
    ReadTimes& times = read_times_[asked.parameter];
    if (read) use.last_read = when.since_first;
    // Until the slave is synchronized it is asked more often.
    if ((use.value & kBit15) == 0) times.last.reset();
    if (read && !again && out_.first_reference && when.at.known && (use.value & kBit15) != 0) {
      if (times.last && times.apart.size() < kMostApart)
        times.apart.push_back(static_cast<std::uint32_t>(when.at.interval - *times.last));
      times.last = when.at.interval;
    }
  }
  if (again) return;
  asked.step.reset();
  if (!read)
    asked.step =
        add_step(out_, {when.since_first, out_.first_reference.has_value(), 1, WriteStep{command, {}, {}}});
}

std::size_t CommandWatch::place_of(const ParameterCommand& command) {
  const auto at =
      std::lower_bound(out_.parameters.begin(), out_.parameters.end(), key(command),
                       [](const ParameterUse& use, const auto& wanted) { return key(use) < wanted; });
  const auto place = static_cast<std::size_t>(at - out_.parameters.begin());
  if (at != out_.parameters.end() && key(*at) == key(command)) return place;
  if (out_.parameters.size() >= kMostParameters) {
    ++out_.parameters_over;
    return kNowhere;
  }
  ParameterUse use;
  use.slave = command.slave;
  use.sub_slave = command.sub_slave;
  use.number = command.number;
  use.element = command.element;
  out_.parameters.insert(at, use);
  read_times_.insert(read_times_.begin() + static_cast<std::ptrdiff_t>(place), ReadTimes{});
  for (Asked& other : asked_)
    if (other.parameter != kNowhere && other.parameter >= place) ++other.parameter;
  return place;
}

void CommandWatch::answered(Asked& asked, SlaveUse& use, const OnBus& when, bool busy,
                            bool error) const noexcept {
  asked.answered = true;
  asked.busy = busy;
  ++use.answers;
  if (busy) ++use.busy;
  if (error) ++use.refused;
  const Duration time = std::max(when.start - asked.end, Duration{0});
  ResponseUse& response = use.response;
  response.shortest = response.count == 0 ? time : std::min(response.shortest, time);
  response.longest = std::max(response.longest, time);
  response.sum += time;
  ++response.count;
  if (time > times_.response_timeout) ++response.slow;
}

void CommandWatch::took_value(ParameterUse& use, std::uint32_t value, bool doubleword,
                              const OnBus& when) const noexcept {
  const bool first = use.reads++ == 0;
  if (starting_up(when.since_first)) {
    if (!first && (use.set_up_value & kBit15) == 0 && (value & kBit15) != 0) use.bit_15_rose = true;
    if (!first && (use.set_up_value & kBit15) != 0 && (value & kBit15) == 0) use.bit_15_fell = true;
    use.set_up_value = value;
    use.answered_in_set_up = true;
  }
  use.least = first ? value : std::min(use.least, value);
  use.most = first ? value : std::max(use.most, value);
  use.value = value;
  use.written_last = false;
  use.doubleword = doubleword;
}

void CommandWatch::reply(const ParameterReply& reply, const OnBus& when) {
  Asked& asked = asked_[reply.slave.value()];
  SlaveUse& slave = out_.slave[reply.slave.value()];
  const auto* command = asked.telegram ? std::get_if<ParameterCommand>(&*asked.telegram) : nullptr;
  if (command == nullptr || asked.answered || command->number != reply.number) {
    ++slave.stray;
    return;
  }
  answered(asked, slave, when, reply.busy, reply.error && !reply.busy);
  if (reply.busy) return;
  ParameterUse* use = asked.parameter == kNowhere ? nullptr : &out_.parameters[asked.parameter];
  WriteStep* write = asked.step ? &std::get<WriteStep>(out_.steps[*asked.step].what) : nullptr;
  if (reply.error) {
    const auto told = error_answer(reply);
    const ParameterError error = told ? told->error : ParameterError::unspecified;
    if (use != nullptr) ++use->refused, use->error = error;
    if (write != nullptr) write->end = StepEnd::refused, write->error = error;
    return;
  }
  if (command->kind == ParameterCommand::Kind::read) {
    const auto answer = read_answer(reply);
    if (answer && use != nullptr) took_value(*use, answer->value, answer->doubleword, when);
    return;
  }
  if (write != nullptr) write->end = StepEnd::done;
  if (use != nullptr) {
    ++use->writes;
    use->written = command->value;
    use->written_last = true;
    use->doubleword = command->kind == ParameterCommand::Kind::write_doubleword;
  }
}

void CommandWatch::reply(const TransferReply& reply, const OnBus& when) {
  Asked& asked = asked_[reply.slave.value()];
  SlaveUse& slave = out_.slave[reply.slave.value()];
  if (!asked.telegram || asked.answered || std::holds_alternative<ParameterCommand>(*asked.telegram)) {
    ++slave.stray;
    return;
  }
  answered(asked, slave, when, reply.busy, reply.error && !reply.busy);
  if (!reply.busy) transfers_.reply(*asked.telegram, reply);
}

void CommandWatch::finish() {
  for (std::size_t i = 0; i < read_times_.size(); ++i) {
    auto& apart = read_times_[i].apart;
    std::sort(apart.begin(), apart.end());
    std::uint64_t row = 0;
    for (std::size_t k = 0; k < apart.size(); ++k) {
      row = k > 0 && apart[k] == apart[k - 1] ? row + 1 : 1;
      if (row <= out_.parameters[i].periods) continue;
      out_.parameters[i].periods = row;
      out_.parameters[i].period = apart[k];
    }
  }
}

}  // namespace cansync::observe
