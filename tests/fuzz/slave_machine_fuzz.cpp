// The daemon's realtime machine of a slave, in its loop: any frames at any times, an input that loses edges,
// a bus that refuses, and programs that release, answer, take over and command. What stands on the bus is
// judged by the manual's slots (M 3.1.1.1, 3.2.0.1).
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <set>
#include <variant>

#include "bytes.h"
#include "cansync/telegram/telegram.h"
#include "daemon/cansync_slave/realtime/slave_machine.h"
#include "daemon/loop/deadline_loop.h"
#include "frames.h"
#include "require.h"
#include "slave_input.h"

namespace {

using namespace cansyncd;
using fuzz::Bytes;
using fuzz::kNumber;
using fuzz::require;
using std::chrono::microseconds;

constexpr can::Time kInterval = microseconds(1000);  // at 1 Mbit/s
constexpr std::array<can::Time, 2> kActualSlot = {microseconds(520), microseconds(820)};
constexpr can::Time kResponseSlot = microseconds(210);
constexpr can::Time kCommandSlot = microseconds(950);
constexpr can::Time kResponseTime = microseconds(300);

/// Judges what the slave hands over. The edges stand at whole intervals.
class Judge {
 public:
  void came(const can::Frame& frame, can::Time end) {
    begin_interval(end);
    const cansync::Decoded decoded = cansync::decode(frame);
    const auto* telegram = std::get_if<cansync::Telegram>(&decoded);
    if (telegram == nullptr) return;
    if (const auto* reference = std::get_if<cansync::ReferenceTelegram>(telegram)) {
      references_ = true;
      if (reference->polled == kNumber) ++asked_[cansync::index(reference->channel)];
    } else if (frame.id == (0x500 | kNumber)) {
      // A command that came later is one of a line that runs without reference values.
      const bool set_up = !references_ && !had_references_ && end % kInterval <= kCommandSlot - kResponseTime;
      commands_.push_back({end, set_up});
    }
  }
  void sent(const can::Frame& frame, can::Time start) {
    begin_interval(start);
    require(!frame.error && !frame.extended && !frame.remote, "a slave sends data frames of its own");
    if (frame.id == (0x580 | kNumber)) {
      const auto asked = std::find_if(commands_.begin(), commands_.end(), [&](const Command& command) {
        return command.set_up ? start - command.end <= kResponseTime : start % kInterval <= kResponseSlot;
      });
      require(
          asked != commands_.end(),
          "a response has its command, and starts in its slot, or without reference values within tRSPTO");
      commands_.erase(commands_.begin(), asked + 1);
      return;
    }
    const bool second = frame.id == (0x380 | kNumber);
    require(second || frame.id == (0x300 | kNumber), "a slave sends actual values and responses alone");
    require(asked_[second] > 0, "actual values are sent when they are asked for, once");
    --asked_[second];
    require(start % kInterval <= kActualSlot[second], "actual values start in their slot");
    require(frame.dlc == 8, "in full length");
    const std::uint32_t value = frame.data[0] | std::uint32_t{frame.data[1]} << 8 |
                                std::uint32_t{frame.data[2]} << 16 | std::uint32_t{frame.data[3]} << 24;
    require(value > 0 && value <= released, "a release of a program is sent");
    require(value > newest_[second], "each once, and none after a newer one");
    newest_[second] = value;
  }

  std::uint32_t released = 0;  ///< number of the newest release, which is its value

 private:
  struct Command {
    can::Time end{};
    bool set_up = false;  ///< no reference values are on the bus
  };

  void begin_interval(can::Time at) {
    if (at / kInterval == interval_) return;
    had_references_ = references_ && at / kInterval == interval_ + 1;
    references_ = false;
    interval_ = at / kInterval;
    asked_ = {};
  }

  std::int64_t interval_ = 0;
  bool references_ = false;
  bool had_references_ = false;
  std::array<unsigned, 2> asked_ = {};
  std::array<std::uint32_t, 2> newest_ = {};
  std::deque<Command> commands_;  ///< not answered
};

/// A bus and its SYNC wire in virtual time.
class FuzzedBus final : public can::Bus, public sync_line::Input {
 public:
  explicit FuzzedBus(Judge& judge) : judge_(judge) {}

  can::SendResult result = can::SendResult::queued;
  bool edges = true;
  bool echoes = true;

