#include "mutants.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "cansync/settings/timing.h"
#include "cansync/telegram/telegram.h"

namespace cansyncd::campaign {
namespace {

bool is_command(const can::Frame& frame) noexcept {
  return (frame.id & 0x780u) == cansync::identifier::command;
}

bool is_reference(const can::Frame& frame) noexcept {
  return (frame.id & 0x700u) == cansync::identifier::reference_one;
}

/// The telegram of type T in a frame, if there is one.
template <class T>
std::optional<T> as(const can::Frame& frame) {
  const cansync::Decoded decoded = cansync::decode(frame);
  const auto* telegram = std::get_if<cansync::Telegram>(&decoded);
  const auto* typed = telegram != nullptr ? std::get_if<T>(telegram) : nullptr;
  return typed != nullptr ? std::optional(*typed) : std::nullopt;
}

// --- telegrams

/// Hands every command over when the thread has slept once more: after the slot.
class LateCommand final : public Tamper {
 public:
  can::Wake wait_until(can::Time deadline) noexcept override {
    const can::Wake wake = below().wait_until(deadline);
    if (wake == can::Wake::deadline && held_) below().send(*std::exchange(held_, std::nullopt));
    return wake;
  }
  can::SendResult send(const can::Frame& frame) noexcept override {
    if (!is_command(frame)) return below().send(frame);
    held_ = frame;
    return can::SendResult::queued;
  }

 private:
  std::optional<can::Frame> held_;
};

class DoubledCommand final : public Tamper {
 public:
  can::SendResult send(const can::Frame& frame) noexcept override {
    if (is_command(frame)) below().send(frame);
    return below().send(frame);
  }
};

class MalformedTelegram final : public Tamper {
 public:
  can::SendResult send(const can::Frame& frame) noexcept override {
    can::Frame sent = frame;
    if (is_command(frame)) sent.dlc = 5;
    return below().send(sent);
  }
};

/// Repeats the last reference values when there are no new ones.
class RepeatedReferences final : public Tamper {
 public:
  void sync_edge(can::Time due) noexcept override {
    wire().sync_edge(due);
    if (last_ && !sent_) below().send(*last_);
    sent_ = false;
  }
  can::SendResult send(const can::Frame& frame) noexcept override {
    if (is_reference(frame) && frame.dlc == 8) {
      last_ = frame;
      sent_ = true;
    }
    return below().send(frame);
  }

 private:
  std::optional<can::Frame> last_;
  bool sent_ = false;
};

/// Sends reference values before active operation.
class EarlyReferences final : public Tamper {
 public:
  void sync_edge(can::Time due) noexcept override {
    wire().sync_edge(due);
    cansync::ReferenceTelegram telegram;
    telegram.words = 0;
    if (edges_++ == 0) below().send(encode(telegram));
  }

 private:
  unsigned edges_ = 0;
};

class UncountedTelegram final : public Tamper {
 public:
  can::SendResult send(const can::Frame& frame) noexcept override {
    const can::SendResult result = below().send(frame);
    return ++sent_ % 50 == 0 ? can::SendResult::queue_full : result;
  }

 private:
  unsigned sent_ = 0;
};

class ShiftedSync final : public Tamper {
 public:
  void sync_edge(can::Time due) noexcept override {
    wire().sync_edge(++edges_ < 100 ? due : due + can::Time(1));
  }

 private:
  unsigned edges_ = 0;
};

// --- answers

class RepeatedAnswer final : public Tamper {
 public:
  void terminals(std::vector<Terminal>& popped) override {
    if (!popped.empty()) popped.push_back(popped.front());
  }
};

class LostAnswer final : public Tamper {
 public:
  void terminals(std::vector<Terminal>& popped) override {
    if (!popped.empty() && !std::exchange(lost_, true)) popped.pop_back();
  }

