#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "cansync/dds/convert.h"
#include "cansync/dds/topics.h"
#include "cansync/dds/validate.h"
#include "dds/daemon_identity.h"
#include "dds/endpoint.h"
#include "dds/reply_partition.h"
#include "dds/writer_identity.h"

/// Answers like the daemon, without a bus: slaves 0..3 ("slave0" .. "slave3"), parameters that keep what is
/// written, one memory per slave. A thread of its own serves it until it is destroyed.
///
/// Parameters 3400 to 3431 are refused with the cause of that number; 4000 never answers (until it is
/// cancelled), 4001 answers with "below minimum", 4002 is lost, and nothing is ever heard of it, but with
/// `answer_lost`; a transfer at address 0xDEAD00 stays open half done, a broadcast of action 199 without a
/// sign, both until they are cancelled; after `answer_nothing` every request is lost. Each object is a start
/// of its own: requests and cancels for another are only counted; reference values that are not meant for it,
/// or for another mapping than the newest, are kept apart.
class FakeDaemon {
 public:
  static constexpr std::uint32_t kSilentNumber = 4000;
  static constexpr std::uint32_t kErrorNumber = 4001;
  /// A read of this number + n is refused with cause n; with 0 as by a daemon that knows no causes.
  static constexpr std::uint32_t kRefusals = 3400;
  /// A transfer at this address is refused for a full queue the first time.
  static constexpr std::uint32_t kFullOnceAddress = 0xCA0500;
  static constexpr std::uint32_t kLostNumber = 4002;
  static constexpr std::uint32_t kEndlessAddress = 0xDEAD00;
  static constexpr std::uint32_t kSilentAction = 199;

  /// Since when it reads requests for parameters: DDS finds the endpoints of a program one by one.
  enum class ReadsParameters { at_once, later };

  explicit FakeDaemon(const gateway::dds::ParticipantOptions& options,
                      ReadsParameters reads = ReadsParameters::at_once, std::string host = "plc1")
      : participant_(options), host_(std::move(host)), reads_parameters_(reads == ReadsParameters::at_once) {
    if (reads_parameters_) parameter_reader_.emplace(participant_, &signal_);
    static std::atomic<std::uint8_t> starts = 0;
    identity_[0] = ++starts;
    for (const unsigned slave : {0u, 1u, 2u, 3u}) settings_.slaves[slave].configured = true;
    settings_.command_channel.transfer_monitoring = std::chrono::seconds(3);
    publish_state();
    thread_ = std::thread([this] { serve(); });
  }
  ~FakeDaemon() {
    stop_ = true;
    signal_.raise();
    thread_.join();
  }
  FakeDaemon(const FakeDaemon&) = delete;
  FakeDaemon& operator=(const FakeDaemon&) = delete;

  /// Reads requests for parameters from now on.
  void read_parameters() {
    reads_parameters_ = true;
    signal_.raise();
  }

  /// Modes are taken down and refused for this cause from now on.
  void refuse_modes(gateway_RefusalCause cause) { mode_refusal_ = cause; }
  /// From now on modes are taken, and answered only when no longer kept back.
  void keep_modes_back(bool kept) {
    keeps_modes_back_ = kept;
    signal_.raise();
  }
  /// The next so many commands are refused for this cause.
  void refuse_next(int commands, gateway_RefusalCause cause) {
    next_refusal_ = cause;
    refuse_next_ = commands;
  }

  /// The state of the line that is told from now on; active operation at first.
  void set_state(cansync::State state) {
    const std::lock_guard lock(mutex_);
    state_ = state;
    publish_state();
  }