  void put(const can::Frame& frame, can::Time after) {
    if (frames_.size() < 32) frames_.push_back({frame, std::max(now_ + after, last_), false});
    last_ = frames_.back().end;
  }
  can::Time since_edge() const { return now_ % kInterval; }

  can::Time now() noexcept override { return now_; }
  can::Wake wait_until(can::Time deadline) noexcept override {
    const bool frame = !frames_.empty() && frames_.front().end <= std::max(deadline, now_);
    const can::Time at = std::max(now_, frame ? frames_.front().end : deadline);
    turns_ = at == now_ ? turns_ + 1 : 0;
    require(turns_ < 200, "the loop goes on: a deadline lies after its time");
    for (can::Time edge = (now_ / kInterval + 1) * kInterval; edge <= at; edge += kInterval) {
      if (edges && seen_.size() < 64) seen_.push_back(edge);
    }
    now_ = at;
    return frame ? can::Wake::frame : can::Wake::deadline;
  }
  bool receive(can::ReceivedFrame& out) noexcept override {
    if (frames_.empty() || frames_.front().end > now_) return false;
    out = frames_.front();
    frames_.pop_front();
    if (!out.own) judge_.came(out.frame, out.end);
    return true;
  }
  can::SendResult send(const can::Frame& frame) noexcept override {
    if (result != can::SendResult::queued) return result;
    judge_.sent(frame, now_);
    const can::ReceivedFrame echo{frame, now_ + microseconds(130), true};
    if (echoes && frames_.size() < 32)
      frames_.insert(std::upper_bound(frames_.begin(), frames_.end(), echo,
                                      [](const auto& a, const auto& b) { return a.end < b.end; }),
                     echo);
    return result;
  }
  can::ControllerStatus status() noexcept override { return {}; }
  can::ResetResult reset() noexcept override { return can::ResetResult::pending; }
  can::ResetResult reset_result() noexcept override { return can::ResetResult::done; }
  can::TimestampSource timestamp_source() noexcept override { return can::TimestampSource::simulation; }

  bool take(sync_line::Time, sync_line::Time& at) noexcept override {
    if (seen_.empty()) return false;
    at = seen_.front();
    seen_.pop_front();
    return true;
  }
  int error() const noexcept override { return 0; }

 private:
  Judge& judge_;
  can::Time now_{};
  can::Time last_{};  ///< end of the newest frame that was put
  std::deque<can::ReceivedFrame> frames_;
  std::deque<can::Time> seen_;
  unsigned turns_ = 0;
};

SlaveMachineSettings machine_settings(FuzzedBus& bus, Bytes& in) {
  using Access = cansync::ParameterDefinition::Access;
  SlaveMachineSettings out;
  out.slave.number = *cansync::SlaveNumber::from(kNumber);
  out.service.parameters = {{out.status_parameter, false, Access::read_only, 0, 0, 0, false, false},
                            {1, true, Access::read_write, 2, 0, 0, false, true}};
  out.wall_clock = nullptr;
  out.supervision.interval = kInterval;
  out.supervision.lock_time = 3 * kInterval;
  out.supervision.edges_until_fault = 2;
  out.lock.interval = kInterval;
  out.lock.greatest_step = kInterval / 1000;
  out.lock.holdover = 5 * kInterval;
  out.inputs.wire = &bus;
  out.service.area.area = in.flag();
  return out;
}

class MachineRun {
 public:
  explicit MachineRun(Bytes& in)
      : in_(in),
        bus_(judge_),
        machine_(machine_settings(bus_, in), bus_, *exchange_),
        loop_(machine_, bus_) {}

  void go() {
    loop_.begin();
    run(20 * kInterval);  // the input is followed
    for (unsigned steps = 0; !in_.empty() && steps < 400; ++steps) {
      step();
      run(microseconds(8 * in_.byte()));
    }
    loop_.end();
    take_reports();
    require(done_ <= ordered_, "a command is answered once");
  }

 private:
  void run(can::Time time) {
    const can::Time until = bus_.now() + time;
    do loop_.turn(until);
    while (bus_.now() < until);
    take_reports();
  }

