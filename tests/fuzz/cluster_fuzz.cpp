// A gateway between two buses: any telegrams above with sub-slave addresses, any answers below, edges that
// come, stay away and jump. What goes down is held against what was asked above.
#include <array>
#include <chrono>
#include <map>
#include <optional>
#include <tuple>
#include <variant>

#include "bytes.h"
#include "cansync/cluster/cluster.h"
#include "cansync/slave/slave_service.h"
#include "cansync/telegram/reply_payload.h"
#include "frames.h"
#include "require.h"
#include "slave_input.h"

namespace {

using namespace cansync;
using fuzz::Bytes;
using fuzz::kNumber;
using fuzz::require;

constexpr unsigned kMostSteps = 4000;
constexpr std::uint16_t kOwnNumber = 9;
constexpr std::uint16_t kFirstBelow = 10;  ///< two slaves of the lower bus, and one behind the second
constexpr std::uint16_t kBehind = 12;

/// The gateway's own side.
struct OwnSide final : SlaveServiceListener {
  void asked(const AskedParameter& job) noexcept override {
    require(job.sub_slave.value == 0, "what is for others does not come to the gateway's own application");
  }
  void dropped(std::uint64_t) noexcept override {}
  void answered(std::uint64_t) noexcept override {}
  void block_begun(const AskedBlock&) noexcept override {}
  void block_complete(std::uint64_t) noexcept override {}
  void step_asked(std::uint64_t, const AskedStep&) noexcept override {}
  void block_ended(std::uint64_t, BlockEnd) noexcept override {}
  void control_word(std::uint16_t) noexcept override {}
  void action(std::uint8_t, std::uint8_t, std::uint16_t) noexcept override {}
  void sync_activated() noexcept override {}
};

/// Who shares the lower master: sees its own job alone.
struct LowerSide final : MasterListener {
  void actual_values(SlaveNumber, const ActualValues&) noexcept override {}
  void slave_status(SlaveNumber, const SlaveStatus&) noexcept override {}
  void state_changed(State, State, ControlCommand) noexcept override {}
  void parameter_done(JobId id, const ParameterResult&) noexcept override {
    require(id != 0 && id == open, "a job of the lower bus ends once, and none of the gateway's shows");
    open = 0;
  }
  void transfer_progress(JobId, std::uint32_t) noexcept override {
    require(false, "nobody moves a block below but the gateway");
  }
  void transfer_done(JobId, const TransferResult&) noexcept override {
    require(false, "nobody moves a block below but the gateway");
  }
  void command_done(JobId, Outcome) noexcept override {}
  void event(const MasterEvent&) noexcept override {}
  JobId open = 0;
};

ClusterSettings cluster_settings(Bytes& in) {
  ClusterSettings out;
  out.upper.number = *SlaveNumber::from(kNumber);
  out.upper.block_limit = 4095;
  out.lower.process.maximum_slave = *SlaveNumber::from(1);
  for (unsigned i = 0; i < 2; ++i) out.lower.slaves[i].configured = true;
  out.lower.startup.enable = EnableRule::any;
  out.lower.command_channel.parameter_queue = 2;
  out.gateway.own_number = {kOwnNumber};
  for (std::uint16_t i = 0; i < 2; ++i) {
    const auto number = static_cast<std::uint16_t>(kFirstBelow + i);
    out.gateway.routes.push_back({{number}, *SlaveNumber::from(i), {}});
  }
  out.gateway.routes.push_back({{kBehind}, *SlaveNumber::from(1), {kBehind}});
  const std::uint8_t bits = in.byte();
  out.gateway.monitoring = std::chrono::milliseconds((bits & 1) != 0 ? 10 : 1000);
  out.gateway.asker_gone = out.gateway.monitoring * ((bits & 2) != 0 ? 2 : 20);
  out.gateway.transfer_gone = std::chrono::milliseconds((bits & 4) != 0 ? 20 : 2000);
  out.gateway.remembers_writes = (bits & 8) == 0;
  for (const std::uint8_t value : {std::uint8_t{0}, std::uint8_t{4}, std::uint8_t{5}}) {
    const auto source = static_cast<std::uint8_t>(value == 5 ? 4 : 0);
    out.lead[value] = {LeadSource::Kind::reference, source, {}, true};
  }
  return out;
}

/// A write as it stands on a bus, without the place: number, format, value.
using Written = std::tuple<std::uint16_t, bool, std::uint32_t>;

class ClusterRun {
 public:
  explicit ClusterRun(Bytes& in)
      : in_(in),
        settings_(cluster_settings(in)),
        own_(SlaveServiceSettings{}, told_),
        cluster_(settings_, own_, below_) {
    require(check(settings_).empty(), "the settings are good");
    cluster_.start();
    cluster_.follow(UpperSync::locked);
    edge(1);
  }

