#include "daemon/cansync_slave/gateway/slave_status.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <tuple>

#include "cansync/settings/timing.h"
#include "cansync_slave/dds/convert.h"
#include "daemon/status/status_line.h"
#include "dds/bounded_text.h"

namespace cansyncd {
namespace {

std::uint64_t nanoseconds(can::Time time) noexcept {
  return static_cast<std::uint64_t>(std::max(time, can::Time{0}).count());
}

void put_answers(const SlaveSnapshot& snapshot, cansync_slave_SlaveSideStatus& sample) noexcept {
  for (unsigned channel = 0; channel < cansync::kChannels; ++channel) {
    const cansync::ActualCounters& actual = snapshot.actual[channel];
    sample.asked[channel] = actual.asked;
    sample.not_released[channel] = actual.not_released;
    sample.released[channel] = snapshot.released[channel];
    sample.not_asked[channel] = snapshot.unused[channel];
    sample.actual_sent[channel] = actual.sent;
    sample.actual_late[channel] = actual.late;
    sample.actual_lost[channel] = actual.lost;
  }
  sample.commands = snapshot.responses.asked;
  sample.answers_busy = snapshot.responses.busy;
  sample.answers_sent = snapshot.responses.sent;
  sample.answers_late = snapshot.responses.late;
  const AnswerCounters& answers = snapshot.answers;
  sample.answers_failed = answers.failed;
  sample.response_last = answers.response_last.count();
  sample.response_longest = answers.response_longest.count();
  sample.actual_margin_least = answers.margin_least.count();
}

void put_service(const ServiceCounters& service, cansync_slave_SlaveSideStatus& sample) noexcept {
  sample.jobs = service.jobs;
  sample.jobs_answered = service.jobs_answered;
  sample.jobs_dropped = service.jobs_dropped;
  sample.blocks = service.blocks;
  sample.blocks_done = service.blocks_done;
  sample.answers_unused = service.answers_unused;
  sample.jobs_lost = service.lost;
}

void put_cluster(const ClusterSnapshot& cluster, cansync_slave_SlaveSideStatus& sample) noexcept {
  gateway::dds::copy_text(cansync::name(cluster.state), sample.cluster_state);
  sample.cluster_number = cluster.own_number.value;
  sample.jobs_below = cluster.jobs.parameters;
  sample.blocks_below = cluster.jobs.transfers;
  sample.unknown_below = cluster.jobs.unknown;
  sample.repeated_below = cluster.jobs.repeated;
  sample.sync_stops = cluster.sync_losses;
  for (unsigned channel = 0; channel < cansync::kChannels; ++channel) {
    sample.lead_given[channel] = cluster.lead[channel].given;
    sample.lead_missing[channel] = cluster.lead[channel].missing;
    sample.lead_refused[channel] = cluster.lead[channel].refused;
  }
}

/// H1 to H4 (M 3.1.4.2, 3.1.4.3).
void put_indicators(const SlaveSnapshot& snapshot, can::Time interval,
                    cansync_slave_SlaveSideStatus& sample) noexcept {
  const bool locked = snapshot.sync.state == sync_line::LockState::locked;
  const bool bus_ok = snapshot.controller.state != can::ControllerState::bus_off &&
                      snapshot.controller.link == can::LinkState::up;
  const bool waiting = !snapshot.activated && !locked;
  sample.indicator_traffic = snapshot.traffic;
  sample.indicator_sync_missing = !locked;
  sample.indicator_interval =
      static_cast<std::uint8_t>(std::chrono::duration_cast<std::chrono::milliseconds>(interval).count());
  sample.indicator_fault = !bus_ok || waiting || snapshot.fault != cansync::SlaveFault::none ||
                           (snapshot.activated && !snapshot.synchronized);
}

}  // namespace

std::string_view word_of(cansync::SlaveFault fault) noexcept {
  switch (fault) {
    case cansync::SlaveFault::none:
      return "none";
    case cansync::SlaveFault::sync_lost:
      return "sync_lost";
    case cansync::SlaveFault::references_missing:
      break;
  }
  return "references_missing";
}

std::string_view word_of(cansync::SlaveReaction reaction) noexcept {
  switch (reaction) {
    case cansync::SlaveReaction::report:
      return "report";
    case cansync::SlaveReaction::quick_stop:
      return "quick_stop";
    case cansync::SlaveReaction::pulse_inhibit:
      break;
  }
  return "pulse_inhibit";
}

cansync_slave_SlaveSideStatus slave_side_status(const SlaveSnapshot& snapshot,
                                                const SlaveRoleConfig& config) noexcept {
  const can::Time interval = cansync::slot_times(config.slave.bit_rate).interval;
  cansync_slave_SlaveSideStatus sample = {};
  sample.slave_number = config.slave.number.value();
  sample.option_status = static_cast<std::uint16_t>(snapshot.state);
  sample.cansync_status = snapshot.cansync_status;
  gateway::dds::copy_text(cansync::name(snapshot.state), sample.state);
  sample.status_word = snapshot.status_word;
  sample.activated = snapshot.activated;
  sample.synchronized = snapshot.synchronized;
  gateway::dds::copy_text(word_of(snapshot.fault), sample.fault);
  gateway::dds::copy_text(word_of(snapshot.reaction), sample.reaction);
  sample.sync_mode = snapshot.sync_mode;
  sample.interval_length = nanoseconds(interval);
  sample.interval = snapshot.interval;
  sample.missing_edges = snapshot.missing_edges;
  sample.missing_in_row = snapshot.missing_in_row;
  sample.missing_references = snapshot.missing_references;
  std::copy(snapshot.reference_telegrams.begin(), snapshot.reference_telegrams.end(),
            std::begin(sample.reference_telegrams));
  put_answers(snapshot, sample);
  sample.actions = snapshot.actions;
  sample.own_number_frames = snapshot.own_number_frames;
  sample.reports_lost = snapshot.lost_reports;
  sample.bus_load = snapshot.bus_load;
  put_indicators(snapshot, interval, sample);
  sample.parameters = static_cast<std::uint32_t>(config.service.parameters.size() - 1);
  put_service(snapshot.service, sample);
  if (snapshot.cluster) put_cluster(*snapshot.cluster, sample);
  sample.status_parameter = config.status_parameter;
  if (config.parameters) {
    gateway::dds::copy_text(config.parameters->name, sample.profile);
    gateway::dds::copy_text(config.parameters->hash, sample.profile_hash);
  }
  cansync_slave::dds::put_registers(config.slave.reference_mapping, sample.reference_mapping);
  cansync_slave::dds::put_registers(config.slave.actual_mapping, sample.actual_mapping);
  return sample;
}

void put_application(const WriterArbiter& arbiter, const TakeOver& taken,
                     cansync_slave_SlaveSideStatus& sample) noexcept {
  const gateway::dds::WriterIdentity& owner = arbiter.owner().identity;
  gateway::dds::copy_text(owner.who, sample.application);
  sample.application_strength = owner.strength;
  std::copy(owner.guid.begin(), owner.guid.end(), std::begin(sample.application_writer));
  gateway::dds::copy_text(arbiter.waiting(), sample.waiting_application);
  sample.applications_refused = arbiter.refused();
  sample.taken_over = static_cast<std::uint32_t>(taken.taken.numbers.count());
  sample.takes_blocks = taken.blocks;
}

std::string slave_sentence(const SlaveSnapshot& snapshot, const SlaveRoleConfig& config) {
  std::string state = fmt::format("slave {}: {}", config.slave.number.value(), cansync::name(snapshot.state));
  switch (snapshot.fault) {
    case cansync::SlaveFault::sync_lost:
      state += "; no SYNC of the master";
      break;
    case cansync::SlaveFault::references_missing:
      state += "; no reference values";
      break;
    case cansync::SlaveFault::none:
      if (!snapshot.activated)
        state += "; not activated by the master";
      else if (!snapshot.synchronized)
        state += "; not synchronized";
  }
  BusConfig bus = config.bus;
  bus.bits_per_second = cansync::slot_times(config.slave.bit_rate).bits_per_second;
  return bus_sentence(state, snapshot.controller, bus);
}

bool differs(const SlaveSnapshot& from, const SlaveSnapshot& to) noexcept {
  const auto essence = [](const SlaveSnapshot& of) {
    return std::tuple(of.state, of.activated, of.synchronized, of.fault, of.reaction, of.status_word,
                      of.sync.state, of.traffic,
                      of.cluster ? of.cluster->state : cansync::ClusterState::stopped);
  };
  return essence(from) != essence(to);
}

}  // namespace cansyncd
