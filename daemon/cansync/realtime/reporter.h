#pragma once

#include <cstddef>
#include <cstdint>

#include "cansync/master.h"
#include "daemon/cansync/exchange.h"
#include "daemon/loop/flight_tap.h"
#include "daemon/loop/wall_clock.h"

namespace cansyncd {

/// Carries what the master tells to the gateway. Realtime thread only; realtime safe.
class Reporter final : public cansync::MasterListener {
 public:
  /// All must outlive the reporter; `tap` may be null: no flight recorder.
  Reporter(Exchange& exchange, const WallClock& clock, FlightTap* tap) noexcept
      : exchange_(exchange), clock_(clock), tap_(tap) {}

  // --- the master's listener
  void actual_values(cansync::SlaveNumber slave, const cansync::ActualValues& values) noexcept override;
  void slave_status(cansync::SlaveNumber slave, const cansync::SlaveStatus& status) noexcept override;
  void state_changed(cansync::State from, cansync::State to,
                     cansync::ControlCommand command) noexcept override;
  void parameter_done(cansync::JobId id, const cansync::ParameterResult& result) noexcept override;
  void transfer_progress(cansync::JobId id, std::uint32_t bytes) noexcept override;
  void transfer_done(cansync::JobId id, const cansync::TransferResult& result) noexcept override;
  void command_done(cansync::JobId id, cansync::Outcome outcome) noexcept override;
  void event(const cansync::MasterEvent& event) noexcept override;
  void reference_beyond_limit(cansync::Channel channel,
                              const cansync::LimitViolation& beyond) noexcept override;

  // --- what the loop reports itself

  /// The instant that following reports carry.
  void at(cansync::IntervalNumber interval, can::Time bus_time) noexcept;
  const Moment& moment() const noexcept { return moment_; }

  /// Reports, or counts the report as lost when there is no room.
  void report(const Report& report) noexcept;

  /// A request with a JobId was not taken.
  void refused(cansync::JobId id, cansync::Refusal refusal) noexcept { answer(Refused{id, refusal}); }

  /// Nothing was sent in a slot; for the flight recorder.
  void left_out(cansync::Slot slot) noexcept {
    if (tap_ != nullptr) tap_->left_out(static_cast<std::uint32_t>(slot));
  }

  /// Notes that something was written for the gateway.
  void written() noexcept { pending_ = true; }

  /// Wakes the gateway if something was written since the last call.
  void wake_gateway() noexcept;

  /// True when one more request can be taken and its answer has room for sure.
  bool can_take() const noexcept { return exchange_.terminals.room() > unanswered_; }
  /// A request with a JobId is taken; its answer's room is reserved.
  void taken() noexcept { ++unanswered_; }

  std::uint64_t lost_reports() const noexcept { return lost_reports_; }

 private:
  void answer(const Terminal& terminal) noexcept;

  Exchange& exchange_;
  const WallClock& clock_;
  FlightTap* const tap_;
  Moment moment_;
  std::size_t unanswered_ = 0;  ///< requests taken whose terminal was not pushed yet
  std::uint64_t lost_reports_ = 0;
  bool pending_ = false;
};

}  // namespace cansyncd
