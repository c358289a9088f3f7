// The whole master, fed with any frames at any times, requests, commands and settings in any order.
#include <array>
#include <memory>
#include <vector>

#include "bytes.h"
#include "cansync/settings/settings_check.h"
#include "cansync/settings/timing.h"
#include "frames.h"
#include "master_model.h"

namespace {

using namespace cansync;
using fuzz::Bytes;
using fuzz::JobLedger;
using fuzz::require;

constexpr unsigned kMostIntervals = 2000;

Cursor cursor(Bytes& in) {
  return {static_cast<Cursor::Kind>(in.below(3)), *SlaveNumber::from(in.below(kSlaves))};
}

ProcessMapping mapping(Bytes& in) {
  ProcessMapping out = {default_mapping(Channel::one), default_mapping(Channel::two)};
  for (TelegramMapping& telegram : out)
    for (WordMapping& word : telegram.word)
      if (const auto given = from_register(in.byte())) word = *given;
  return out;
}

MasterSettings settings(Bytes& in) {
  MasterSettings out;
  const unsigned slaves = 1 + in.below(4);
  out.bit_rate = static_cast<BitRate>(in.below(kSlotTimes.size()));
  out.send_margin = default_send_margin(out.bit_rate);
  out.process.maximum_slave = *SlaveNumber::from(slaves - 1);
  for (unsigned i = 0; i < slaves; ++i) out.slaves[i].configured = true;
  const std::uint8_t bits = in.byte();
  out.process.full_length = (bits & 1) != 0;
  out.process.poll_without_reference = (bits & 2) != 0;
  out.command_channel.serving = (bits & 4) != 0 ? Serving::scan : Serving::work_conserving;
  out.command_channel.repeat_unanswered_writes = (bits & 8) != 0;
  out.command_channel.address_step = (bits & 16) != 0 ? 4 : 1;
  out.command_channel.minimum_share = (bits & 32) != 0 ? 0 : 2;
  out.startup.enable = static_cast<EnableRule>((bits >> 6) % 3);
  out.command_channel.parameter_queue = 8;
  out.command_channel.transfer_queue = 4;
  out.command_channel.broadcast_queue = 2;
  out.command_channel.telegram_repeats = in.byte() & 3;
  out.command_channel.block_retries = in.byte() & 3;
  const std::uint8_t lost = in.byte();
  out.startup.lost_after = static_cast<std::uint8_t>(1 + (lost & 3));
  SlaveSettings& first = out.slaves[0];
  first.on_return = static_cast<OnReturn>((lost >> 2) % 3);
  first.return_count = (lost >> 4) & 3;
  // No job writes this value.
  for (unsigned i = 0; i < first.return_count; ++i)
    first.return_parameters[i] = {*ParameterNumber::from(10 + i), 0xFFF0};
  return out;
}

class Run {
 public:
  explicit Run(Bytes& in) : in_(in), settings_(settings(in)), rules_(settings_) {
    require(check(settings_).empty(), "the settings are good");
    master_ = std::make_unique<Master>(settings_, ledger_);
  }

  void go() {
    while (!in_.empty() && intervals_ < kMostIntervals) {
      step();
      check_state();
    }
    master_->control(ControlCommand::cold_restart);
    for (const auto kind : {JobLedger::Kind::parameter, JobLedger::Kind::transfer, JobLedger::Kind::command})
      require(ledger_.open(kind) == 0, "every job ends when the master leaves synchronous operation");
    require(master_->open_parameter_jobs() == 0 && master_->open_transfers() == 0, "no job is left");
  }

 private:
  void step() {
    switch (in_.below(16)) {
      case 0:
        return control(static_cast<ControlCommand>(1u << in_.below(8)));
      case 1:
        return control(ControlCommand::cold_restart);
      case 2:
        return start();
      case 3:
        return submit_parameter();
      case 4:
        return submit_transfer();
      case 5:
        return submit_command();
      case 6:
        return submit_reference();
      case 7:
        return cancel();
      case 8:
        return change_settings();
      case 9:
        return receive(fuzz::frame(in_));
      case 10:
        return answer();
      case 11:
        return master_->bus_lost();
      case 12:
        interval_ += in_.number<std::uint32_t>();
        return interval(in_.byte());
      case 13:
        for (unsigned n = in_.byte(); n > 0; --n) interval(0);
        return;
      case 14:
        static_cast<void>(master_->release(*SlaveNumber::from(in_.below(2)), in_.flag()));
        return;
      default:
        return interval(in_.byte());
    }
  }

