#include "daemon/cansync/status/gateway_state.h"

#include <algorithm>
#include <tuple>

#include "can/bus_names.h"
#include "cansync/dds/convert.h"
#include "daemon/cansync/state_text.h"
#include "daemon/cansync/texts/event_text.h"

namespace cansyncd {
namespace {

namespace dds = cansync::dds;
using cansync::SlaveNumber;

std::array<cansync_ValueName, cansync::kValues> names_of(const ValueConfigs& values,
                                                         const cansync::ProcessMapping& mapping) {
  const unsigned words = cansync::word_mask(mapping);
  std::array<cansync_ValueName, cansync::kValues> names = {};
  for (std::size_t i = 0; i < names.size(); ++i) {
    dds::copy_text(values[i].name, names[i].name);
    dds::copy_text(values[i].unit, names[i].unit_symbol);
    names[i].factor = values[i].factor;
    names[i].offset = values[i].offset;
    names[i].width = ((words >> i) & 1u) != 0 ? 16 : 32;
    names[i].is_signed = values[i].is_signed;
  }
  return names;
}

/// Bit n: reference value n is on the bus without a minimum, maximum or max_step.
std::uint32_t unlimited(const SettingsSnapshot& settings) {
  std::uint32_t mask = 0;
  for (const cansync::TelegramMapping& telegram : settings.reference_mapping) mask |= telegram.value_mask();
  for (unsigned i = 0; i < cansync::kValues; ++i) {
    cansync::ReferenceLimits limits = settings.reference_limits[i];
    limits.start_within.reset();
    if (limits.any()) mask &= ~(1u << i);
  }
  return mask;
}

/// What is worth a sample of MasterStatus at once; counters wait for the next second.
auto essence(const MasterSnapshot& master) {
  // Overrun, warning and bus-off; "sending" and "receiving" change all the time.
  constexpr unsigned kLastingBits = 0x00C2;
  return std::tuple(master.state, master.cansync_status & kLastingBits, master.second_master, master.access,
                    master.waits_for_command, master.configured.bits, master.responding.bits,
                    master.synchronized.bits, master.released.bits, master.wrong.bits, master.duplicate.bits,
                    master.unknown.bits);
}

constexpr TelegramClass kSlotOrder[kTelegramClasses] = {
    TelegramClass::response,      TelegramClass::reference_one, TelegramClass::actual_one,
    TelegramClass::reference_two, TelegramClass::actual_two,    TelegramClass::command};

/// -1 ns for what the slaves send.
cansync::Duration planned_start(const TimingSnapshot& timing, TelegramClass slot) {
  switch (slot) {
    case TelegramClass::reference_one:
      return timing.planned[static_cast<unsigned>(cansync::Slot::reference_one)];
    case TelegramClass::reference_two:
      return timing.planned[static_cast<unsigned>(cansync::Slot::reference_two)];
    case TelegramClass::command:
      return timing.planned[static_cast<unsigned>(cansync::Slot::command)];
    default:
      return cansync::Duration(-1);
  }
}

cansync_Timing to_dds(const TimingSnapshot& timing, const cansync::SlotTimes& times,
                      can::TimestampSource source) {
  cansync_Timing sample = {};
  sample.intervals = timing.intervals;
  sample.lateness_minimum = timing.lateness_minimum.count();
  sample.lateness_mean = timing.lateness_mean.count();
  sample.lateness_maximum = timing.lateness_maximum.count();
  // 32 bits on the topic, where readers take differences.
  std::transform(timing.histogram.begin(), timing.histogram.end(), std::begin(sample.lateness_histogram),
                 [](std::uint64_t count) { return static_cast<std::uint32_t>(count); });
  std::copy(timing.left_out.begin(), timing.left_out.end(), std::begin(sample.left_out));
  sample.missed_syncs = timing.missed_syncs;
  sample.bus_load = timing.bus_load;
  for (unsigned i = 0; i < kTelegramClasses; ++i) {
    const TelegramClass slot = kSlotOrder[i];
    const SlotSummary& seen = timing.slots[static_cast<unsigned>(slot)];
    sample.slot[i] = {seen.count,
                      seen.earliest.count(),
                      seen.mean.count(),
                      seen.latest.count(),
                      planned_start(timing, slot).count(),
                      latest_start(times, slot).count(),
                      seen.late};
  }
  dds::copy_text(name(source), sample.timestamp_source);
  return sample;
}

}  // namespace

StatePublisher::StatePublisher(const dds::Participant& participant, const Config& config,
                               const DaemonIdentity& daemon)
    : config_(config),
      daemon_(daemon),
      actual_writer_(participant),
      slave_writer_(participant),
      master_writer_(participant),
      timing_writer_(participant),
      interval_writer_(participant),
      profiles_(participant),
      settings_{cansync::in_force(config.master)} {
  master_.configured = config.master.configured();
  set_names(config);
}

void StatePublisher::set_names(const Config& config) {
  config_.references = config.references;
  config_.slaves = config.slaves;
  for (unsigned i = 0; i < cansync::kSlaves; ++i) {
    slaves_[i].names = names_of(config.slaves[i].actual, settings_.actual_mapping[i]);
    slaves_[i].dirty = slaves_[i].has_other_values = config_.master.slaves[i].configured;
  }
  master_dirty_ = true;
  profiles_.tell(config);
}

SteadyTime StatePublisher::step(Exchange& exchange, SteadyTime now) {
  take_settings(exchange);
  take_master(exchange);
  take_slaves(exchange);
  tell_other_values(now);  // before values that are by them
  take_actual(exchange);
  IntervalReport interval;
  if (exchange.interval.read(interval) && config_.dds.interval_topic) {
    (void)interval_writer_.write(
        {interval.sync.interval, interval.sync.wall_clock.count(), interval.time_left.count()});
  }
  if (exchange.timing.read(timing_)) {
    told_timing_ = to_dds(timing_, cansync::slot_times(config_.master.bit_rate), master_.timestamps);
    (void)timing_writer_.write(*told_timing_);
  }

  // Who gives the reference values changes as often as writers like.
  const bool others_give =
      givers_ != nullptr && *givers_ != told_givers_ && now - master_published_ >= kGiversPeriod;
  if (master_dirty_ || others_give || now - master_published_ >= kMasterPeriod) publish_master(now);
  SteadyTime next = master_published_ + kMasterPeriod;
  for (std::uint8_t i = 0; i < cansync::kSlaves; ++i) {
    Slave& slave = slaves_[i];
    if (!slave.dirty) continue;
    if (now - slave.published >= kSlavePeriod) {
      publish_slave(*SlaveNumber::from(i), now);
    } else {
      next = std::min(next, slave.published + kSlavePeriod);
    }
  }
  return next;
}

void StatePublisher::tell_settings(Exchange& exchange, SteadyTime now) {
  take_settings(exchange);
  if (master_dirty_) publish_master(now);
  tell_other_values(now);
}

void StatePublisher::tell_other_values(SteadyTime now) {
  for (std::uint8_t i = 0; i < cansync::kSlaves; ++i) {
    if (slaves_[i].has_other_values) publish_slave(*SlaveNumber::from(i), now);
  }
}

ToldStatus StatePublisher::told() const {
  ToldStatus told{&told_master_, {}, told_timing_ ? &*told_timing_ : nullptr, &timing_};
  for (const Slave& slave : slaves_) {
    if (slave.told_status) told.slaves.push_back(&*slave.told_status);
  }
  return told;
}

void StatePublisher::take_settings(Exchange& exchange) {
  const auto before = settings_.actual_mapping;
  if (!exchange.settings.read(settings_)) return;
  master_dirty_ = true;
  for (unsigned i = 0; i < cansync::kSlaves; ++i) {
    slaves_[i].names = names_of(config_.slaves[i].actual, settings_.actual_mapping[i]);
    slaves_[i].dirty = config_.master.slaves[i].configured;
    if (settings_.actual_mapping[i] != before[i]) slaves_[i].has_other_values = slaves_[i].dirty;
  }
}

void StatePublisher::take_master(Exchange& exchange) {
  const auto before = essence(master_);
  if (exchange.master.read(master_) && essence(master_) != before) master_dirty_ = true;
}

void StatePublisher::take_slaves(Exchange& exchange) {
  for (std::uint8_t i = 0; i < cansync::kSlaves; ++i) {
    if (exchange.slave[i].read(slaves_[i].report)) slaves_[i].dirty = config_.master.slaves[i].configured;
  }
}

void StatePublisher::take_actual(Exchange& exchange) {
  ActualReport report;
  for (std::uint8_t i = 0; i < cansync::kSlaves; ++i) {
    if (!exchange.actual[i].read(report)) continue;
    Slave& slave = slaves_[i];
    cansync::IntervalNumber newest = master_.when.interval;
    for (unsigned channel = 0; channel < cansync::kChannels; ++channel) {
      // Telegrams that came between two looks are told together.
      report.values.arrived[channel] = report.values.count[channel] != slave.told[channel];
      newest = std::max(newest, report.values.interval[channel]);
    }
    slave.told = report.values.count;
    (void)actual_writer_.write(dds::actual_values(*SlaveNumber::from(i), config_.slaves[i].name,
                                                  report.values, slave.names, newest,
                                                  report.when.wall_clock.count()));
  }
}

void StatePublisher::publish_master(SteadyTime now) {
  cansync::MasterSettings settings = config_.master;
  cansync::put_in_force(settings_, settings);

  cansync_MasterStatus& sample = told_master_;
  sample = {};
  dds::fill_master_status(settings, master_.counters, master_.state, sample);
  dds::copy_text(state_text(master_), sample.state);
  sample.cansync_status = master_.cansync_status;
  sample.interval = master_.when.interval;
  sample.second_master_frames = master_.counters.second_master;
  sample.second_master = master_.second_master;
  sample.second_master_identifier = master_.second_master_identifier;
  sample.second_master_since = master_.second_master_since.count();
  sample.slaves_configured = master_.configured.bits;
  sample.slaves_responding = master_.responding.bits;
  sample.slaves_synchronized = master_.synchronized.bits;
  sample.slaves_released = master_.released.bits;
  sample.slaves_wrong = master_.wrong.bits;
  sample.slaves_duplicate = master_.duplicate.bits;
  sample.slaves_unknown = master_.unknown.bits;
  sample.open_parameter_jobs = master_.open_parameter_jobs;
  sample.open_transfers = master_.open_transfers;
  std::copy(daemon_.begin(), daemon_.end(), std::begin(sample.daemon));
  sample.mapping_number = settings_.mapping_number;
  if (givers_ != nullptr) {
    told_givers_ = *givers_;
    fill_references(master_.release, master_.lead_axis, told_givers_, sample);
  }
  sample.references_unlimited = unlimited(settings_);
  const auto names = names_of(config_.references, settings_.reference_mapping);
  std::copy(names.begin(), names.end(), std::begin(sample.reference_value));
  (void)master_writer_.write(sample);
  master_dirty_ = false;
  master_published_ = now;
}

void StatePublisher::publish_slave(SlaveNumber number, SteadyTime now) {
  Slave& slave = slaves_[number.value()];
  const SlaveConfig& config = config_.slaves[number.value()];
  cansync_SlaveStatus& sample = slave.told_status.emplace(dds::slave_status(
      number, config.name, slave.report.status, settings_.actual_mapping[number.value()], slave.names));
  sample.status_parameter = config_.master.slaves[number.value()].status_parameter;
  dds::copy_text(held_reason(slave.report.status, config_), sample.held_reason);
  if (config.parameters != nullptr) {
    dds::copy_text(config.parameters->name, sample.profile);
    dds::copy_text(config.parameters->hash, sample.profile_hash);
  }
  (void)slave_writer_.write(sample);
  slave.dirty = slave.has_other_values = false;
  slave.published = now;
}

}  // namespace cansyncd