  void step() {
    switch (in_.below(14)) {
      case 0:
        bus_.edges = in_.below(4) != 0;
        bus_.echoes = in_.below(4) != 0;
        return;
      case 1:
        bus_.result =
            in_.below(3) != 0 ? can::SendResult::queued : static_cast<can::SendResult>(in_.below(5));
        return;
      case 2:
        return bus_.put(fuzz::frame(in_), microseconds(in_.byte()));
      case 3:
        return bus_.put(fuzz::heard(in_), microseconds(in_.byte()));
      case 4:
        return bus_.put(cansync::encode(transfer_.next(in_)), microseconds(in_.byte()));
      case 5:
        transfer_.begin(in_);
        return;
      case 6:
        return order_command();
      case 7:
        return order_application();
      case 8:
      case 9:
        return release();
      default:
        return ask();
    }
  }

  /// Reference values in the next interval, which ask this slave.
  void ask() {
    cansync::ReferenceTelegram telegram;
    telegram.channel = static_cast<cansync::Channel>(in_.below(2));
    telegram.polled = kNumber;
    const auto slot = telegram.channel == cansync::Channel::one ? microseconds(340) : microseconds(640);
    bus_.put(cansync::encode(telegram), kInterval - bus_.since_edge() + slot);
  }
  void release() {
    ReleaseOrder order;
    order.channel = static_cast<cansync::Channel>(in_.below(2));
    order.values.fill(++judge_.released);
    order.valid = 0xF;
    order.intervals = in_.below(4);
    (void)exchange_->releases.try_push(order);
  }
  void order_command() {
    SlaveOrder order;
    if (in_.flag()) {
      order = SlaveModeOrder{++ordered_, static_cast<SlaveMode>(in_.below(5))};
    } else {
      order = SlaveListenOrder{++ordered_, *cansync::SlaveNumber::from(in_.below(32)), std::nullopt};
    }
    if (!exchange_->commands.try_push(order)) --ordered_;
  }
  void order_application() {
    switch (in_.below(3)) {
      case 0: {
        TakeOver over;
        const std::uint8_t bits = in_.byte();
        over.present = (bits & 3) != 0;
        over.same_application = (bits & 4) != 0;
        over.blocks = (bits & 8) != 0;
        (void)exchange_->orders.try_push(over);
        return;
      }
      case 1: {
        JobAnswer answer;
        answer.id = asked_ - in_.below(2);
        answer.answer.value = in_.byte();
        (void)exchange_->orders.try_push(answer);
        return;
      }
      default: {
        BlockReply reply;
        reply.kind = static_cast<BlockReply::Kind>(in_.below(4));
        reply.id = begun_;
        reply.length = in_.byte();
        reply.bytes = static_cast<std::uint16_t>(in_.below(cansync::kBlockAreaBytes + 1));
        (void)exchange_->orders.try_push(reply);
        return;
      }
    }
  }

  void take_reports() {
    SlaveSideReport report;
    while (exchange_->reports.try_pop(report)) {
    }
    ActionReport action;
    while (exchange_->actions.try_pop(action)) {
    }
    SlaveOrderDone done;
    while (exchange_->done.try_pop(done)) ++done_;
    ServiceReport told;
    while (exchange_->jobs.try_pop(told)) {
      if (const auto* job = std::get_if<JobReport>(&told)) {
        if (job->step == JobReport::Step::asked) {
          require(job->job.id > asked_, "an access is told once");
          asked_ = job->job.id;
        } else {
          require(ended_.insert(job->job.id).second, "and ends once");
        }
      } else if (const auto& block = std::get<BlockReport>(told); block.step == BlockReport::Step::begun) {
        begun_ = block.block.id;
      }
    }
    SlaveSnapshot snapshot;
    (void)exchange_->status.read(snapshot);
    for (const cansync::ActualCounters& one : snapshot.actual)
      require(one.sent <= one.asked, "no more is sent than was asked for");
  }

  Bytes& in_;
  Judge judge_;
  std::unique_ptr<SlaveExchange> exchange_ = std::make_unique<SlaveExchange>(256);
  FuzzedBus bus_;
  SlaveMachine machine_;
  DeadlineLoop<SlaveMachine> loop_;
  fuzz::Transfer transfer_;
  std::uint64_t ordered_ = 0, done_ = 0;
  std::uint64_t asked_ = 0, begun_ = 0;
  std::set<std::uint64_t> ended_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes in(data, size);
  MachineRun(in).go();
  return 0;
}