  void go() {
    for (unsigned n = 0; n < kMostSteps && !in_.empty(); ++n) {
      step();
      require(cluster_.gateway().running() <= 2, "one parameter and one block at a time");
    }
    cluster_.stop();
    require(cluster_.gateway().running() == 0 && below_.open == 0, "nothing outlives the cluster");
    require(cluster_.state() == ClusterState::stopped && !cluster_.sync_output(), "stopped is stopped");
  }

 private:
  void step() {
    switch (in_.below(16)) {
      case 0:
        return edge(1 + in_.below(40));
      case 1:
        sync_ = static_cast<UpperSync>(in_.below(4));
        return cluster_.follow(sync_);
      case 2:
        return restart();
      case 3:
        return reference();
      case 4:
        return static_cast<void>(above(fuzz::frame(in_)));
      case 5:
        return static_cast<void>(above(fuzz::heard(in_)));
      case 6:
        return transfer_.begin(in_);
      case 7:
      case 8:
        return move();
      case 9:
        return cluster_.lower().receive(fuzz::frame(in_), Duration(in_.number<std::uint16_t>() * 16));
      case 10:
        return share();
      case 11:
        if (last_) static_cast<void>(ask(*last_));
        return;
      case 12:
      case 13:
        return parameter();
      default:
        return edge(1);
    }
  }

  void restart() {
    if (in_.below(4) != 0) return cluster_.lower().bus_lost();
    cluster_.stop();
    cluster_.start();
    busy_.reset();
  }

  /// An interval with its slots; each command below is answered as the input says.
  void edge(unsigned passed) {
    previous_ = passed == 1 ? current_ : Came{};
    current_ = {};
    now_ += passed;
    cluster_.begin_interval(now_);
    if (!cluster_.sync_output()) return;
    reference();
    for (const Slot slot : {Slot::reference_one, Slot::reference_two, Slot::command}) {
      const auto frame = cluster_.take(slot);
      if (!frame) continue;
      judge(*frame);
      if (in_.below(16) == 0) {
        cluster_.lower().left_out(slot);
        continue;
      }
      cluster_.lower().sent(slot);
      cluster_.lower().transmitted(*frame, cluster_.lower().latest_start(slot));
      if (slot == Slot::command) answer(*frame);
    }
  }

  /// What came above in one interval.
  struct Came {
    std::array<std::optional<Values>, kChannels> values;
  };
  void reference() {
    ReferenceTelegram telegram;
    telegram.channel = static_cast<Channel>(in_.below(2));
    telegram.words = static_cast<std::uint8_t>(in_.below(4) == 0 ? in_.below(5) : 4);
    telegram.word[0] = in_.number<std::uint16_t>();
    telegram.polled = static_cast<std::uint8_t>(in_.below(8));
    if (in_.flag()) cluster_.release_actual(telegram.channel, {1, 2, 3});
    static_cast<void>(above(encode(telegram)));
  }
  void note(const ReferenceTelegram& telegram) {
    const bool tracking = sync_ == UpperSync::locked || sync_ == UpperSync::holdover;
    if (tracking && is_active(cluster_.upper().state()) && telegram.words >= 2)
      current_.values[index(telegram.channel)] = cluster_.upper().references();
  }

