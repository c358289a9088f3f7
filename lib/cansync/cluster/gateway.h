#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "cansync/cluster/gateway_jobs.h"
#include "cansync/cluster/sub_slaves.h"
#include "cansync/master.h"
#include "cansync/slave/slave.h"

namespace cansync {

/// How a gateway passes jobs on.
struct GatewaySettings {
  /// The gateway's own CANsync number (O 7.1.1), which as a sub-slave address means itself, like 0; 0: it has
  /// none.
  SubSlave own_number;
  std::vector<SubSlaveRoute> routes;
  /// Of a parameter job on the lower bus, from its submission on: time behind jobs of others counts. Shorter
  /// than that of the asker, or nobody learns why it failed.
  Duration monitoring = std::chrono::seconds(2);
  /// Of a block on the lower bus, from its submission on, with one repetition; likewise shorter.
  Duration block_monitoring = std::chrono::seconds(20);
  /// A parameter job that nobody asks about for so long is dropped, with what came of it: its answer would be
  /// too old. Longer than any master pauses between two questions.
  Duration asker_gone = std::chrono::seconds(5);
  Duration transfer_gone = std::chrono::seconds(30);  ///< likewise a block
  /// The same write again within `asker_gone` after its answer, which was never on the bus, and nothing else in
  /// between, is the question of a master that did not get the answer: it gets it again, and nothing is
  /// written. false: it is written again.
  bool remembers_writes = true;
};

/// What a gateway has counted since its start.
struct GatewayCounters {
  std::uint64_t parameters = 0;  ///< jobs that went down
  std::uint64_t transfers = 0;   ///< blocks that went down
  std::uint64_t unknown = 0;     ///< questions for a sub-slave that is not in the table
  std::uint64_t repeated = 0;    ///< writes that were answered from memory, and not given below again
};

/// Stands between a slave of the upper bus and the master of the lower one (O 7.1.1, M 3.2.1.3): what is
/// asked under a sub-slave address goes down as a job of the lower master, is busy above meanwhile, and its
/// value, format or error code goes up unchanged. What is dropped or cancelled above is cancelled below.
/// Everything else is the own application's, and every job under an id below `kGatewayJobs` the listener's.
/// Actions, control words and process data do not cross. Unknown sub-slaves are answered 0xFFFB and 0x0104.
///
/// One thread owns slave, gateway and master. Nothing allocates, blocks or throws after construction.
class ClusterGateway final : public SlaveApplication, public MasterListener {
 public:
  /// `serve` and `tell` come before anything else.
  ClusterGateway(const GatewaySettings& settings, Duration interval);

  /// Who answers for the gateway itself; must outlive the gateway.
  void serve(SlaveApplication& own) noexcept { own_ = &own; }
  /// Who is told of the lower bus; must outlive the gateway.
  void tell(MasterListener& below) noexcept { below_ = &below; }
  /// The lower master, which was made with this as its listener; before the first interval.
  void attach(Master& lower) noexcept { lower_ = &lower; }
  /// Interval `now` begins.
  void begin_interval(IntervalNumber now) noexcept;
  /// Drops what is open below, and forgets what was answered.
  void forget() noexcept;
  /// The lower master has handed over this telegram of its command slot.
  void sent_below(const can::Frame& frame) noexcept;

  /// Counters as of this call; they go on changing.
  const GatewayCounters& counters() const noexcept { return counters_; }
  /// The gateway's own CANsync number; 0: it has none.
  SubSlave own_number() const noexcept { return own_number_; }
  /// Jobs of the gateway that run below now: a parameter and a transfer at most.
  unsigned running() const noexcept {
    return (parameter_.running() != 0 ? 1u : 0u) + (block_.running() != 0 ? 1u : 0u);
  }

 private:
  // --- the slave above
  ParameterAnswer read_parameter(ParameterNumber number, Element element, SubSlave sub) noexcept override;
  ParameterAnswer write_parameter(ParameterNumber number, Element element, SubSlave sub, bool doubleword,
                                  std::uint32_t value) noexcept override;
  void parameter_dropped() noexcept override;
  /// Of a sub-slave's answer the gateway has the one memory, and knows what ends it.
  bool keeps_answer() noexcept override { return own_parameter_ && own_->keeps_answer(); }
  BlockAnswer begin_block(const TransferInitialise& initialise) noexcept override;
  bool block_open() const noexcept override { return !own_block_ || own_->block_open(); }
  BlockAnswer read_block(std::uint16_t offset, std::span<std::uint8_t> out) noexcept override;
  BlockAnswer write_block(std::uint16_t offset, std::span<const std::uint8_t> data) noexcept override;
  void end_block(bool complete) noexcept override;
  void parameter_answered() noexcept override;
  void transfer_answered() noexcept override;
  void transfer_dropped() noexcept override {
    if (own_block_) own_->transfer_dropped();
  }
  void sync_activated() noexcept override { own_->sync_activated(); }
  void control_word(std::uint16_t word) noexcept override { own_->control_word(word); }
  void action(std::uint8_t command, std::uint8_t data_byte, std::uint16_t data_word) noexcept override {
    own_->action(command, data_byte, data_word);
  }

  // --- the master below
  void actual_values(SlaveNumber slave, const ActualValues& values) noexcept override {
    below_->actual_values(slave, values);
  }
  void slave_status(SlaveNumber slave, const SlaveStatus& status) noexcept override {
    below_->slave_status(slave, status);
  }
  void state_changed(State from, State to, ControlCommand command) noexcept override;
  void parameter_done(JobId id, const ParameterResult& result) noexcept override;
  void transfer_progress(JobId id, std::uint32_t bytes) noexcept override;
  void transfer_done(JobId id, const TransferResult& result) noexcept override;
  void command_done(JobId id, Outcome outcome) noexcept override { below_->command_done(id, outcome); }
  void event(const MasterEvent& event) noexcept override;
  void reference_beyond_limit(Channel channel, const LimitViolation& beyond) noexcept override;

  bool is_own(SubSlave sub) const noexcept { return sub.value == 0 || sub == own_number_; }
  ParameterAnswer ask_below(ParameterRequest request, SubSlave sub) noexcept;

  SubSlave own_number_;
  SubSlaveTable table_;
  SlaveApplication* own_ = nullptr;
  MasterListener* below_ = nullptr;
  Master* lower_ = nullptr;
  JobId ids_ = kGatewayJobs;
  bool own_parameter_ = true;  ///< the newest parameter question was the own application's
  bool own_block_ = true;      ///< likewise the newest block
  GatewayParameter parameter_;
  GatewayBlock block_;
  GatewayCounters counters_;
};

}  // namespace cansync
