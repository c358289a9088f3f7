// The whole slave with an application behind it, and the simulated drive: any frames at any times, SYNC
// edges, and calls of the application in any order. The first bit of the input chooses one of the two.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>

#include "bytes.h"
#include "cansync/sim/drive.h"
#include "cansync/slave/slave.h"
#include "frames.h"
#include "require.h"
#include "slave_input.h"
#include "slave_model.h"

namespace {

using namespace cansync;
using fuzz::Bytes;
using fuzz::heard;
using fuzz::kNumber;
using fuzz::require;

constexpr ControlCommand kStart[] = {ControlCommand::handshake, ControlCommand::take_over_initialisation,
                                     ControlCommand::start_synchronous, ControlCommand::enable_active};

ProcessMapping mapping(Bytes& in) {
  ProcessMapping out = {default_mapping(Channel::one), default_mapping(Channel::two)};
  for (std::uint8_t bits = in.byte(); bits != 0; bits &= static_cast<std::uint8_t>(bits - 1)) {
    WordMapping& word = out[in.below(2)].word[in.below(4)];
    word = {in.flag(), in.flag(), static_cast<std::uint8_t>(in.below(8))};
  }
  return out;
}

class SlaveRun {
 public:
  explicit SlaveRun(Bytes& in) : in_(in), application_(in), slave_(settings(in), application_) {}

  void go() {
    while (!in_.empty()) {
      step();
      check_state();
    }
    static_cast<void>(slave_.control(ControlCommand::cold_restart));
    check_state();
    require(!slave_.transfer_open() && !application_.begun() && !application_.pending(),
            "nothing stays open outside synchronous operation");
  }

 private:
  static SlaveSideSettings settings(Bytes& in) {
    SlaveSideSettings out;
    out.number = *SlaveNumber::from(kNumber);
    out.full_length = in.flag();
    out.block_limit = static_cast<std::uint16_t>(1 + in.below(4095));
    out.reference_mapping = mapping(in);
    out.actual_mapping = mapping(in);
    if (in.flag()) out.monitored[kNumber] = mapping(in);
    if (in.flag()) out.monitored[7] = mapping(in);
    return out;
  }

  void step() {
    switch (in_.below(12)) {
      case 0:
        return control(static_cast<ControlCommand>(1u << in_.below(8)));
      case 1:
        for (const ControlCommand command : kStart) control(command);
        return;
      case 2:
        slave_.on_sync();
        for (const Channel channel : {Channel::one, Channel::two}) {
          released_[index(channel)] = false;
          require(!slave_.reference_fresh(channel), "after an edge every reference value is old");
        }
        return;
      case 3: {
        const auto channel = static_cast<Channel>(in_.below(2));
        slave_.release_actual(channel, {1, 2, 3, 4, 5, 6, 7, in_.byte()});
        released_[index(channel)] = true;
        return;
      }
      case 4:
        return in_.flag() ? slave_.set_reference_mapping(mapping(in_))
                          : slave_.set_actual_mapping(mapping(in_));
      case 5:
        static_cast<void>(receive(fuzz::frame(in_)));
        return;
      case 6:
        return transfer_.begin(in_);
      case 7:
      case 8:
        return move();
      case 9:
        static_cast<void>(receive(can::Frame(last_)));
        return;
      default:
        static_cast<void>(receive(heard(in_)));
        return;
    }
  }

  void control(ControlCommand command) {
    const State before = slave_.state();
    const bool allowed = slave_.control(command);
    require(allowed || slave_.state() == before, "what is not allowed changes nothing");
    if (allowed && !is_active(slave_.state())) released_ = {};
    last_answer_.reset();
  }

  void move() {
    const bool beginning = transfer_.beginning();
    const auto answer = receive(encode(transfer_.next(in_)));
    if (!answer) return;
    const Decoded decoded = decode(*answer);
    transfer_.answered(std::get<TransferReply>(std::get<Telegram>(decoded)), beginning);
  }