 private:
  bool lost_ = false;
};

/// Says of a write without an answer that it is done.
class InventedConfirmation final : public Tamper {
 public:
  void terminals(std::vector<Terminal>& popped) override {
    for (Terminal& terminal : popped) {
      auto* done = std::get_if<ParameterDone>(&terminal);
      if (done != nullptr && done->result.outcome == cansync::Outcome::slave_error) {
        done->result.outcome = cansync::Outcome::done;
      }
    }
  }
};

class WrongWrittenValue final : public Tamper {
 public:
  can::SendResult send(const can::Frame& frame) noexcept override {
    auto command = as<cansync::ParameterCommand>(frame);
    if (!command || command->kind == cansync::ParameterCommand::Kind::read) return below().send(frame);
    command->value ^= 1;
    return below().send(encode(*command));
  }
};

/// Says of requests of one kind that they were cancelled where it is not known whether the drive has them.
template <class Done>
class BoldCancel final : public Tamper {
 public:
  void terminals(std::vector<Terminal>& popped) override {
    for (Terminal& terminal : popped) {
      auto* const done = std::get_if<Done>(&terminal);
      if (done != nullptr && done->result.outcome == cansync::Outcome::no_answer)
        done->result.outcome = cansync::Outcome::cancelled;
    }
  }
};

class WrongDownload final : public Tamper {
 public:
  can::SendResult send(const can::Frame& frame) noexcept override {
    auto block = as<cansync::DownloadBlock>(frame);
    if (!block) return below().send(frame);
    block->data[0] ^= 0x40;
    return below().send(encode(*block));
  }
};

class WrongUpload final : public Tamper {
 public:
  bool receive(can::ReceivedFrame& out) noexcept override {
    if (!below().receive(out)) return false;
    auto reply = as<cansync::TransferReply>(out.frame);
    if (reply && reply->payload_size == 6) {
      reply->payload[0] ^= 0x40;
      out.frame = encode(*reply);
    }
    return true;
  }
};

// --- values and state

/// Shows old actual values as fresh ones.
class StaleValue final : public Tamper {
 public:
  bool actual(ActualReport& report, bool fresh) override {
    if (fresh && report.values.count[0] + report.values.count[1] > 0) last_ = report;
    if (fresh || !last_) return fresh;
    report = *std::exchange(last_, std::nullopt);
    for (unsigned channel = 0; channel < cansync::kChannels; ++channel) {
      if (!report.values.arrived[channel]) continue;
      ++report.values.count[channel];
      ++report.values.interval[channel];
    }
    return true;
  }

 private:
  std::optional<ActualReport> last_;
};

/// Changes one bit of an actual value.
class WrongValue final : public Tamper {
 public:
  bool actual(ActualReport& report, bool fresh) override {
    if (report.values.arrived[0]) report.values.value[0] ^= 1;
    if (report.values.arrived[1]) report.values.value[4] ^= 1;
    return fresh;
  }
};

class OverfullQueue final : public Tamper {
 public:
  void snapshot(MasterSnapshot& snapshot) override { snapshot.open_parameter_jobs += 1000; }
};

/// Hears nobody any more after a while.
class Deaf final : public Tamper {
 public:
  explicit Deaf(const Plan& plan) : from_(static_cast<can::Time::rep>(plan.last_fault) * plan.interval()) {}
  bool receive(can::ReceivedFrame& out) noexcept override {
    while (below().receive(out)) {
      if (out.own || out.end < from_) return true;
    }
    return false;
  }

