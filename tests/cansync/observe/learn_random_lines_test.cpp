// Lines of random masters, recorded in virtual time: what is said to be seen is true, what was on the
// recording is found, and our master with what was learned makes the same telegrams in the same slots.
#include <gtest/gtest.h>

#include <bit>
#include <cstdlib>
#include <string>

#include "cansync/observe/learned.h"
#include "cansync/observe/random_line.h"
#include "cansync/settings/settings_check.h"

namespace cansync::observe {
namespace {

using support::Form;
using support::RandomLine;
using support::Recording;

/// Counts points that a recording decides, and those of them that were found.
class Judge {
 public:
  explicit Judge(std::string line) : line_(std::move(line)) {}

  /// `decided`: the recording has what it takes to tell the point.
  void point(const std::string& name, bool decided, Certainty certainty, bool right) {
    EXPECT_TRUE(certainty != Certainty::seen || right) << line_ << ": " << name << " is said to be seen";
    if (!decided) return;
    ++decided_;
    if (certainty != Certainty::not_seen && right) {
      ++found_;
    } else {
      missing_ += " " + line_ + ":" + name;
    }
  }
  template <class T>
  void value(const std::string& name, bool decided, const Found<T>& found, const T& truth) {
    point(name, decided, found.certainty, found.value == truth);
  }

  unsigned decided_ = 0;
  unsigned found_ = 0;
  std::string missing_;