  std::optional<can::Frame> receive(const can::Frame& frame) {
    const bool repeated = frame == last_;
    const std::optional<can::Frame> before = last_answer_;
    last_ = frame;
    const bool was_synchronous = is_synchronous(slave_.state());
    application_.next_frame();
    const auto answer = slave_.receive(frame, Duration(in_.number<std::uint32_t>()));
    last_answer_.reset();
    if (answer) last_answer_ = answer->frame;
    const bool on_the_bus = answer && in_.flag() && slave_.may_start(*answer, answer->window.earliest);
    if (on_the_bus) slave_.sent(answer->frame);
    require(application_.asked() <= 1, "the application is asked once for each frame");
    const Decoded decoded = decode(frame);
    const auto* telegram = std::get_if<Telegram>(&decoded);
    if (telegram == nullptr || !was_synchronous) {
      require(!last_answer_ && application_.asked() == 0, "what is no telegram, or too early, is not heard");
      return last_answer_;
    }
    if (!last_answer_) return last_answer_;
    fuzz::check_answer(slave_, *telegram, *last_answer_);
    check_kind(*telegram, std::get<Telegram>(decode(*last_answer_)));
    if (repeated && before && answered_well(*before))
      require(*last_answer_ == *before && application_.asked() == 0,
              "a transfer telegram that was answered well has the same answer when it comes again");
    return last_answer_;
  }

  static bool answered_well(const can::Frame& answer) {
    const Decoded decoded = decode(answer);
    const auto* telegram = std::get_if<Telegram>(&decoded);
    const auto* reply = telegram == nullptr ? nullptr : std::get_if<TransferReply>(telegram);
    return reply != nullptr && !reply->busy && !reply->error;
  }

  void check_kind(const Telegram& asked, const Telegram& said) {
    if (const auto* reference = std::get_if<ReferenceTelegram>(&asked)) {
      require(released_[index(reference->channel)], "a release is good for one telegram");
      released_[index(reference->channel)] = false;
    } else if (const auto* command = std::get_if<ParameterCommand>(&asked)) {
      check_parameter(*command, std::get<ParameterReply>(said));
    } else {
      check_transfer(asked, std::get<TransferReply>(said));
    }
  }

  void check_parameter(const ParameterCommand& asked, const ParameterReply& said) {
    require(said.number == asked.number, "an answer names the parameter");
    const bool write = asked.kind != ParameterCommand::Kind::read;
    if (application_.asked() == 0 && asked.element == kValueElement) {
      require(write && !said.busy, "a write whose answer was never on the bus is not asked for again");
      return;
    }
    if (application_.asked() == 0) {
      require(said.error && asked.element != kValueElement && asked.kind != ParameterCommand::Kind::read,
              "only an element that cannot be written is refused without asking");
      return;
    }
    const ParameterAnswer& answer = application_.parameter();
    require(said.busy == answer.busy, "busy is handed on");
    require(answer.busy || said.error == (answer.error != ParameterError::none), "an error is handed on");
    if (said.busy || said.error || asked.kind != ParameterCommand::Kind::read) return;
    const std::uint32_t value =
        answer.doubleword ? load_doubleword(said.payload.data()) : load_word(said.payload.data());
    require(value == (answer.doubleword ? answer.value : answer.value & 0xFFFF), "the value is handed on");
  }

  void check_transfer(const Telegram& asked, const TransferReply& said) {
    if (said.busy || said.error) return;
    if (const auto* initialise = std::get_if<TransferInitialise>(&asked)) {
      const bool cancel = *initialise == cancel_transfer(initialise->slave) ||
                          (initialise->direction == TransferInitialise::Direction::upload &&
                           initialise->length.value() == 0 && initialise->address == 0);
      require(cancel || slave_.transfer_open(), "a block that was accepted is open");
      require(!cancel || !slave_.transfer_open(), "a cancel leaves nothing open");
      if (!cancel && initialise->direction == TransferInitialise::Direction::upload)
        require(application_.asked() == 0 || said.offset.value() == application_.length() ||
                    said.offset.value() == 0,
                "the length is the application's");
      return;
    }
    if (application_.asked() == 0) return;
    if (const auto* upload = std::get_if<UploadBlock>(&asked)) {
      for (unsigned i = 0; i < 6; ++i) {
        const unsigned at = upload->offset.value() + i;
        require(said.payload[i] == (at < application_.length() ? fuzz::Application::content(at) : 0),
                "each byte of an upload is that of its offset");
      }
    } else if (const auto* download = std::get_if<DownloadBlock>(&asked)) {
      const auto taken = application_.taken();
      require(std::equal(taken.begin(), taken.end(), download->data.begin()),
              "each byte of a download arrives");
    }
  }