  void control(ControlCommand command) {
    static_cast<void>(master_->control(command, in_.flag()));
    if (!is_active(master_->state())) rules_.stopped();
  }

  /// Into active operation, which few inputs would reach.
  void start() {
    for (const auto command : {ControlCommand::handshake, ControlCommand::take_over_initialisation,
                               ControlCommand::start_synchronous, ControlCommand::enable_active})
      static_cast<void>(master_->control(command, true));
    if (!is_active(master_->state())) rules_.stopped();
  }

  Duration since_sync() { return Duration(in_.number<std::int32_t>()); }

  /// One interval; bit n of `skip`: the telegram of slot n is left out.
  void interval(unsigned skip) {
    ++intervals_;
    master_->begin_interval(interval_++);
    for (const Slot slot : {Slot::reference_one, Slot::reference_two, Slot::command}) {
      require(master_->planned_start(slot) <= master_->latest_start(slot), "planned before the latest start");
      const auto frame = master_->take(slot);
      if (!frame) continue;
      if (((skip >> static_cast<unsigned>(slot)) & 1u) != 0) {
        master_->left_out(slot);
        continue;
      }
      rules_.check(slot, *frame, master_->state());
      master_->sent(slot);
      if (slot == Slot::command) last_command_ = *frame;
      if ((skip & 8u) == 0) master_->transmitted(*frame, master_->planned_start(slot) + Duration(100'000));
    }
  }

  void receive(const can::Frame& frame) {
    const Decoded decoded = decode(frame);
    if (const auto* telegram = std::get_if<Telegram>(&decoded)) {
      if (const auto* reply = std::get_if<ParameterReply>(telegram))
        if (reply->busy) rules_.answered_busy(reply->slave);
      master_->receive(frame, since_sync());
      return;
    }
    const auto error = static_cast<unsigned>(std::get<DecodeError>(decoded));
    const std::uint64_t rejected = master_->counters().rejected[error];
    const std::uint64_t ended = ledger_.ended();
    master_->receive(frame, since_sync());
    require(master_->counters().rejected[error] == rejected + 1, "a rejected frame is counted by its kind");
    require(ledger_.ended() == ended, "a rejected frame ends no job");
  }

  /// An answer that fits the last command, or nearly.
  void answer() {
    can::Frame frame = last_command_;
    frame.id = (frame.id & 0x1Fu) | identifier::response;
    const std::uint8_t how = in_.byte();
    if ((frame.data[0] & 0x80) != 0) {
      frame.data[0] &= 0x8F;  // the offset's upper bits
      frame.dlc = (how & 1) != 0 ? 2 : 8;
    } else {
      frame.data[0] &= 0x0F;
      frame.dlc = static_cast<std::uint8_t>(2 + 2 * (how & 3));
    }
    if ((how & 4) != 0) frame.data[0] |= 0x40;
    if ((how & 8) != 0) frame.data[0] |= 0x20;
    if ((how & 16) != 0) frame.data[1] = in_.byte();
    if ((how & 32) != 0)
      for (std::size_t i = 2; i < 8; ++i) frame.data[i] = in_.byte();
    if ((how & 64) != 0) frame.data[3] = 0x80;  // synchronized
    receive(frame);
  }

  void submit_parameter() {
    ParameterRequest request;
    request.id = ++last_id_;
    request.slave = *SlaveNumber::from(in_.below(6));
    const std::uint8_t bits = in_.byte();
    request.write = (bits & 1) != 0;
    request.format = static_cast<ParameterFormat>((bits >> 1) % 3);
    request.number = *ParameterNumber::from(in_.below(4096));
    request.sub_slave.value = (bits & 16) != 0 ? in_.byte() : 0;
    if ((bits & 32) != 0) request.element = *Element::from(in_.below(8));
    request.monitoring_time = Duration(in_.number<std::uint16_t>() * 1000LL);
    // Counts up with the jobs: each write has a value of its own.
    request.value = static_cast<std::uint32_t>(last_id_);
    if (master_->submit(request) != Refusal::none) return;
    ledger_.accepted(request.id, JobLedger::Kind::parameter);
    if (request.write && !settings_.command_channel.repeat_unanswered_writes)
      rules_.watch_write(request.value);
  }

  void submit_transfer() {
    TransferRequest request;
    request.id = ++last_id_;
    request.slave = *SlaveNumber::from(in_.below(6));
    request.direction = static_cast<TransferRequest::Direction>(in_.below(2));
    request.address = in_.number<std::uint32_t>();
    request.block_size = static_cast<std::uint16_t>(in_.below(512));
    request.monitoring_time = Duration(in_.number<std::uint16_t>() * 1000LL);
    // A buffer of exactly this size for each: the address sanitizer sees a byte too many.
    buffers_.push_back(std::make_unique<std::vector<std::uint8_t>>(in_.below(1000)));
    request.data = *buffers_.back();
    if (master_->submit(request) == Refusal::none) ledger_.accepted(request.id, JobLedger::Kind::transfer);
  }

  void submit_command() {
    const JobId id = ++last_id_;
    Refusal refusal = Refusal::none;
    if (in_.flag()) {
      refusal = master_->submit(
          ControlWordRequest{id, *SlaveNumber::from(in_.below(6)), in_.number<std::uint16_t>()});
    } else {
      BroadcastRequest request{id, static_cast<std::uint8_t>(in_.below(4)), {}};
      request.action = {{in_.number<std::uint32_t>()}, in_.byte(), in_.byte(), in_.number<std::uint16_t>()};
      refusal = master_->submit(request);
    }
    if (refusal == Refusal::none) ledger_.accepted(id, JobLedger::Kind::command);
  }

  void submit_reference() {
    ReferenceUpdate update;
    update.channel = static_cast<Channel>(in_.below(2));
    for (std::uint32_t& value : update.value) value = in_.byte();
    update.valid_mask = in_.byte();
    const std::uint8_t ahead = in_.byte();
    update.from_interval = ahead == 0 ? 0 : interval_ + ahead - 10;
    update.release_intervals = in_.number<std::uint16_t>();
    update.mapping_number = master_->mapping_number();
    if (master_->submit(update) == Refusal::none) rules_.update_accepted(update);
  }

  void cancel() {
    const JobId id = in_.number<std::uint16_t>() % (last_id_ + 2);
    const std::uint64_t ended = ledger_.ended();
    const Refusal refusal = master_->cancel(id);
    require(refusal == Refusal::none || ledger_.ended() == ended, "a refused cancel ends nothing");
  }

  void change_settings() {
    switch (in_.below(6)) {
      case 0:
        static_cast<void>(master_->set_reference_mapping(mapping(in_)));
        return;
      case 1:
        static_cast<void>(master_->set_actual_mapping(*SlaveNumber::from(in_.below(kSlaves)), mapping(in_)));
        return;
      case 2:
        static_cast<void>(master_->set_polling(static_cast<Channel>(in_.below(2)), cursor(in_)));
        return;
      case 3:
        return master_->set_maximum_slave(*SlaveNumber::from(in_.below(kSlaves)));
      case 4: {
        const Cursor control_word = cursor(in_);
        const Cursor parameter = cursor(in_);
        static_cast<void>(master_->set_command_cursors(control_word, parameter, cursor(in_)));
        return;
      }
      default:
        return master_->stop_release(static_cast<Channel>(in_.below(2)));
    }
  }

  void check_state() {
    const CommandChannelSettings& channel = settings_.command_channel;
    const std::size_t parameters = master_->open_parameter_jobs();
    const std::size_t transfers = master_->open_transfers();
    require(parameters == ledger_.open(JobLedger::Kind::parameter),
            "open parameter jobs are those not ended");
    require(transfers == ledger_.open(JobLedger::Kind::transfer), "open transfers are those not ended");
    require(parameters <= channel.parameter_queue && transfers <= channel.transfer_queue, "bounded queues");
    require(ledger_.open(JobLedger::Kind::command) <= 3u * channel.broadcast_queue + kSlaves + 1,
            "bounded queues of commands");
    if (!is_synchronous(master_->state()))
      require(parameters + transfers + ledger_.open(JobLedger::Kind::command) == 0,
              "no job is open outside synchronous operation");
  }

  Bytes& in_;
  MasterSettings settings_;
  JobLedger ledger_;
  fuzz::SendRules rules_;
  std::vector<std::unique_ptr<std::vector<std::uint8_t>>> buffers_;  // outlive the master, which writes there
  std::unique_ptr<Master> master_;
  IntervalNumber interval_ = 0;
  unsigned intervals_ = 0;
  JobId last_id_ = 0;
  can::Frame last_command_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes in(data, size);
  Run(in).go();
  return 0;
}
