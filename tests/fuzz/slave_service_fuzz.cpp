// A slave with its service and supervision: any frames at any times, edges, echoes, and an application that
// answers, is gone or comes at any moment. What the service told is held against what it was asked.
#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <span>
#include <vector>

#include "bytes.h"
#include "cansync/slave/slave.h"
#include "cansync/slave/slave_service.h"
#include "cansync/slave/slave_supervision.h"
#include "frames.h"
#include "require.h"
#include "slave_input.h"

namespace {

using namespace cansync;
using fuzz::Bytes;
using fuzz::kNumber;
using fuzz::require;

/// Holds the service to its word: everything that it asks for ends once.
class Told final : public SlaveServiceListener {
 public:
  void asked(const AskedParameter& job) noexcept override {
    require(!parameter_open && fetched == 0, "one access is open at a time");
    require(job.id > parameter.id, "an id is never given twice");
    parameter_open = true;
    parameter = job;
  }
  void dropped(std::uint64_t id) noexcept override {
    require(id != 0 && ((parameter_open && id == parameter.id) || id == fetched),
            "what was asked and is open is dropped, once");
    if (id == fetched) {
      fetched = 0;
    } else {
      parameter_open = false;
    }
  }
  void answered(std::uint64_t id) noexcept override {
    require(id != 0 && id == fetched, "what the application has answered was on the bus, once");
    fetched = 0;
  }
  void block_begun(const AskedBlock& begun) noexcept override {
    require(!block_open && begun.id > block.id, "one block is open at a time");
    require(begun.address >= 0x100, "the operating system's addresses are not the application's");
    require(begun.area == (with_area && begun.length <= kBlockAreaBytes), "area or single telegrams");
    block_open = true;
    complete = false;
    step_open = false;
    block = begun;
  }
  void block_complete(std::uint64_t id) noexcept override {
    require(block_open && id == block.id && block.area && !complete, "a block is complete once");
    complete = true;
  }
  void step_asked(std::uint64_t id, const AskedStep& asked) noexcept override {
    require(block_open && id == block.id && !block.area && !step_open, "one telegram at a time");
    require(asked.bytes >= 1 && asked.bytes <= 6, "1 to 6 bytes");
    step_open = true;
    step = asked;
  }
  void block_ended(std::uint64_t id, BlockEnd) noexcept override {
    require(block_open && id == block.id, "a block that was begun ends once");
    block_open = false;
  }
  void control_word(std::uint16_t) noexcept override {}
  void action(std::uint8_t command, std::uint8_t, std::uint16_t) noexcept override {
    require(command != kCommandControlWord, "a control word is no other action");
  }
  void sync_activated() noexcept override {}

  bool with_area = true;
  bool parameter_open = false;
  AskedParameter parameter;
  std::uint64_t fetched = 0;  ///< the access whose answer the master has fetched
  bool block_open = false;
  bool complete = false;
  bool step_open = false;
  AskedBlock block;
  AskedStep step;
};

SlaveServiceSettings service_settings(Bytes& in) {
  using Access = ParameterDefinition::Access;
  SlaveServiceSettings out;
  out.parameters = {{0, false, Access::read_write, 1, 0, 10, true, false},
                    {1, true, Access::read_only, 2, 0, 0, false, false},
                    {2, false, Access::read_write, 3, -5, 5, true, true},
                    {3, true, Access::read_write, 4, 0, 0, false, true},
                    {4, false, Access::not_available, 0, 0, 0, false, true},
                    {5, false, Access::read_write, 7, 0, 0, false, false, ParameterError::unspecified}};
  const std::uint8_t bits = in.byte();
  out.jobs = {(bits & 1) != 0, (bits & 2) != 0};
  out.area.area = (bits & 4) != 0;
  out.area.monitoring = std::chrono::milliseconds((bits & 8) != 0 ? 50 : 0);
  out.jobs.answer_time = std::chrono::milliseconds((bits & 16) != 0 ? 20 : 0);
  return out;
}

SlaveSideSettings slave_settings() {
  SlaveSideSettings out;
  out.number = *SlaveNumber::from(kNumber);
  out.block_limit = 4095;
  return out;
}

class ServiceRun {
 public:
  explicit ServiceRun(Bytes& in)
      : in_(in),
        settings_(service_settings(in)),
        service_(settings_, told_),
        slave_(slave_settings(), service_) {
    told_.with_area = settings_.area.area;
    start();
  }

  void go() {
    while (!in_.empty()) {
      step();
      check();
    }
    service_.set_application(false);
    static_cast<void>(slave_.control(ControlCommand::cold_restart));
    require(!told_.parameter_open && !service_.jobs().open(), "no access outlives its application");
    require(!told_.block_open || service_.area().open().id == 0, "no block outlives its application");
  }

 private:
  void start() {
    for (const ControlCommand command : {ControlCommand::handshake, ControlCommand::take_over_initialisation,
                                         ControlCommand::start_synchronous, ControlCommand::enable_active}) {
      static_cast<void>(slave_.control(command));
    }
  }

  void step() {
    switch (in_.below(16)) {
      case 0:
        return edge(1 + in_.below(8));
      case 1:
        return come_or_go(in_.flag());
      case 2:
        slave_.release_actual(static_cast<Channel>(in_.below(2)), {1, 2, 3, 4, 5, 6, 7, 8});
        return;
      case 3:
        static_cast<void>(slave_.control(ControlCommand::cold_restart));
        return start();
      case 4:
      case 5:
        return answer_parameter();
      case 6:
      case 7:
      case 8:
        return answer_block();
      case 9:
        return transfer_.begin(in_);
      case 10:
      case 11:
        return move();
      case 12:
        static_cast<void>(receive(can::Frame(last_)));
        return;
      case 13:
        static_cast<void>(receive(fuzz::frame(in_)));
        return;
      default:
        static_cast<void>(receive(fuzz::heard(in_)));
        return;
    }
  }

