#pragma once

#include <array>
#include <cstdint>
#include <map>

#include "cansync/master.h"
#include "require.h"

namespace fuzz {

/// What the master has taken on and how it ended: every accepted job ends once, and nothing else ends.
class JobLedger : public cansync::MasterListener {
 public:
  enum class Kind : std::uint8_t { parameter, transfer, command };

  void accepted(cansync::JobId id, Kind kind) { open_.emplace(id, kind); }
  std::size_t open(Kind kind) const noexcept {
    std::size_t n = 0;
    for (const auto& [id, of] : open_) n += of == kind ? 1 : 0;
    return n;
  }
  /// Everything told so far, of any kind.
  std::uint64_t told() const noexcept { return told_; }
  std::uint64_t ended() const noexcept { return ended_; }

  void actual_values(cansync::SlaveNumber, const cansync::ActualValues& values) noexcept override {
    ++told_;
    require(values.arrived[0] != values.arrived[1], "one telegram brings each update");
  }
  void slave_status(cansync::SlaveNumber, const cansync::SlaveStatus& status) noexcept override {
    ++told_;
    require(!status.synchronized || status.responds || status.status_known,
            "a silent slave is not synchronized");
  }
  void state_changed(cansync::State, cansync::State, cansync::ControlCommand) noexcept override { ++told_; }
  void parameter_done(cansync::JobId id, const cansync::ParameterResult&) noexcept override {
    end(id, Kind::parameter);
  }
  void transfer_progress(cansync::JobId id, std::uint32_t) noexcept override {
    ++told_;
    require(open_.contains(id), "progress is of an open transfer");
  }
  void transfer_done(cansync::JobId id, const cansync::TransferResult& result) noexcept override {
    end(id, Kind::transfer);
    require(result.bytes < 1000, "no more bytes than asked for");
  }
  void command_done(cansync::JobId id, cansync::Outcome) noexcept override { end(id, Kind::command); }
  void event(const cansync::MasterEvent&) noexcept override { ++told_; }

 private:
  void end(cansync::JobId id, Kind kind) noexcept {
    ++told_;
    ++ended_;
    const auto found = open_.find(id);
    require(found != open_.end(), "a job ends once, and only when it was accepted");
    require(found->second == kind, "a job ends as what it was");
    open_.erase(found);
  }

  std::map<cansync::JobId, Kind> open_;
  std::uint64_t told_ = 0;
  std::uint64_t ended_ = 0;
};

/// Counts what may stand on the bus: the reference values released, and how often a write was sent.
class SendRules {
 public:
  explicit SendRules(const cansync::MasterSettings& settings) : settings_(settings) {}

  void update_accepted(const cansync::ReferenceUpdate& update) noexcept {
    released_[cansync::index(update.channel)] += update.release_intervals;
  }
  void stopped() noexcept { released_ = {}; }
  void answered_busy(cansync::SlaveNumber slave) noexcept { busy_[slave.value()] = true; }
  /// A write that carries `value`, which no other job has, may go out once.
  void watch_write(std::uint32_t value) { writes_.emplace(value, 0u); }

  void check(cansync::Slot slot, const can::Frame& frame, cansync::State state) {
    using namespace cansync;
    require(frame.is_standard_data() && frame.dlc <= 8, "a telegram is a data frame");
    require(is_synchronous(state), "nothing is sent outside synchronous operation");
    const Decoded decoded = decode(frame);
    require(std::holds_alternative<Telegram>(decoded), "what is sent is a telegram");
    const Telegram& telegram = std::get<Telegram>(decoded);
    if (slot != Slot::command) {
      const auto* reference = std::get_if<ReferenceTelegram>(&telegram);
      require(reference != nullptr, "a reference slot carries reference values");
      check(*reference, slot, state);
      return;
    }
    require(!std::holds_alternative<ReferenceTelegram>(telegram) &&
                !std::holds_alternative<ActualTelegram>(telegram) &&
                !std::holds_alternative<ParameterReply>(telegram) &&
                !std::holds_alternative<TransferReply>(telegram),
            "the command slot carries commands");
    if (const auto* command = std::get_if<ParameterCommand>(&telegram)) check_write(*command);
  }

 private:
  void check(const cansync::ReferenceTelegram& reference, cansync::Slot slot, cansync::State state) noexcept {
    using namespace cansync;
    require(is_active(state), "reference values are sent in active operation alone");
    require((slot == Slot::reference_one) == (reference.channel == Channel::one), "each in its slot");
    if (settings_.process.poll_without_reference && reference.words == 0) return;  // asks, and says nothing
    std::uint64_t& left = released_[index(reference.channel)];
    require(left > 0, "no reference value is sent oftener than released");
    --left;
  }
  void check_write(const cansync::ParameterCommand& command) {
    if (command.kind == cansync::ParameterCommand::Kind::read) return;
    const auto found = writes_.find(command.value);
    if (found == writes_.end()) return;
    require(found->second == 0 || busy_[command.slave.value()], "a write is sent once");
    ++found->second;
  }

  const cansync::MasterSettings& settings_;
  std::array<std::uint64_t, cansync::kChannels> released_ = {};
  std::array<bool, cansync::kSlaves> busy_ = {};
  std::map<std::uint32_t, unsigned> writes_;
};

}  // namespace fuzz