  /// Commands taken so far.
  std::vector<cansync_Command> commands() const {
    const std::lock_guard lock(mutex_);
    return commands_;
  }
  /// First values of the reference values taken so far.
  std::vector<std::int32_t> references() const {
    const std::lock_guard lock(mutex_);
    return references_;
  }
  /// Intervals for which the newest of them is to be released.
  std::uint32_t released_for() const {
    const std::lock_guard lock(mutex_);
    return released_for_;
  }
  /// Samples that gave a telegram up.
  int references_given_up() const {
    const std::lock_guard lock(mutex_);
    return given_up_;
  }
  /// Samples of writers that are no stronger than the one that has the telegram.
  int references_waited() const {
    const std::lock_guard lock(mutex_);
    return waited_;
  }
  /// Samples of reference values for another start or mapping.
  int references_refused() const { return static_cast<int>(refused_references().size()); }
  /// Their first values.
  std::vector<std::int32_t> refused_references() const {
    const std::lock_guard lock(mutex_);
    return refused_;
  }
  /// From now on slave 1 bears this name: that of another, too, while names are exchanged.
  void name_slave_1(const std::string& name) {
    const std::lock_guard lock(mutex_);
    name_of_1_ = name;
    publish_state();
  }
  /// Another slave is configured, of which nothing is told yet.
  void configure_slave_4() {
    const std::lock_guard lock(mutex_);
    settings_.slaves[4].configured = true;
    publish_state();
  }
  /// Another program changes the mapping of the reference values.
  void change_mapping() {
    const std::lock_guard lock(mutex_);
    set_mapping({0x01});
  }
  std::size_t requests() const { return requests_; }
  /// Participants of other programs that are there.
  std::uint32_t programs() const { return participant_.others(); }
  const gateway::dds::DaemonIdentity& identity() const { return identity_; }
  /// Requests and cancels that were meant for another start of a daemon.
  std::size_t elsewhere() const { return elsewhere_; }
  /// Tells the state once more, as the daemon does once a second.
  void tell() {
    const std::lock_guard lock(mutex_);
    publish_state();
  }
  /// From now on every request is taken and lost.
  void answer_nothing() { answers_nothing_ = true; }
  /// Cancels of requests that nothing is known of any more.
  std::size_t cancels_in_vain() const { return cancels_in_vain_; }
  /// Answers what was lost, now.
  void answer_lost() {
    answer_lost_ = true;
    signal_.raise();
  }

  void publish_actual(std::uint8_t slave, std::uint32_t first, std::uint64_t interval = 0) {
    cansync_ActualValues values = {};
    values.slave = slave;
    values.raw[0] = first;
    values.arrived = interval != 0 ? 1 : 0;
    values.interval[0] = interval;
    (void)actual_writer_.write(values);
  }
  /// Tells what it does not tell by itself: a sample of each other topic.
  void publish_rest() {
    if (!rest_) rest_.emplace(participant_);
    (void)rest_->realtime.write({});
    (void)rest_->timing.write({});
    (void)rest_->interval.write({});
    publish_actual(2, 1, 1);
    publish_event(++rest_->events);
  }
  void publish_event(std::uint64_t number, gateway_EventSeverity severity = gateway_SEVERITY_INFO) {
    gateway_Event event = {};
    event.severity = severity;
    event.number = number;
    (void)event_writer_.write(event);
  }

 private:
  using Key = gateway::dds::RequestKey;

  /// Replies wait until everything was taken, as in the daemon: while a write waits for acknowledgements no
  /// reader may be full, or DDS does not get to them.
  template <class Reply>
  void answer(gateway::dds::Writer<Reply>& writer, Reply reply, std::vector<std::uint8_t> data = {}) {
    auto kept = std::make_shared<std::vector<std::uint8_t>>(std::move(data));
    if constexpr (requires { reply.data; }) reply.data._buffer = kept->data();
    // The client may have found this writer before its reader was found here.
    outbox_.push_back([&writer, reply, kept]() -> dds_return_t {
      return writer.matched() == 0 ? DDS_RETCODE_TIMEOUT : writer.write(reply);
    });
  }

  void deliver() {
    while (!outbox_.empty() && outbox_.front()() != DDS_RETCODE_TIMEOUT) outbox_.pop_front();
  }

  void publish_state() {
    gateway_GatewayStatus gateway = {};
    gateway::dds::copy_text(participant_.options().partition, gateway.bus);
    gateway.data_model = gateway_DATA_MODEL;
    std::copy(identity_.begin(), identity_.end(), std::begin(gateway.daemon));
    gateway::dds::copy_text("cansync-master", gateway.protocol);
    gateway::dds::copy_text(host_, gateway.host);
    (void)gateway_writer_.write(gateway);
    gateway_BusStatus bus = {};
    bus.bit_rate = cansync::slot_times(settings_.bit_rate).bits_per_second;
    (void)bus_writer_.write(bus);
    cansync_MasterStatus master = {};
    cansync::dds::fill_master_status(settings_, {}, state_, master);
    std::copy(identity_.begin(), identity_.end(), std::begin(master.daemon));
    std::copy(mapping_.begin(), mapping_.end(), std::begin(master.reference_mapping));
    master.mapping_number = mapping_number_;
    for (std::size_t i = 0; i < owners_.size(); ++i) {
      cansync_ReferenceRelease& release = master.reference_release[i];
      gateway::dds::copy_text(owners_[i].who.who, release.writer);
      release.strength = owners_[i].who.strength;
      std::copy(owners_[i].who.guid.begin(), owners_[i].who.guid.end(), std::begin(release.writer_guid));
    }
    (void)master_writer_.write(master);
    for (std::uint8_t slave = 0; slave < 4; ++slave) {
      cansync_SlaveStatus status = {};
      status.slave = slave;
      gateway::dds::copy_text(slave == 1 ? name_of_1_ : "slave" + std::to_string(slave), status.name);
      (void)slave_writer_.write(status);
    }
  }

