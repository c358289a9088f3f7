#include "daemon/cansync/realtime/reporter.h"

#include <utility>

#include "daemon/cansync/realtime/flight_reports.h"

namespace cansyncd {

void Reporter::at(cansync::IntervalNumber interval, can::Time bus_time) noexcept {
  moment_ = {interval, bus_time, clock_.at(bus_time)};
  if (tap_ != nullptr) tap_->at(moment_);
}

void Reporter::actual_values(cansync::SlaveNumber slave, const cansync::ActualValues& values) noexcept {
  exchange_.actual[slave.value()].write({values, moment_});
  pending_ = true;
}

void Reporter::slave_status(cansync::SlaveNumber slave, const cansync::SlaveStatus& status) noexcept {
  exchange_.slave[slave.value()].write({status, moment_});
  pending_ = true;
}

void Reporter::state_changed(cansync::State from, cansync::State to,
                             cansync::ControlCommand command) noexcept {
  report(StateChanged{moment_, from, to, command});
}

void Reporter::parameter_done(cansync::JobId id, const cansync::ParameterResult& result) noexcept {
  answer(ParameterDone{id, result});
}

void Reporter::transfer_progress(cansync::JobId id, std::uint32_t bytes) noexcept {
  report(TransferProgress{id, bytes});
}

void Reporter::transfer_done(cansync::JobId id, const cansync::TransferResult& result) noexcept {
  answer(TransferDone{id, result});
}

void Reporter::command_done(cansync::JobId id, cansync::Outcome outcome) noexcept {
  answer(CommandDone{id, outcome});
}

void Reporter::event(const cansync::MasterEvent& event) noexcept {
  report(EventReport{moment_, event});
}

void Reporter::reference_beyond_limit(cansync::Channel channel,
                                      const cansync::LimitViolation& beyond) noexcept {
  report(ReferenceRefused{moment_, channel, cansync::Refusal::beyond_limit, beyond});
}

void Reporter::report(const Report& report) noexcept {
  if (tap_ != nullptr) tell(*tap_, report);
  if (!exchange_.reports.try_push(report)) ++lost_reports_;
  pending_ = true;
}

void Reporter::answer(const Terminal& terminal) noexcept {
  // Room was reserved when the request was taken; a push that fails would be an answer nobody asked for.
  if (!exchange_.terminals.try_push(terminal)) ++lost_reports_;
  if (unanswered_ > 0) --unanswered_;
  pending_ = true;
}

void Reporter::wake_gateway() noexcept {
  if (std::exchange(pending_, false)) exchange_.gateway_wake.signal();
}

}  // namespace cansyncd
