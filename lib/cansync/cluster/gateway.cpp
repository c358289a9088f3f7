#include "cansync/cluster/gateway.h"

#include <algorithm>
#include <variant>

#include "cansync/cluster/gateway_answers.h"

namespace cansync {
namespace {

GatewayTimes gateway_times(const GatewaySettings& settings, Duration interval) noexcept {
  const auto intervals = [interval](Duration time) {
    return static_cast<IntervalNumber>(std::max<Duration::rep>(time / interval, 1));
  };
  return {.monitoring = settings.monitoring,
          .longest = intervals(settings.monitoring),
          .block_monitoring = settings.block_monitoring,
          .longest_block = intervals(settings.block_monitoring),
          .asker_gone = intervals(settings.asker_gone),
          .transfer_gone = intervals(settings.transfer_gone),
          .remembers_writes = settings.remembers_writes};
}

}  // namespace

ClusterGateway::ClusterGateway(const GatewaySettings& settings, Duration interval)
    : own_number_(settings.own_number),
      table_(settings.routes),
      parameter_(gateway_times(settings, interval)),
      block_(gateway_times(settings, interval)) {}

void ClusterGateway::begin_interval(IntervalNumber now) noexcept {
  parameter_.at(now, *lower_);
  block_.at(now, *lower_);
}

void ClusterGateway::forget() noexcept {
  parameter_.forget(*lower_);
  block_.end(false, *lower_);
}

// --- parameters

ParameterAnswer ClusterGateway::ask_below(ParameterRequest request, SubSlave sub) noexcept {
  const auto route = table_.find(sub);
  if (!route) {
    ++counters_.unknown;
    parameter_.asked_else();
    return ParameterAnswer::refused(ParameterError::not_present);
  }
  request.slave = route->slave;
  request.sub_slave = route->below;
  const JobId before = parameter_.running();
  const ParameterAnswer answer = parameter_.ask(request, *lower_, ids_);
  counters_.repeated = parameter_.repeated();
  if (parameter_.running() != 0 && parameter_.running() != before) ++counters_.parameters;
  return answer;
}

ParameterAnswer ClusterGateway::read_parameter(ParameterNumber number, Element element,
                                               SubSlave sub) noexcept {
  own_parameter_ = is_own(sub);
  if (own_parameter_) {
    parameter_.asked_else();
    return own_->read_parameter(number, element, {});
  }
  ParameterRequest request;
  request.number = number;
  request.element = element;
  return ask_below(request, sub);
}

ParameterAnswer ClusterGateway::write_parameter(ParameterNumber number, Element element, SubSlave sub,
                                                bool doubleword, std::uint32_t value) noexcept {
  own_parameter_ = is_own(sub);
  if (own_parameter_) {
    parameter_.asked_else();
    return own_->write_parameter(number, element, {}, doubleword, value);
  }
  ParameterRequest request;
  request.write = true;
  request.number = number;
  request.element = element;
  request.format = doubleword ? ParameterFormat::doubleword : ParameterFormat::word;
  request.value = value;
  return ask_below(request, sub);
}

void ClusterGateway::parameter_dropped() noexcept {
  // The slave tells before it asks for the next one.
  if (own_parameter_) return own_->parameter_dropped();
  parameter_.drop(*lower_);
}

void ClusterGateway::parameter_answered() noexcept {
  if (own_parameter_) return own_->parameter_answered();
  parameter_.answered();
}

void ClusterGateway::parameter_done(JobId id, const ParameterResult& result) noexcept {
  if (id < kGatewayJobs) return below_->parameter_done(id, result);
  parameter_.done(id, result);
}

// --- what else happens below

void ClusterGateway::sent_below(const can::Frame& frame) noexcept {
  if (!parameter_.remembers()) return;
  const Decoded decoded = decode(frame);
  const auto* telegram = std::get_if<Telegram>(&decoded);
  const auto* command = telegram != nullptr ? std::get_if<ParameterCommand>(telegram) : nullptr;
  if (command != nullptr) parameter_.sent_below(*command);
}

void ClusterGateway::state_changed(State from, State to, ControlCommand command) noexcept {
  if (!is_synchronous(to)) parameter_.changed_below(SlaveMask::all());
  below_->state_changed(from, to, command);
}

void ClusterGateway::event(const MasterEvent& event) noexcept {
  using Code = MasterEvent::Code;
  const bool restarts = event.code == Code::slave_lost || event.code == Code::slave_returned;
  if (restarts && event.slave) parameter_.changed_below(SlaveMask::of(*event.slave));
  below_->event(event);
}

void ClusterGateway::reference_beyond_limit(Channel channel, const LimitViolation& beyond) noexcept {
  below_->reference_beyond_limit(channel, beyond);
}

// --- blocks

SlaveApplication::BlockAnswer ClusterGateway::begin_block(const TransferInitialise& initialise) noexcept {
  own_block_ = is_own(initialise.sub_slave);
  if (own_block_) {
    TransferInitialise own = initialise;
    own.sub_slave = {};
    return own_->begin_block(own);
  }
  const auto route = table_.find(initialise.sub_slave);
  if (!route) {
    ++counters_.unknown;
    return BlockAnswer::refused(TransferError::not_possible);
  }
  const JobId before = block_.running();
  const BlockAnswer answer = block_.begin(initialise, *route, *lower_, ids_);
  if (block_.running() != 0 && block_.running() != before) ++counters_.transfers;
  return answer;
}

SlaveApplication::BlockAnswer ClusterGateway::read_block(std::uint16_t offset,
                                                         std::span<std::uint8_t> out) noexcept {
  return own_block_ ? own_->read_block(offset, out) : block_.read(offset, out);
}

SlaveApplication::BlockAnswer ClusterGateway::write_block(std::uint16_t offset,
                                                          std::span<const std::uint8_t> data) noexcept {
  if (own_block_) return own_->write_block(offset, data);
  const JobId before = block_.running();
  const BlockAnswer answer = block_.write(offset, data, *lower_, ids_);
  if (block_.running() != 0 && block_.running() != before) ++counters_.transfers;
  return answer;
}

void ClusterGateway::end_block(bool complete) noexcept {
  if (own_block_) return own_->end_block(complete);
  block_.end(complete, *lower_);
}

void ClusterGateway::transfer_answered() noexcept {
  if (own_block_) own_->transfer_answered();
}

void ClusterGateway::transfer_progress(JobId id, std::uint32_t bytes) noexcept {
  if (id < kGatewayJobs) below_->transfer_progress(id, bytes);
}

void ClusterGateway::transfer_done(JobId id, const TransferResult& result) noexcept {
  if (id < kGatewayJobs) return below_->transfer_done(id, result);
  block_.done(id, result);
}

}  // namespace cansync