  void edge(unsigned passed) {
    now_ += std::chrono::milliseconds(passed);
    const std::uint32_t counted = supervision_.edge(now_, slave_.sync_activated());
    require(counted == passed || counted == 0, "intervals are counted by the clock");
    const std::uint32_t missing = supervision_.references(counted, slave_.reference_fresh(Channel::one));
    require(missing <= counted, "no more are missing than have passed");
    slave_.on_sync(passed);
    service_.area().at(now_);
    service_.jobs().at(now_);
  }

  void come_or_go(bool present) {
    service_.set_application(present);
    if (!present || in_.flag()) return;
    TakenOver taken;
    taken.numbers = in_.byte();
    taken.sub_slaves = in_.flag();
    service_.jobs().take_over(taken);
  }

  void answer_parameter() {
    ParameterAnswer answer;
    const std::uint8_t bits = in_.byte();
    answer.busy = (bits & 1) != 0;
    answer.doubleword = (bits & 2) != 0;
    if ((bits & 12) == 12) answer.error = static_cast<ParameterError>(0x100 + bits);
    answer.value = bits;
    const std::uint64_t id = (bits & 16) != 0 ? told_.parameter.id : told_.parameter.id + in_.byte() - 1;
    const bool open = told_.parameter_open && id == told_.parameter.id && id != given_;
    require(service_.jobs().answer(id, answer) == open, "the open access takes one answer");
    if (open) given_ = id;
  }

  void answer_block() {
    BlockArea& area = service_.area();
    const std::uint64_t id = in_.below(8) == 0 ? told_.block.id + 1 : told_.block.id;
    const bool open = told_.block_open && id == told_.block.id && area.open().id != 0;
    switch (in_.below(4)) {
      case 0: {
        const std::size_t size = in_.below(400);
        const std::vector<std::uint8_t> data(size, 0x5A);
        require(!area.allow(id, data, static_cast<std::uint16_t>(in_.below(64))) || open,
                "the open block alone is allowed");
        return;
      }
      case 1: {
        const bool could = open && told_.complete;
        require(!area.take(id) || could, "a complete block alone is taken");
        return;
      }
      case 2: {
        const std::array<std::uint8_t, 6> data = {1, 2, 3, 4, 5, 6};
        const bool upload = told_.block.direction == AskedBlock::Direction::upload;
        const auto bytes = std::span(data).first(upload ? std::min<std::size_t>(told_.step.bytes, 6) : 0);
        const bool done = area.step(id, bytes);
        require(!done || (open && told_.step_open), "a telegram that was asked for alone is done");
        if (done) told_.step_open = false;
        return;
      }
      default:
        require(area.refuse(id, static_cast<TransferError>(in_.number<std::uint16_t>())) == open,
                "an open block may be refused at any time");
    }
  }

  void move() {
    const bool beginning = transfer_.beginning();
    const auto answer = receive(encode(transfer_.next(in_)));
    if (!answer) return;
    const Decoded decoded = decode(*answer);
    transfer_.answered(std::get<TransferReply>(std::get<Telegram>(decoded)), beginning);
  }

  std::optional<can::Frame> receive(const can::Frame& frame) {
    last_ = frame;
    const bool was_open = service_.jobs().open().has_value();
    const Duration since(static_cast<std::int64_t>(in_.number<std::uint16_t>()) * 64 - 1'000'000);
    const auto answer = slave_.receive(frame, since);
    if (was_open && !service_.jobs().open()) fetched();
    if (!answer) return std::nullopt;
    require(answer->slot != AnswerSlot::response || answer->window.earliest <= answer->window.latest,
            "a response has a window");
    require(answer->window.latest - since <= std::chrono::microseconds(1210), "a window is near");
    const Duration start = std::max(since, answer->window.earliest) + std::chrono::microseconds(in_.byte());
    const bool starts = slave_.may_start(*answer, start);
    require(starts == (start <= answer->window.latest), "in its window or not at all");
    if (starts && in_.below(4) != 0) slave_.sent(answer->frame);
    return answer->frame;
  }

  /// The access is not open any more: it was dropped, or the master has its answer.
  void fetched() {
    if (!told_.parameter_open || given_ != told_.parameter.id) return;
    told_.parameter_open = false;
    told_.fetched = given_;
  }

  void check() {
    for (const Channel channel : {Channel::one, Channel::two}) {
      const ActualCounters& counters = slave_.counters(channel);
      require(counters.sent + counters.late + counters.lost + counters.not_released <= counters.asked,
              "each question has one end at most");
      require(counters.asked - counters.not_released + counters.not_asked <= counters.released,
              "each release has one end at most");
    }
    const auto& open = service_.jobs().open();
    require(told_.parameter_open == (open && open->id != 0),
            "service and application agree on the open access");
  }

  Bytes& in_;
  Told told_;
  SlaveServiceSettings settings_;
  SlaveService service_;
  Slave slave_;
  SlaveSupervision supervision_{SlaveSupervisionSettings{}};
  fuzz::Transfer transfer_;
  can::Frame last_;
  Duration now_ = std::chrono::seconds(1);
  std::uint64_t given_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes in(data, size);
  ServiceRun(in).go();
  return 0;
}