 private:
  std::string line_;
};

/// What the recorded line itself says of its course.
struct Truth {
  const RandomLine& line;
  const MasterSettings& master;
  const Observation& observed;
  const Learned& learned;
};

bool on_bus(const Truth& truth, unsigned channel) {
  return truth.observed.reference[channel].count > 0;
}

bool has_words(const Truth& truth, unsigned channel) {
  const TelegramUse& use = truth.observed.reference[channel];
  return use.count > use.by_words[0];
}

bool automatic(const Truth& truth, unsigned channel) {
  return on_bus(truth, channel) && truth.master.process.polling[channel].kind == Cursor::Kind::automatic;
}

void judge_process(Judge& judge, const Truth& truth) {
  const ProcessSettings& process = truth.master.process;
  const unsigned round = process.maximum_slave.value() + 1u;
  for (unsigned c = 0; c < kChannels; ++c) {
    const std::string name = "polling " + std::to_string(c + 1);
    Cursor asks = process.polling[c];
    if (asks.kind == Cursor::Kind::automatic && round == 1) asks = {Cursor::Kind::fixed, {}};
    judge.value(name, on_bus(truth, c), truth.learned.polling[c], asks);
    const unsigned words = process.full_length ? kWords : process.reference_mapping[c].used_words();
    const bool any_words = has_words(truth, c);
    judge.point("words " + std::to_string(c + 1), any_words, Certainty::seen,
                !any_words || truth.observed.reference[c].by_words[words] > 0);
  }
  const bool rises = (automatic(truth, 0) || automatic(truth, 1)) && round > 1;
  judge.value("maximum_slave", rises, truth.learned.maximum_slave, process.maximum_slave);
  judge.value("polling_apart", automatic(truth, 0) && automatic(truth, 1) && round > 1,
              truth.learned.polling_apart, process.polling_apart);
  bool nobody = false;
  for (unsigned c = 0; c < kChannels; ++c)
    nobody = nobody || (on_bus(truth, c) && process.polling[c].kind == Cursor::Kind::nobody);
  judge.value("poll_nobody", nobody, truth.learned.poll_nobody, process.poll_nobody);
  const bool all_mapped = process.reference_mapping[0].used_words() == kWords &&
                          (!has_words(truth, 1) || process.reference_mapping[1].used_words() == kWords);
  // Four mapped words are eight bytes either way.
  judge.value("full_length", !all_mapped, truth.learned.full_length, process.full_length);
  const bool without = process.poll_without_reference &&
                       truth.line.master.references[4].kind == sim::ReferenceCurve::Kind::none;
  if (without) judge.value("poll_without_reference", true, truth.learned.poll_without_reference, true);
}

void judge_start(Judge& judge, const Truth& truth) {
  const StartupSettings& startup = truth.master.startup;
  judge.value("activation", true, truth.learned.activation,
              Activation{startup.activate_command, startup.activate_data});
  SlaveMask drives;
  for (const auto& drive : truth.line.drives) drives.set(drive.slave.number);
  judge.value("answered", true, truth.learned.answered, drives);
  judge.value("slaves", true, truth.learned.slaves, truth.master.configured());
  for (const auto& drive : truth.line.drives) {
    const unsigned number = drive.slave.number.value();
    judge.value("status_parameter", true, truth.learned.slave[number].status_parameter,
                drive.status_parameter);
  }
  // In whole intervals.
  const Duration interval = slot_times(truth.master.bit_rate).interval;
  judge.value("status_period", true, truth.learned.status_period,
              startup.status_period / interval * interval);
  if (startup.enable != EnableRule::all_responding)
    judge.value("enable", true, truth.learned.enable, startup.enable);
}

/// Writes and control words in the master's order for each slave, and the transfers.
void judge_steps(Judge& judge, const Truth& truth, bool clean) {
  for (unsigned slave = 0; slave < kSlaves && clean; ++slave) {
    std::vector<std::string> given;
    std::vector<std::string> seen;
    for (const auto& routine : truth.line.master.routines) {
      if (const auto* request = std::get_if<ParameterRequest>(&routine.request);
          request != nullptr && request->write && request->slave.value() == slave)
        given.push_back("write " + std::to_string(request->number.value()) + " " +
                        std::to_string(request->value));
    }
    for (const Step& step : truth.observed.steps) {
      if (const auto* write = std::get_if<WriteStep>(&step.what);
          write != nullptr && write->command.slave.value() == slave) {
        seen.push_back("write " + std::to_string(write->command.number.value()) + " " +
                       std::to_string(write->command.value));
        const bool there = write->command.number.value() != 1900;
        judge.point("end of a write", true, Certainty::seen,
                    write->end == (there ? StepEnd::done : StepEnd::refused));
      }
    }
    if (!given.empty() || !seen.empty()) judge.point("writes", true, Certainty::seen, given == seen);
  }
  std::vector<std::uint32_t> words;
  std::vector<std::uint32_t> words_seen;
  for (const auto& routine : truth.line.master.routines)
    if (const auto* request = std::get_if<ControlWordRequest>(&routine.request))
      words.push_back(request->control_word | (1u << request->slave.value() << 16));
  for (const Step& step : truth.observed.steps)
    if (const auto* action = std::get_if<ActionStep>(&step.what);
        action != nullptr && action->action.command == kCommandControlWord)
      for (std::uint64_t i = 0; i < step.count; ++i)
        words_seen.push_back(action->action.data_word | (action->action.slaves.bits << 16));
  if (clean) judge.point("control words", true, Certainty::seen, words == words_seen);
}

void judge_transfers(Judge& judge, const Truth& truth) {
  const CommandChannelSettings& channel = truth.master.command_channel;
  std::size_t seen = 0;
  bool continued = false;
  bool low = false;
  std::vector<const TransferStep*> steps;
  for (const Step& step : truth.observed.steps)
    if (const auto* transfer = std::get_if<TransferStep>(&step.what)) steps.push_back(transfer);
  for (const auto& routine : truth.line.master.routines) {
    const auto* request = std::get_if<TransferRequest>(&routine.request);
    if (request == nullptr) continue;
    const auto fits = [&](const TransferStep* step) {
      return step->slave == request->slave && step->direction == request->direction &&
             step->address == request->address && step->bytes == request->data.size();
    };
    const bool is_low = request->address < 0x100;
    const auto at = std::find_if(steps.begin(), steps.end(), fits);
    judge.point("transfer", true, at != steps.end() ? Certainty::seen : Certainty::not_seen,
                at != steps.end());
    low = low || is_low;
    if (at == steps.end() || is_low) continue;
    ++seen;
    const bool download = request->direction == TransferInitialise::Direction::download;
    judge.point("transfer's data", true, Certainty::seen,
                (*at)->end == StepEnd::done && (*at)->whole &&
                    (!download || std::equal(request->data.begin(), request->data.end(), (*at)->data.begin(),
                                             (*at)->data.end())));
    const unsigned number = request->slave.value();
    const std::uint16_t limit = truth.master.slaves[number].block_limit;
    const bool more = request->data.size() > limit;
    continued = continued || more;
    if (more) judge.value("block_limit", true, truth.learned.slave[number].block_limit, limit);
    steps.erase(at);
  }
  judge.value("address_step", continued, truth.learned.address_step, channel.address_step);
  judge.value("cancel_at_start", true, truth.learned.cancel_at_start, channel.cancel_at_start);
  if (low) judge.value("allow_reserved_addresses", true, truth.learned.allow_reserved_addresses, true);
  const bool order = truth.learned.maximum_slave.known() && truth.master.process.maximum_slave.value() > 0 &&
                     truth.observed.served.size() >= 20;
  judge.value("serving", order, truth.learned.serving, channel.serving);
}

/// Where frames were lost, what is said to be seen must be true all the same.
void judge_seen(Judge& judge, const Truth& truth) {
  const StartupSettings& startup = truth.master.startup;
  const CommandChannelSettings& channel = truth.master.command_channel;
  const Learned& learned = truth.learned;
  judge.value("activation", false, learned.activation,
              Activation{startup.activate_command, startup.activate_data});
  SlaveMask drives;
  for (const auto& drive : truth.line.drives) {
    drives.set(drive.slave.number);
    judge.value("status_parameter", false, learned.slave[drive.slave.number.value()].status_parameter,
                drive.status_parameter);
  }
  judge.point("answered", false, learned.answered.certainty,
              (learned.answered.value.bits & ~drives.bits) == 0);
  judge.value("address_step", false, learned.address_step, channel.address_step);
  judge.value("cancel_at_start", false, learned.cancel_at_start, channel.cancel_at_start);
}

void judge_recording(Judge& judge, const RandomLine& line, const Observation& observed,
                     const Learned& learned, Form form) {
  const Truth truth{line, line.master.master, observed, learned};
  const bool clean = line.faults.empty();
  judge.value("bit_rate", true, learned.bit_rate, line.master.master.bit_rate);
  judge.value("interval", true, learned.interval, slot_times(line.master.master.bit_rate).interval);
  if (form != Form::without_sync) {
    const Duration off = learned.send_margin.value - line.master.master.send_margin;
    judge.point("send_margin", true, learned.send_margin.certainty,
                off >= std::chrono::microseconds(-2) && off <= std::chrono::microseconds(2));
  }
  judge_process(judge, truth);
  if (!clean) return judge_seen(judge, truth);
  judge_start(judge, truth);
  judge_steps(judge, truth, clean);
  judge_transfers(judge, truth);
}

/// Frames by interval, to be laid side by side.
struct Placed {
  std::uint64_t interval = 0;
  Duration after_edge{};
  can::Frame frame;
};

std::vector<Placed> placed(const Recording& recording) {
  std::vector<Placed> out;
  std::uint64_t interval = 0;
  Duration edge{};
  for (const auto& entry : recording.entries) {
    if (!entry.frame) {
      ++interval;
      edge = entry.start;
    } else {
      out.push_back({interval, entry.start - edge, *entry.frame});
    }
  }
  return out;
}

bool is_value(const can::Frame& frame) {
  return frame.id != identifier::action && identifier::channel_of(frame.id) < identifier::command;
}

/// Our master with what was learned, on the same drives with the same jobs.
void expect_same_telegrams(const RandomLine& line, const Recording& before, const Learned& learned,
                           const Observation& observed) {
  sim::MasterNodeSettings again = line.master;
  again.master = settings_of(learned);
  ASSERT_TRUE(check(again.master).empty()) << check(again.master).front().field;
  // What no frame can tell: where counters stood that nothing is seen of.
  const MasterSettings& own = line.master.master;
  if (!learned.serving.known()) again.master.command_channel.serving = own.command_channel.serving;
  if (!learned.polling_apart.known()) again.master.process.polling_apart = own.process.polling_apart;
  if (!learned.maximum_slave.known()) again.master.process.maximum_slave = own.process.maximum_slave;
  // Ours asks in addition who else is there.
  again.master.startup.census = own.startup.census;
  again.references = {};
  for (unsigned c = 0; c < kChannels; ++c) {
    const TelegramUse& use = observed.reference[c];
    if (use.count > use.by_words[0]) again.references[c * 4] = {sim::ReferenceCurve::Kind::constant, 7};
  }
  const auto first = placed(before);
  const auto second = placed(record(line, again));
  const Duration tolerance = 40 * slot_times(line.master.master.bit_rate).bit_time();
  // What begins at the end of a recording may stand on one of them alone.
  ASSERT_GT(first.size(), 100u);
  const std::size_t last = std::max(first.size(), second.size()) - 3;
  for (std::size_t i = 0; i < last; ++i) {
    ASSERT_LT(i, first.size());
    ASSERT_LT(i, second.size());
    const std::string where =
        "frame " + std::to_string(i) + ", interval " + std::to_string(first[i].interval);
    ASSERT_EQ(first[i].frame.id, second[i].frame.id) << where;
    ASSERT_EQ(first[i].interval, second[i].interval) << where;
    ASSERT_EQ(first[i].frame.dlc, second[i].frame.dlc) << where << " id " << first[i].frame.id;
    ASSERT_LE(std::chrono::abs(first[i].after_edge - second[i].after_edge), tolerance) << where;
    // Values and what slaves answer of them are put aside.
    const bool answer = identifier::channel_of(first[i].frame.id) == identifier::response;
    if (!is_value(first[i].frame) && !answer) {
      ASSERT_EQ(first[i].frame.data, second[i].frame.data) << where;
    }
  }
}

/// CANSYNC_LEARN_LINES=1000 tells how many lines, and what was not found.
const char* lines_asked_for() {
  return std::getenv("CANSYNC_LEARN_LINES");  // NOLINT(concurrency-mt-unsafe): one thread
}

unsigned lines_wanted() {
  const char* wanted = lines_asked_for();
  return wanted == nullptr ? 200 : static_cast<unsigned>(std::strtoul(wanted, nullptr, 10));
}

TEST(LearnRandomLines, ARecordingThatBeginsInOperationSaysNothingWrong) {
  for (unsigned seed = 1; seed <= lines_wanted(); ++seed) {
    SCOPED_TRACE("line " + std::to_string(seed));
    const RandomLine line = support::random_line(seed, seed % 4 == 0);
    Recording recording = record(line, line.master);
    const auto from = recording.entries.begin() + static_cast<std::ptrdiff_t>(recording.entries.size() / 2);
    recording.entries.erase(recording.entries.begin(), from);
    const Observation observed = observe_recording(recording, Form::ends);
    const Learned learned = learn(observed);
    const Truth truth{line, line.master.master, observed, learned};
    Judge judge(std::to_string(seed));
    judge.value("bit_rate", true, learned.bit_rate, line.master.master.bit_rate);
    judge_process(judge, truth);
    judge_seen(judge, truth);
    EXPECT_EQ(judge.found_, judge.decided_) << judge.missing_;
  }
}

TEST(LearnRandomLines, WhatIsSaidIsTrueAndOurMasterDoesTheSame) {
  Judge all("all");
  for (unsigned seed = 1; seed <= lines_wanted(); ++seed) {
    const RandomLine line = support::random_line(seed, seed % 4 == 0);
    ASSERT_TRUE(check(line.master.master).empty()) << seed << check(line.master.master).front().field;
    const Recording recording = record(line, line.master);
    for (const Form form : {Form::starts, Form::ends, Form::without_sync}) {
      SCOPED_TRACE("line " + std::to_string(seed) + ", form " + std::to_string(static_cast<int>(form)));
      const Observation observed = observe_recording(recording, form);
      const Learned learned = learn(observed);
      Judge judge(std::to_string(seed));
      judge_recording(judge, line, observed, learned, form);
      all.decided_ += judge.decided_;
      all.found_ += judge.found_;
      all.missing_ += judge.missing_;
      if (form == Form::starts && line.faults.empty())
        expect_same_telegrams(line, recording, learned, observed);
    }
  }
  RecordProperty("points", static_cast<int>(all.decided_));
  RecordProperty("found", static_cast<int>(all.found_));
  EXPECT_GE(all.found_ * 100, all.decided_ * 95) << all.missing_;
  EXPECT_GT(all.decided_, 20 * lines_wanted());
  if (lines_asked_for() != nullptr)
    std::printf("%u of %u points found; not found:%s\n", all.found_, all.decided_, all.missing_.c_str());
}

}  // namespace
}  // namespace cansync::observe