  /// Reference values below are those of the interval they are due in.
  void judge(const can::Frame& frame) {
    const Decoded decoded = decode(frame);
    const auto* telegram = std::get_if<Telegram>(&decoded);
    require(telegram != nullptr, "what the lower master sends is a telegram");
    if (const auto* given = std::get_if<ReferenceTelegram>(telegram)) {
      if (given->channel == Channel::one) return expect(given->word[0], previous_.values[0], 0);
      expect(given->word[0], current_.values[0], 0);
      expect(given->word[2], previous_.values[1], 4);
    } else if (const auto* command = std::get_if<ParameterCommand>(telegram)) {
      if (command->kind == ParameterCommand::Kind::read) return;
      require(asked_[written(*command)] > 0, "nothing is written below that nobody asked for above");
    }
  }
  void expect(std::uint16_t word, const std::optional<Values>& came, unsigned value) {
    require(came.has_value(), "no value below without one above in its interval");
    require(word == static_cast<std::uint16_t>((*came)[value]), "the value of another interval");
  }

  static Written written(const ParameterCommand& command) {
    return {command.number.value(), command.kind == ParameterCommand::Kind::write_doubleword, command.value};
  }

  /// What a slave of the lower bus says: nothing, busy, an error, or that it is done.
  void answer(const can::Frame& frame) {
    const Decoded decoded = decode(frame);
    const auto& telegram = *std::get_if<Telegram>(&decoded);
    const unsigned how = in_.below(8);
    if (how == 0) return;
    if (const auto* command = std::get_if<ParameterCommand>(&telegram)) return say(*command, how);
    TransferReply reply;
    if (const auto* initialise = std::get_if<TransferInitialise>(&telegram)) {
      reply.slave = initialise->slave;
      reply.offset = initialise->length;
    } else if (const auto* upload = std::get_if<UploadBlock>(&telegram)) {
      reply.slave = upload->slave;
      reply.offset = upload->offset;
      put_upload(reply, {1, 2, 3, 4, 5, 6});
    } else if (const auto* download = std::get_if<DownloadBlock>(&telegram)) {
      reply.slave = download->slave;
      reply.offset = download->offset;
    } else {
      return;
    }
    if (how == 1) put_busy(reply);
    if (how == 2) put_error(reply, TransferError::address_not_allowed);
    tell(encode(reply));
  }
  void say(const ParameterCommand& command, unsigned how) {
    ParameterReply reply;
    reply.slave = command.slave;
    reply.number = command.number;
    if (how == 1 || how == 2) {
      put_busy(reply);
    } else if (how == 3) {
      put_error(reply, ParameterError::below_minimum, command.sub_slave);
    } else if (command.kind == ParameterCommand::Kind::read) {
      put_value(reply, 0x8000u | in_.byte(), in_.flag(), command.sub_slave);
    } else {
      put_confirmation(reply, command.sub_slave);
      applied(command);
    }
    tell(encode(reply));
  }
  void applied(const ParameterCommand& command) {
    const Written what = written(command);
    ++applied_[what];
    require(applied_[what] <= asked_[what], "a write is applied at most as often as it was asked for");
  }
  void tell(const can::Frame& frame) { cluster_.lower().receive(frame, std::chrono::microseconds(990)); }

  /// Somebody else's job at the lower master.
  void share() {
    if (below_.open != 0) return;
    ParameterRequest request;
    request.id = ++ids_;
    request.slave = *SlaveNumber::from(in_.below(2));
    request.number = *ParameterNumber::from(in_.below(4));
    below_.open = request.id;
    if (cluster_.lower().submit(request) != Refusal::none) below_.open = 0;
    if (below_.open != 0 && in_.flag()) static_cast<void>(cluster_.lower().cancel(request.id));
  }

