#include "daemon/cansync_slave/segment/slave_segment.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include "can/frame_filter.h"
#include "cansync/channel/transfer_job.h"
#include "cansync/settings/settings.h"
#include "cansync/settings/timing.h"
#include "cansync/sim/drive_faults.h"
#include "cansync/sim/master_node.h"
#include "cansync_slave/config/options.h"
#include "daemon/cansync_slave/segment/slave_protocol.h"
#include "daemon/segment/segment_start.h"

namespace cansyncd {
namespace {

/// An answer without an echo for so long is taken as acknowledged by nobody.
constexpr can::Time kAnswerEchoPatience = std::chrono::seconds(1);

void add_routine(const SimulatedJob& job, const SlaveRoleConfig& config, sim::MasterNodeSettings& settings) {
  sim::MasterRoutine out;
  out.from = job.number;  // not all of them in one interval
  out.every = job.every;
  if (job.control_word) {
    cansync::ControlWordRequest request;
    request.id = job.number;
    request.slave = config.slave.number;
    request.control_word = *job.control_word;
    out.request = request;
  } else if (job.action) {
    cansync::BroadcastRequest request;
    request.id = job.number;
    request.action.slaves = cansync::SlaveMask::of(config.slave.number);
    request.action.command = *job.action;
    request.action.data_byte = job.data_byte;
    request.action.data_word = job.data_word;
    out.request = request;
  } else if (job.parameter) {
    cansync::ParameterRequest request;
    request.id = job.number;
    request.slave = config.slave.number;
    request.sub_slave = {job.sub_slave};
    request.number = *cansync::ParameterNumber::from(*job.parameter);
    request.write = job.value.has_value();
    request.value = job.value.value_or(0);
    out.request = request;
  } else {
    using Direction = cansync::TransferRequest::Direction;
    cansync::TransferRequest request;
    request.id = job.number;
    request.direction = job.download ? Direction::download : Direction::upload;
    request.slave = config.slave.number;
    request.sub_slave = {job.sub_slave};
    request.address = job.address;
    request.block_size = job.bytes;
    auto block = std::make_shared<std::vector<std::uint8_t>>(job.bytes);
    std::iota(block->begin(), block->end(), std::uint8_t{0});
    request.data = *block;
    settings.blocks.push_back(std::move(block));
    out.request = request;
  }
  settings.routines.push_back(out);
}

/// A master whose line is this slave alone: it activates it, asks for its actual values in every interval,
/// and gives reference values that move.
std::unique_ptr<sim::MasterNode> simulated_master(const SlaveRoleConfig& config) {
  sim::MasterNodeSettings settings;
  settings.master.bit_rate = config.slave.bit_rate;
  settings.master.send_margin = cansync::default_send_margin(config.slave.bit_rate);
  cansync::SlaveSettings& slave = settings.master.slaves[config.slave.number.value()];
  slave.configured = true;
  slave.status_parameter = config.status_parameter;
  slave.block_limit = std::min<std::uint16_t>(config.slave.block_limit, cansync::kLongestBlock);
  slave.actual_mapping = config.slave.actual_mapping;
  settings.master.process.reference_mapping = config.slave.reference_mapping;
  settings.master.process.maximum_slave = config.slave.number;
  settings.master.process.polling.fill({cansync::Cursor::Kind::fixed, config.slave.number});
  settings.master.startup.activate_command = config.slave.activate_command;
  settings.master.startup.activate_data = config.slave.activate_data;
  settings.first_edge = cansync::slot_times(config.slave.bit_rate).interval;
  settings.references[0] = {.kind = sim::ReferenceCurve::Kind::ramp, .step = 1};
  settings.references[1] = {.kind = sim::ReferenceCurve::Kind::constant, .offset = 1000};
  settings.references[4] = {.kind = sim::ReferenceCurve::Kind::constant, .offset = 4000};
  for (const SimulatedJob& job : config.simulated_jobs) add_routine(job, config, settings);
  return std::make_unique<sim::MasterNode>(settings);
}

sync_line::PhaseLockSettings wire_lock(const SlaveRoleConfig& config) {
  sync_line::PhaseLockSettings settings;
  settings.interval = cansync::slot_times(config.slave.bit_rate).interval;
  settings.greatest_step = config.sync.greatest_step > can::Time{0} ? config.sync.greatest_step
                                                                    : can::Time(settings.interval / 1000);
  settings.holdover = config.sync.holdover;
  return settings;
}

}  // namespace

BusPlan slave_bus_plan(const SlaveRoleConfig& config) {
  BusPlan plan;
  plan.bus = config.bus;
  plan.line = config.sim;
  // An answer has to stand on the bus within its slot, whatever the configuration says.
  plan.bus.wake_on_frame = true;
  plan.interval = kAnswerEchoPatience;
  // Everything: a slave hears the master and the slaves that it listens to, and own frames must come back.
  plan.filters = {{.mask = 0, .extended = can::FlagFilter::either, .remote = can::FlagFilter::either}};
  if (config.bus.kind != BusKind::simulated) return plan;
  plan.sim.faults = &sim::drive_faults();
  plan.sim.daemon_number = config.slave.number.value();
  plan.sim.nodes.push_back(simulated_master(config));
  return plan;
}

SlaveMachineSettings slave_machine_settings(const SlaveRoleConfig& config, FlightTap* tap,
                                            const SyncFollower::Inputs& inputs) {
  SlaveMachineSettings settings;
  settings.tap = tap;
  settings.slave = config.slave;
  settings.target = config.target;
  settings.service = config.service;
  settings.status_parameter = config.status_parameter;
  settings.status_bits = config.status_bits;
  settings.supervision = config.supervision;
  // How long edges may be missing says sync.holdover_ms: the timeline runs through until then.
  settings.supervision.edges_until_fault = 2;
  settings.inputs = inputs;
  settings.edge_every_interval = config.sync.input != SyncInput::pps;
  const bool of_line = inputs.line != nullptr && inputs.line->following();
  settings.lock = of_line ? *inputs.line->following() : wire_lock(config);
  return settings;
}

SlaveRoleFile SlaveParts::load(const config::Source& source, std::span<const std::string> overrides) {
  return checked(load_slave_config(source, overrides), sim::drive_faults());
}

std::unique_ptr<SyncLine> SlaveParts::sync_line(const SlaveRoleFile& file) {
  return make_sync_line(file.config, cansync::slot_times(file.config.slave.bit_rate).interval, file.settings,
                        file.path);
}

FlightProtocol SlaveParts::flight(const SlaveRoleConfig& config) {
  return {.interval = cansync::slot_times(config.slave.bit_rate).interval};
}

SlaveMachineSettings SlaveParts::machine_settings(const SlaveRoleConfig& config, FlightTap* tap,
                                                  const SyncSources& sync) {
  return slave_machine_settings(config, tap, sync);
}

std::string SlaveParts::words(const SlaveRoleConfig& config) {
  return fmt::format("slave {}", config.slave.number.value());
}

std::string SlaveParts::check_text(const SlaveRoleConfig& config) {
  return fmt::format("slave {} at {} bit/s\n", config.slave.number.value(), config.bus.bits_per_second);
}

const ProtocolInfo cansync_slave_protocol = {kSlaveProtocol, slave_options,
                                             load_for_deadline_segment<SlaveParts>, &slave_document_heads};

}  // namespace cansyncd