  /// Under the lock.
  void set_mapping(const std::array<std::uint8_t, 8>& mapping) {
    if (mapping == mapping_) return;
    mapping_ = mapping;
    ++mapping_number_;
    publish_state();
  }

  cansync::dds::Limits limits_now() const {
    const std::lock_guard lock(mutex_);
    return cansync::dds::limits_of(settings_);
  }

  void serve() {
    while (!stop_) {
      (void)signal_.wait(outbox_.empty() ? 1000 : 10);
      signal_.clear();
      const cansync::dds::Limits limits = limits_now();
      if (answer_lost_.exchange(false)) {
        for (const Key& key : std::exchange(lost_, {}))
          answer(parameter_writer_, cansync::dds::parameter_reply(key, {}));
      }
      if (!keeps_modes_back_) {
        for (const Key& key : std::exchange(kept_back_, {}))
          answer(command_writer_, cansync::dds::command_reply(key, cansync::Outcome::done));
      }
      // Before the requests that they are of: those are there by then.
      std::vector<Key> cancelled;
      (void)cancel_reader_.take([&](const gateway_JobCancel& cancel) {
        if (is_mine(cancel)) cancelled.push_back(gateway::dds::key_of(cancel));
      });
      const auto answer_mine = [&](const auto& request) {
        if (is_mine(request)) answer(request, limits);
      };
      if (reads_parameters_ && !parameter_reader_) parameter_reader_.emplace(participant_, &signal_);
      if (parameter_reader_) (void)parameter_reader_->take(answer_mine);
      (void)transfer_reader_.take(answer_mine);
      (void)command_reader_.take(answer_mine);
      for (const Key& key : cancelled) end_open(key);
      take_references();
      deliver();
    }
  }

  template <class Sample>
  bool is_mine(const Sample& sample) {
    const bool mine = gateway::dds::daemon_of(sample) == identity_;
    if (!mine) ++elsewhere_;
    return mine;
  }

  void answer(const cansync_ParameterRequest& request, const cansync::dds::Limits& limits) {
    const Key key = gateway::dds::key_of(request);
    ++requests_;
    if (answers_nothing_) return lost_.push_back(key);
    if (const auto problem = check(request, limits)) {
      answer(parameter_writer_, cansync::dds::parameter_refused(key, *problem));
      return;
    }
    if (request.number >= kRefusals && request.number < kRefusals + gateway::dds::kCauses) {
      const auto cause = static_cast<gateway_RefusalCause>(request.number - kRefusals);
      answer(parameter_writer_, cansync::dds::parameter_refused(key, {cause, "not now"}));
      return;
    }
    if (request.number == kSilentNumber) {
      open_parameters_.push_back(key);
      return;
    }
    if (request.number == kLostNumber) {
      lost_.push_back(key);
      return;
    }
    cansync::ParameterResult result;
    if (request.number == kErrorNumber) {
      result.outcome = cansync::Outcome::slave_error;
      result.error = cansync::ParameterError::below_minimum;
    } else {
      std::uint32_t& value = parameters_[{request.slave, request.number}];
      if (request.write) value = request.value;
      result.value = value;
      result.doubleword = value > 0xFFFF;
      result.intervals = 1;
    }
    answer(parameter_writer_, cansync::dds::parameter_reply(key, result));
  }