  void check_state() {
    require(slave_.transfer_open() == application_.open(), "slave and application agree on the open block");
    if (!is_synchronous(slave_.state()))
      require(!slave_.sync_activated() && !application_.begun() && !application_.pending(),
              "outside synchronous operation nothing is under way");
    if (!is_active(slave_.state()))
      require(!slave_.reference_fresh(Channel::one) && !slave_.reference_fresh(Channel::two),
              "reference values are taken in active operation");
  }

  Bytes& in_;
  fuzz::Application application_;
  Slave slave_;
  fuzz::Transfer transfer_;
  can::Frame last_;
  std::optional<can::Frame> last_answer_;
  std::array<bool, kChannels> released_ = {};
};

sim::DriveSettings drive_settings(Bytes& in) {
  sim::DriveSettings out;
  out.slave.number = *SlaveNumber::from(kNumber);
  out.slave.reference_mapping = mapping(in);
  out.slave.actual_mapping = mapping(in);
  out.lock_time = std::chrono::milliseconds(2);
  out.misses_until_fault = in.byte();
  out.edges_until_fault = 2 + (in.byte() & 7u);
  out.axis.position_value = in.byte();
  out.axis.speed_value = in.byte();
  if (in.flag()) out.axis.leader = *SlaveNumber::from(in.below(kSlaves));
  out.memory.size = 4096;
  out.memory.busy_replies = in.byte() & 3;
  return out;
}

void check_drive(const sim::Drive& drive) {
  const bool fault = drive.fault() != sim::fault_code::none;
  require(((drive.status_word() & sim::status_bit::fault) != 0) == fault,
          "a fault stands in the status word");
  require(((drive.status_word() & sim::status_bit::ready) != 0) != fault, "without a fault it is ready");
  constexpr double kFar = 1e18;  // fits 64 bits
  require(std::abs(drive.motion().position()) < kFar && std::abs(drive.motion().speed()) < kFar &&
              std::abs(drive.motion().torque()) < kFar && std::abs(drive.motion().temperature()) < kFar,
          "the axis stays in this world");
}

void run_drive(Bytes& in) {
  sim::Drive drive(drive_settings(in));
  can::Time now{};
  while (!in.empty()) {
    switch (in.below(16)) {
      case 0:
        now += can::Time(in.number<std::uint32_t>() * 64LL);
        drive.on_sync(now);
        break;
      case 1:
        drive.restart();
        break;
      case 2:
        static_cast<void>(drive.set_parameter(in.number<std::uint16_t>(), in.number<std::uint32_t>()));
        break;
      case 3:
        drive.answer_busy(in.byte());
        break;
      case 4:
        drive.raise_fault(static_cast<std::uint16_t>(1 + in.byte()));
        break;
      case 5:
      case 6:
      case 7:
        for (unsigned n = 1 + (in.byte() & 15u); n > 0; --n) {
          now += std::chrono::milliseconds(1);
          drive.on_sync(now);
        }
        break;
      default: {
        const can::Frame frame = in.below(8) == 0 ? fuzz::frame(in) : heard(in);
        const Decoded decoded = decode(frame);
        const auto* telegram = std::get_if<Telegram>(&decoded);
        const can::Time end = now + can::Time(in.number<std::uint32_t>() & 0xFFFFFu);
        const auto answer = drive.on_frame(frame, end);
        require(!answer || telegram != nullptr, "what is no telegram is not answered");
        if (!answer) break;
        require(answer->not_before >= end, "an answer follows its question");
        fuzz::check_answer(drive.slave(), *telegram, answer->frame);
      }
    }
    check_drive(drive);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes in(data, size);
  if (in.flag())
    SlaveRun(in).go();
  else
    run_drive(in);
  return 0;
}