 private:
  can::Time from_;
};

// --- the gate

/// No telegram is stopped.
class UnheardStop final : public Tamper {
 public:
  bool swallows(const StopRelease& /*stop*/) override { return true; }
};

/// What the one before gave for later intervals stays when another takes over.
class NoTakeOver final : public Tamper {
 public:
  void update(cansync::ReferenceUpdate& update) override { update.takes_over = false; }
};

/// Values meant for the daemon before count as meant for this one.
class AnyStart final : public Tamper {
 public:
  void sample(ReferenceSample& sample, const DaemonIdentity& start) override { sample.daemon = start; }
};

/// Of equal strengths the one that comes takes over, as it does by chance when GUIDs decide.
class EqualTakesOver final : public Tamper {
 public:
  void strength(std::int32_t& strength) override { ++strength; }
};

/// Values always come as fresh ones.
class FreshByName final : public Tamper {
 public:
  void sample(ReferenceSample& sample, const DaemonIdentity& /*start*/) override {
    sample.written = now().count();
  }
};

/// Any reference value is taken.
class NoLimits final : public Tamper {
 public:
  cansync::MasterSettings settings(const cansync::MasterSettings& of_plan) override {
    cansync::MasterSettings settings = of_plan;
    settings.process.reference_limits = {};
    return settings;
  }
};

/// Steps may be twice as long.
class LongSteps final : public Tamper {
 public:
  cansync::MasterSettings settings(const cansync::MasterSettings& of_plan) override {
    cansync::MasterSettings settings = of_plan;
    for (cansync::ReferenceLimits& limits : settings.process.reference_limits) {
      if (limits.max_step != cansync::ReferenceLimits::kNone) limits.max_step *= 2;
    }
    return settings;
  }
};

/// Control words that stop wait as if for a cursor.
class WaitingStop final : public Tamper {
 public:
  std::uint64_t held_back(const cansync::ControlWordRequest& /*request*/) override { return 8; }
};

template <class T>
std::unique_ptr<Tamper> make(const Plan& plan) {
  if constexpr (std::is_constructible_v<T, const Plan&>) {
    return std::make_unique<T>(plan);
  } else {
    static_cast<void>(plan);
    return std::make_unique<T>();
  }
}

constexpr const char* kReply = "one_terminal_reply_per_request";
constexpr const char* kParameter = "a_written_parameter_holds_what_was_confirmed";
constexpr const char* kBlock = "a_transferred_block_equals_the_memory";
constexpr const char* kFresh = "no_value_is_fresh_that_is_not";

constexpr const char* kGiver = "reference_values_are_of_who_may_give_them";
constexpr const char* kLimits = "no_released_value_is_beyond_its_limits_or_steps";
constexpr const char* kAge = "no_release_begins_with_old_values";

constexpr Mutant kMutants[] = {
    {"late command", "no_telegram_outside_its_slot", &make<LateCommand>},
    {"doubled command", "never_more_than_one_command_per_interval", &make<DoubledCommand>},
    {"malformed telegram", "every_telegram_is_well_formed", &make<MalformedTelegram>},
    {"repeated reference values", "reference_values_are_released_as_often_as_allowed",
     &make<RepeatedReferences>},
    {"reference values too early", "silence_where_nothing_may_be_sent", &make<EarlyReferences>},
    {"telegram not counted", "counters_are_consistent", &make<UncountedTelegram>},
    {"SYNC 1 ns too late", "sync_comes_exactly_on_time", &make<ShiftedSync>},
    {"repeated answer", kReply, &make<RepeatedAnswer>},
    {"lost answer", kReply, &make<LostAnswer>},
    {"invented confirmation", kParameter, &make<InventedConfirmation>},
    {"wrong value written", kParameter, &make<WrongWrittenValue>},
    {"a write that was sent is called cancelled", kParameter, &make<BoldCancel<ParameterDone>>},
    {"a download that was begun is called cancelled", kBlock, &make<BoldCancel<TransferDone>>},
    {"wrong byte downloaded", kBlock, &make<WrongDownload>},
    {"wrong byte uploaded", kBlock, &make<WrongUpload>},
    {"old actual value as fresh", kFresh, &make<StaleValue>},
    {"wrong actual value", kFresh, &make<WrongValue>},
    {"overfull queue", "queues_are_bounded", &make<OverfullQueue>},
    {"unheard stop", kGiver, &make<UnheardStop>},
    {"take over that ends nothing", kGiver, &make<NoTakeOver>},
    {"values for any start", kGiver, &make<AnyStart>},
    {"an equal writer takes over", "a_writer_keeps_its_telegram_until_a_stronger_one_comes",
     &make<EqualTakesOver>},
    {"fresh by name", kAge, &make<FreshByName>},
    {"any reference value", kLimits, &make<NoLimits>},
    {"steps twice as long", kLimits, &make<LongSteps>},
    {"word that stops waits", "a_word_that_stops_is_sent_in_two_intervals", &make<WaitingStop>},
    {"deaf after the faults", "back_in_normal_operation_in_time", &make<Deaf>},
};

}  // namespace

std::span<const Mutant> mutants() {
  static const std::vector<Mutant> all = [] {
    std::vector<Mutant> joined(std::begin(kMutants), std::end(kMutants));
    const std::span<const Mutant> words = word_mutants();
    joined.insert(joined.end(), words.begin(), words.end());
    return joined;
  }();
  return all;
}

}  // namespace cansyncd::campaign