  void answer(const cansync_TransferRequest& request, const cansync::dds::Limits& limits) {
    const Key key = gateway::dds::key_of(request);
    ++requests_;
    if (answers_nothing_) return lost_.push_back(key);
    if (const auto problem = check(request, limits)) {
      answer(transfer_writer_, cansync::dds::transfer_refused(key, *problem));
      return;
    }
    if (request.address == kFullOnceAddress && !std::exchange(was_full_, true)) {
      answer(transfer_writer_, cansync::dds::transfer_refused(key, {gateway_CAUSE_QUEUE_FULL, "queue full"}));
      return;
    }
    answer(progress_writer_, cansync::dds::transfer_progress(key, request.length / 2, request.length));
    if (request.address == kEndlessAddress) {
      open_transfers_.push_back(key);
      return;
    }
    std::vector<std::uint8_t>& memory = memory_[request.slave];
    cansync::TransferResult result;
    result.bytes = request.length;
    if (request.direction == cansync_DIRECTION_DOWNLOAD) {
      memory.assign(request.data._buffer, request.data._buffer + request.data._length);
      answer(transfer_writer_, cansync::dds::transfer_reply(key, result, {}));
    } else {
      memory.resize(request.length);
      std::vector<std::uint8_t> data = memory;
      const auto reply = cansync::dds::transfer_reply(key, result, data);
      answer(transfer_writer_, reply, std::move(data));
    }
  }

  void answer(const cansync_Command& command, const cansync::dds::Limits& limits) {
    const Key key = gateway::dds::key_of(command);
    ++requests_;
    if (answers_nothing_) return lost_.push_back(key);
    if (const auto problem = check(command, limits)) {
      answer(command_writer_, cansync::dds::command_refused(key, *problem));
      return;
    }
    if (refuse_next_ > 0) {
      --refuse_next_;
      return answer(command_writer_, cansync::dds::command_refused(key, {next_refusal_, "not now"}));
    }
    {
      const std::lock_guard lock(mutex_);
      commands_.push_back(command);
      if (command.kind == cansync_COMMAND_REFERENCE_MAPPING) set_mapping(std::to_array(command.mapping));
    }
    if (command.kind == cansync_COMMAND_BROADCAST && command.action == kSilentAction)
      return open_commands_.push_back(key);
    if (command.kind == cansync_COMMAND_MODE && keeps_modes_back_) return kept_back_.push_back(key);
    if (command.kind == cansync_COMMAND_MODE && mode_refusal_ != gateway_CAUSE_NONE)
      return answer(command_writer_, cansync::dds::command_refused(key, {mode_refusal_, "not now"}));
    answer(command_writer_, cansync::dds::command_reply(key, cansync::Outcome::done));
  }

  void end_open(const Key& key) {
    if (std::find(lost_.begin(), lost_.end(), key) != lost_.end()) ++cancels_in_vain_;
    if (std::erase(open_parameters_, key) != 0) {
      answer(parameter_writer_, cansync::dds::parameter_reply(key, {.outcome = cansync::Outcome::cancelled}));
    }
    if (std::erase(open_transfers_, key) != 0) {
      answer(transfer_writer_,
             cansync::dds::transfer_reply(key, {.outcome = cansync::Outcome::cancelled, .bytes = 0}, {}));
    }
    if (std::erase(open_commands_, key) != 0)
      answer(command_writer_, cansync::dds::command_reply(key, cansync::Outcome::cancelled));
  }

  void take_references() {
    const std::lock_guard lock(mutex_);
    while (reference_reader_.take_batch(
               [&](const cansync_ReferenceValues& values, const dds_sample_info_t& info) {
                 if (info.valid_data) return take(values, info.publication_handle);
                 // Keys of the library are GUIDs.
                 const Owner& owner = owners_[values.telegram == 2 ? 1 : 0];
                 if (std::equal(owner.who.guid.begin(), owner.who.guid.end(), std::begin(values.writer)))
                   give(values.telegram, {});
               }) == gateway::dds::ReaderBase::kBatch) {
    }
  }

  void take(const cansync_ReferenceValues& values, dds_instance_handle_t writer) {
    Owner& owner = owners_[values.telegram == 2 ? 1 : 0];
    if (values.given_up) {
      ++given_up_;
      if (owner.writer == writer) give(values.telegram, {});
    } else if (!std::equal(identity_.begin(), identity_.end(), std::begin(values.daemon)) ||
               values.mapping_number != mapping_number_) {
      refused_.push_back(values.value[0]);
    } else {
      const auto who = identify_writer(participant_, reference_reader_.handle(), writer);
      if (who && (owner.writer == 0 || who->strength > owner.who.strength))
        give(values.telegram, {writer, *who});
      if (owner.writer != writer) {
        ++waited_;
        return;
      }
      references_.push_back(values.value[0]);
      released_for_ = values.release_intervals;
    }
  }