  void parameter() {
    ParameterCommand command;
    command.slave = *SlaveNumber::from(kNumber);
    command.kind = static_cast<ParameterCommand::Kind>(in_.below(3));
    command.number = *ParameterNumber::from(in_.below(4));
    if (command.kind != ParameterCommand::Kind::read) command.value = in_.byte();
    if (in_.below(16) == 0) command.element = *Element::from(in_.below(8));
    constexpr std::uint16_t kPlaces[] = {0, kOwnNumber, kFirstBelow, kFirstBelow + 1, kBehind, 4711, 12, 10};
    command.sub_slave = {kPlaces[in_.below(8)]};
    last_ = command;
    static_cast<void>(ask(command));
  }
  std::optional<can::Frame> ask(const ParameterCommand& command) { return above(encode(command)); }

  void move() {
    const bool beginning = transfer_.beginning();
    Telegram telegram = transfer_.next(in_);
    if (auto* initialise = std::get_if<TransferInitialise>(&telegram))
      initialise->sub_slave = {static_cast<std::uint16_t>(kFirstBelow - 1 + in_.below(4))};
    const auto answer = above(encode(telegram));
    if (!answer) return;
    const Decoded decoded = decode(*answer);
    transfer_.answered(std::get<TransferReply>(std::get<Telegram>(decoded)), beginning);
  }

  /// A frame on the upper bus, and what the gateway answers.
  std::optional<can::Frame> above(const can::Frame& frame) {
    const Decoded decoded = decode(frame);
    if (const auto* telegram = std::get_if<Telegram>(&decoded)) count(*telegram);
    const auto answer = cluster_.receive_above(frame, std::chrono::microseconds(400));
    if (const auto* telegram = std::get_if<Telegram>(&decoded)) {
      if (const auto* reference = std::get_if<ReferenceTelegram>(telegram)) note(*reference);
    }
    if (!answer) return std::nullopt;
    note_busy(decoded, answer->frame);
    if (cluster_.upper().may_start(*answer, answer->window.earliest) && in_.below(4) != 0)
      cluster_.upper().sent(answer->frame);
    return answer->frame;
  }
  void note_busy(const Decoded& asked, const can::Frame& answer) {
    const auto* telegram = std::get_if<Telegram>(&asked);
    const auto* command = telegram != nullptr ? std::get_if<ParameterCommand>(telegram) : nullptr;
    const Decoded decoded = decode(answer);
    const auto* reply = std::get_if<ParameterReply>(&std::get<Telegram>(decoded));
    if (command != nullptr && reply != nullptr && reply->busy) busy_ = *command;
  }
  void count(const Telegram& telegram) {
    const auto* command = std::get_if<ParameterCommand>(&telegram);
    if (command == nullptr || command->slave.value() != kNumber) return;
    // The same again while it is busy is the question whether it is done.
    const auto gone =
        static_cast<IntervalNumber>(settings_.gateway.asker_gone / std::chrono::milliseconds(1));
    const bool question = busy_ == *command && now_ - asked_at_ <= gone;
    if (!question && command->kind != ParameterCommand::Kind::read) ++asked_[written(*command)];
    busy_.reset();
    asked_at_ = now_;
  }

  Bytes& in_;
  ClusterSettings settings_;
  OwnSide told_;
  LowerSide below_;
  SlaveService own_;
  Cluster cluster_;
  fuzz::Transfer transfer_;
  IntervalNumber now_ = 0;
  JobId ids_ = 0;
  UpperSync sync_ = UpperSync::locked;
  Came current_, previous_;
  std::optional<ParameterCommand> last_;
  std::optional<ParameterCommand> busy_;  ///< the newest question, answered busy
  IntervalNumber asked_at_ = 0;
  std::map<Written, unsigned> asked_, applied_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes in(data, size);
  ClusterRun(in).go();
  return 0;
}