  struct Owner {
    dds_instance_handle_t writer = 0;
    gateway::dds::WriterIdentity who = {};
  };

  /// The telegram is this one's from now on.
  void give(unsigned telegram, const Owner& owner) {
    if (telegram != 1 && telegram != 2) return;
    owners_[telegram - 1] = owner;
    publish_state();
  }

  cansync::MasterSettings settings_;
  std::array<std::uint8_t, 16> identity_ = {};
  gateway::dds::Participant participant_;
  const std::string host_;
  std::atomic<bool> reads_parameters_;
  gateway::dds::DataSignal signal_;
  std::optional<gateway::dds::Reader<cansync_ParameterRequest>> parameter_reader_;
  gateway::dds::Reader<cansync_TransferRequest> transfer_reader_{participant_, &signal_};
  gateway::dds::Reader<cansync_Command> command_reader_{participant_, &signal_};
  gateway::dds::Reader<gateway_JobCancel> cancel_reader_{participant_, &signal_};
  gateway::dds::Reader<cansync_ReferenceValues> reference_reader_{participant_, &signal_};
  // One writer for all clients is enough for a few.
  const gateway::dds::Partitions clients_{
      gateway::dds::every_reply_partition(participant_.options().partition)};
  gateway::dds::Writer<cansync_ParameterReply> parameter_writer_{participant_, clients_, nullptr};
  gateway::dds::Writer<cansync_TransferReply> transfer_writer_{participant_, clients_, nullptr};
  gateway::dds::Writer<cansync_TransferProgress> progress_writer_{participant_, clients_, nullptr};
  gateway::dds::Writer<cansync_CommandReply> command_writer_{participant_, clients_, nullptr};
  gateway::dds::Writer<gateway_GatewayStatus> gateway_writer_{participant_};
  gateway::dds::Writer<gateway_BusStatus> bus_writer_{participant_};
  gateway::dds::Writer<cansync_MasterStatus> master_writer_{participant_};
  gateway::dds::Writer<cansync_SlaveStatus> slave_writer_{participant_};
  gateway::dds::Writer<cansync_ActualValues> actual_writer_{participant_};
  gateway::dds::Writer<gateway_Event> event_writer_{participant_};

  struct Rest {
    explicit Rest(const gateway::dds::Participant& participant)
        : realtime(participant), timing(participant), interval(participant) {}
    gateway::dds::Writer<gateway_RealtimeStatus> realtime;
    gateway::dds::Writer<cansync_Timing> timing;
    gateway::dds::Writer<cansync_Interval> interval;
    std::uint64_t events = 1000;
  };
  std::optional<Rest> rest_;

  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> parameters_;
  std::map<std::uint32_t, std::vector<std::uint8_t>> memory_;
  std::vector<Key> open_parameters_;
  std::vector<Key> open_transfers_;
  std::vector<Key> open_commands_;
  std::vector<Key> lost_;
  std::vector<Key> kept_back_;  ///< commands
  std::deque<std::function<dds_return_t()>> outbox_;

  mutable std::mutex mutex_;
  std::vector<cansync_Command> commands_;
  std::vector<std::int32_t> references_;
  std::uint32_t released_for_ = 0;
  int given_up_ = 0;
  int waited_ = 0;
  std::array<Owner, 2> owners_ = {};
  std::vector<std::int32_t> refused_;
  std::array<std::uint8_t, 8> mapping_ = {};
  cansync::State state_ = cansync::State::active_master;
  std::uint64_t mapping_number_ = 1;
  std::string name_of_1_ = "slave1";
  std::atomic<std::size_t> requests_ = 0;
  std::atomic<std::size_t> elsewhere_ = 0;
  std::atomic<std::size_t> cancels_in_vain_ = 0;
  std::atomic<bool> answer_lost_ = false;
  std::atomic<bool> answers_nothing_ = false;
  std::atomic<bool> keeps_modes_back_ = false;
  std::atomic<bool> stop_ = false;
  bool was_full_ = false;  // thread of the daemon only
  std::atomic<gateway_RefusalCause> mode_refusal_ = gateway_CAUSE_NONE;
  std::atomic<gateway_RefusalCause> next_refusal_ = gateway_CAUSE_NONE;
  std::atomic<int> refuse_next_ = 0;
  std::thread thread_;
};
