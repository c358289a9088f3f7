#include "daemon/cansync_slave/realtime/slave_machine.h"

#include <algorithm>
#include <chrono>
#include <variant>

#include "cansync/telegram/telegram.h"
#include "daemon/bus/interface_status.h"

namespace cansyncd {

using cansync::ControlCommand;
using cansync::State;

namespace {

constexpr can::Time kSlaveSecond = std::chrono::seconds(1);
constexpr can::Time kSlaveStatusPeriod = std::chrono::milliseconds(100);

cansync::UpperSync followed(sync_line::LockState state) noexcept {
  switch (state) {
    case sync_line::LockState::searching:
      return cansync::UpperSync::searching;
    case sync_line::LockState::locked:
      return cansync::UpperSync::locked;
    case sync_line::LockState::holdover:
      return cansync::UpperSync::holdover;
    case sync_line::LockState::lost:
      break;
  }
  return cansync::UpperSync::lost;
}

/// Intervals that have passed; over so many it does not matter.
std::uint32_t with_more(std::uint32_t intervals, std::uint64_t more) noexcept {
  constexpr std::uint64_t kMost = cansync::SlaveSupervision::kMostMissing;
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(intervals, kMost) + std::min(more, kMost));
}

/// A restart may have entered active operation again.
bool leaves_active(State before, const SlaveOrder& order) noexcept {
  const auto* mode = std::get_if<SlaveModeOrder>(&order);
  return cansync::is_active(before) && mode != nullptr && mode->mode != SlaveMode::run &&
         mode->mode != SlaveMode::reset_can;
}

/// Likewise synchronous operation.
bool leaves_synchronous(State before, const SlaveOrder& order) noexcept {
  const auto* mode = std::get_if<SlaveModeOrder>(&order);
  return cansync::is_synchronous(before) && mode != nullptr &&
         (mode->mode == SlaveMode::stop || mode->mode == SlaveMode::restart);
}

}  // namespace

SlaveMachine::SlaveMachine(const SlaveMachineSettings& settings, can::Bus& bus, SlaveExchange& exchange)
    : bus_(bus),
      exchange_(exchange),
      slots_(cansync::slot_times(settings.slave.bit_rate)),
      tap_(settings.tap),
      cluster_(settings.cluster),
      edges_(settings.edges),
      desk_(settings.service, settings.status_parameter, settings.status_bits, exchange),
      slave_(cluster_ != nullptr ? cluster_->upper()
                                 : own_slave_.emplace(settings.slave, desk_.application())),
      commands_(slave_, bus, exchange, settings.target, cluster_ != nullptr),
      supervision_(settings.supervision),
      releases_(cluster_ != nullptr ? &cluster_->lead() : nullptr),
      sync_(settings.lock, settings.edge_every_interval, settings.inputs),
      clock_(settings.wall_clock),
      load_(slots_.bits_per_second) {
  references_.words = word_mask(settings.slave.reference_mapping);
  for (unsigned n = 0; n < cansync::kSlaves; ++n) {
    if (settings.slave.monitored[n]) monitored_[n].words = word_mask(*settings.slave.monitored[n]);
  }
  if (cluster_ != nullptr) cluster_->serve(desk_.application());
}

void SlaveMachine::begin(can::Time now) noexcept {
  clock_.adjust(bus_);
  load_.take(now);
  next_second_ = now + kSlaveSecond;
  next_status_ = now;
  snapshot_.controller = bus_.status();
  sync_.begin(bus_);
  if (edges_ != nullptr) edges_->next = sync_.next();
  set_up();
  changed_ = true;  // nobody has been told how the bus is
}

void SlaveMachine::advance(can::Time now) noexcept {
  ++turns_;
  if (tap_ != nullptr) tap_->at({turns_, now, clock_.at(now)});
  pass_edges(now);
  // An answer has microseconds, all else has time.
  if (answers_.due(now)) return;
  take_releases();
  take_command(now);
  desk_.at(moment(now));
  desk_.take_orders(now);
  sync_.look(now);
  watch_sync();
  if (now < next_second_) return;
  next_second_ = now + kSlaveSecond;
  clock_.adjust(bus_);
  snapshot_.bus_load = load_.take(now);
  snapshot_.traffic = frames_ != 0;
  frames_ = 0;
  lost_frames_ = snapshot_.controller.lost_frames();
}

/// The slave's own application enables it (M 3.2.3.3).
void SlaveMachine::set_up() noexcept {
  const State before = slave_.state();
  commands_.set_up();
  report(SlaveStateReport{moment(bus_.now()), before, slave_.state()});
  changed_ = true;
}

/// At most one at a time. Its answer is told after the state that it made.
void SlaveMachine::take_command(can::Time now) noexcept {
  const State before = slave_.state();
  const auto done = commands_.take();
  if (!done) return;
  changed_ = true;
  if (done->refusal == SlaveRefusal::none) {
    const cansync::SlaveSideSettings& settings = slave_.settings();
    references_.words = word_mask(settings.reference_mapping);
    if (const auto* listen = std::get_if<SlaveListenOrder>(&done->order))
      monitored_[listen->other.value()].words = listen->mapping ? word_mask(*listen->mapping) : 0;
    if (leaves_synchronous(before, done->order)) answers_.drop(true);
    if (leaves_active(before, done->order)) {
      answers_.drop(false);
      releases_.drop();
      supervision_.forget_references();
      end_fault(cansync::SlaveFault::references_missing, now);
    }
    tell_synchronized();
  }
  if (slave_.state() != before) report(SlaveStateReport{moment(now), before, slave_.state()});
  fill_snapshot(now);
  exchange_.status.write(snapshot_);
  // There is room: no more orders are open than it has.
  (void)exchange_.done.try_push(*done);
}

// --- edges

void SlaveMachine::pass_edges(can::Time now) noexcept {
  const SyncFollower::Passed passed = sync_.pass(now);
  if (passed.count == 0) return;
  const bool was_timed = timed_;
  timed_ = sync_.tracking();
  if (cluster_ != nullptr) lead(passed);
  if (timed_) return begin_intervals(passed);
  // What was released for an interval that never comes is released for none. Reference values grow old by the
  // own clock: a master that starts anew without edges gets its answers at once.
  if (was_timed) releases_.drop();
  slave_interval(1);
}

/// The edges of this timeline are those of the lower bus, too.
void SlaveMachine::lead(const SyncFollower::Passed& passed) noexcept {
  *edges_ = {edges_->passed + passed.count, passed.edge, sync_.next()};
  cluster_->follow(followed(sync_.snapshot().state));
}

void SlaveMachine::slave_interval(std::uint64_t passed) noexcept {
  if (cluster_ != nullptr) {
    cluster_->begin_above(edges_->passed);
  } else {
    slave_.on_sync(passed);
  }
}

void SlaveMachine::begin_intervals(const SyncFollower::Passed& passed) noexcept {
  using cansync::Channel;
  number_ = cluster_ != nullptr ? edges_->passed : number_ + passed.count;
  edge_ = passed.edge;
  if (tap_ != nullptr) tap_->edge(passed.edge, bus_.now());
  fresh_ = slave_.reference_fresh(Channel::one) || slave_.reference_fresh(Channel::two);
  // Edges that are found at once are those of a thread that stood still: what is missing says the input.
  const std::uint64_t more = passed.count - 1;
  supervision_.run_through(more);
  const std::uint32_t intervals = supervision_.edge(passed.edge, slave_.sync_activated());
  if (cansync::is_active(slave_.state()))
    (void)supervision_.references(intervals == 0 ? 0 : with_more(intervals, more), fresh_);
  heard_others_ = false;
  releases_.interval_ends(slave_, passed.count);
  slave_interval(passed.count);
  releases_.interval_begins(slave_);
}

/// What the supervision finds, and that it is over (M 3.2.0.3, O 7.2).
void SlaveMachine::watch_faults(can::Time now) noexcept {
  using cansync::SlaveFault;
  supervision_.check(now);
  SlaveFault found = supervision_.take_fault();
  for (; found != SlaveFault::none; found = supervision_.take_fault()) {
    changed_ = true;
    report(FaultReport{moment(now), found, supervision_.reaction_to(found), false});
  }
  if (supervision_.synchronized()) end_fault(SlaveFault::sync_lost, now);
  if (fresh_) end_fault(SlaveFault::references_missing, now);
}

void SlaveMachine::end_fault(cansync::SlaveFault fault, can::Time now) noexcept {
  if (!supervision_.stands(fault)) return;
  supervision_.acknowledge(fault);
  changed_ = true;
  report(FaultReport{moment(now), fault, cansync::SlaveReaction::report, true});
}

void SlaveMachine::take_releases() noexcept {
  ReleaseOrder order;
  for (unsigned i = 0; i < SlaveExchange::kReleases && exchange_.releases.try_pop(order); ++i) {
    if (order.intervals != 0) ++snapshot_.released[index(order.channel)];
    // Without intervals there is nothing to release for.
    const bool taken = timed_ && cansync::is_active(slave_.state());
    if (taken) {
      releases_.take(order, slave_);
    } else if (order.intervals != 0) {
      ++dropped_releases_[index(order.channel)];
    }
  }
}

void SlaveMachine::watch_sync() noexcept {
  const SyncSnapshot before = snapshot_.sync;
  snapshot_.sync = sync_.snapshot();
  if (snapshot_.sync.state != before.state) {
    const can::Time missing = std::max(before.holdover, snapshot_.sync.holdover);
    report(LockReport{moment(bus_.now()), snapshot_.sync.state, missing});
    changed_ = true;
  }
  if (const int error = sync_.input_error(); error != input_error_) {
    input_error_ = error;
    report(InputReport{moment(bus_.now()), error});
  }
  watch_faults(bus_.now());
  tell_synchronized();
}

/// Bit 15: the master has activated SYNC operation, and the intervals have followed its edges for a while.
void SlaveMachine::tell_synchronized() noexcept {
  const bool synchronized = slave_.sync_activated() && supervision_.synchronized();
  desk_.set_synchronized(synchronized);
  if (synchronized == synchronized_) return;
  synchronized_ = synchronized;
  changed_ = true;
  report(SynchronizedReport{moment(bus_.now()), synchronized});
}

// --- frames

void SlaveMachine::receive(const can::ReceivedFrame& received) noexcept {
  load_.add(received.frame);
  if (received.own) {
    echo_due_ = false;
    desk_.at(moment(received.end));
    slave_.sent(received.frame);
    return;
  }
  ++frames_;
  heard_others_ = true;
  // A thread that woke late finds the edge and what came after it at the same time.
  pass_edges(received.end);
  if (sync_.take_frame(received)) return;
  watch_own_number(received);
  const cansync::Decoded decoded = cansync::decode(received.frame);
  if (const auto* telegram = std::get_if<cansync::Telegram>(&decoded)) take(*telegram, received);
}

/// The edge that a frame's end counts from. Before the intervals follow the input, its newest edge says when
/// answers are due, and without any the request itself.
can::Time SlaveMachine::edge_before(can::Time end) noexcept {
  if (timed_) return edge_;
  sync_.take_edges();
  const auto newest = sync_.newest();
  if (!newest) return end;
  if (*newest <= end) return *newest;
  // It came while the thread stood still: the frame belongs to an edge whole intervals before.
  const auto back = (*newest - end - can::Time{1}) / slots_.interval + 1;
  return *newest - back * slots_.interval;
}

void SlaveMachine::take(const cansync::Telegram& telegram, const can::ReceivedFrame& received) noexcept {
  const auto* actual = std::get_if<cansync::ActualTelegram>(&telegram);
  const std::uint32_t before = actual == nullptr ? 0 : slave_.monitored_count(actual->slave, actual->channel);
  const can::Time edge = edge_before(received.end);
  desk_.at(moment(received.end));
  const auto answer = cluster_ != nullptr ? cluster_->receive_above(telegram, received.end - edge)
                                          : slave_.receive(telegram, received.end - edge);
  if (answer) answers_.add({*answer, edge, received.end});
  if (const auto* reference = std::get_if<cansync::ReferenceTelegram>(&telegram)) {
    take_reference(*reference, received.end);
  } else if (actual != nullptr) {
    take_actual(*actual, before, received.end);
  } else if (const auto* action = std::get_if<cansync::ActionCommand>(&telegram)) {
    take_action(*action, received.end);
  }
}

void SlaveMachine::take_reference(const cansync::ReferenceTelegram& telegram, can::Time end) noexcept {
  if (!cansync::is_active(slave_.state()) || telegram.words == 0) return;
  ++snapshot_.reference_telegrams[index(telegram.channel)];
  references_.took(telegram.channel, slave_.references(), number_, clock_.at(end).count());
  if (!report(ReferencesReport{references_})) ++snapshot_.lost_references;
}

void SlaveMachine::take_actual(const cansync::ActualTelegram& telegram, std::uint32_t before,
                               can::Time end) noexcept {
  if (slave_.monitored_count(telegram.slave, telegram.channel) == before) return;
  ReceivedValues& values = monitored_[telegram.slave.value()];
  values.took(telegram.channel, slave_.monitored(telegram.slave), number_, clock_.at(end).count());
  report(MonitoredReport{telegram.slave, values});
}

void SlaveMachine::take_action(const cansync::ActionCommand& action, can::Time end) noexcept {
  const auto kind = desk_.take_action();
  if (!kind) return;
  const ActionReport told{moment(end), *kind, action, ++snapshot_.actions};
  pending_ = true;
  if (!exchange_.actions.try_push(told)) {
    ++snapshot_.lost_reports;
    if (*kind == SlaveAction::control_word) exchange_.lost_control_word.write(told);
  }
  tell_synchronized();
}

/// Nobody else may send what this slave alone sends.
void SlaveMachine::watch_own_number(const can::ReceivedFrame& received) noexcept {
  namespace identifier = cansync::identifier;
  if (!received.frame.is_standard_data()) return;
  const std::uint32_t id = received.frame.identifier();
  const std::uint32_t channel = identifier::channel_of(id);
  const bool of_slaves = channel == identifier::actual_one || channel == identifier::actual_two ||
                         channel == identifier::response;
  if (!of_slaves || identifier::participant_of(id) != slave_.settings().number.value()) return;
  ++snapshot_.own_number_frames;
  if (own_number_told_) return;
  own_number_told_ = true;
  report(OwnNumberReport{moment(received.end), id});
}

void SlaveMachine::handed_over(can::SendResult result) noexcept {
  last_send_ = result;
  echo_due_ = result == can::SendResult::queued;
  answers_.handed_over(result, bus_.now());
}

// --- what others are told

bool SlaveMachine::report(const SlaveSideReport& report) noexcept {
  pending_ = true;
  if (exchange_.reports.try_push(report)) return true;
  ++snapshot_.lost_reports;
  return false;
}

void SlaveMachine::fill_snapshot(can::Time now) noexcept {
  const can::ControllerStatus before = snapshot_.controller;
  snapshot_.controller = bus_.status();
  const can::ControllerStatus& controller = snapshot_.controller;
  if (controller.state != before.state || controller.link != before.link ||
      controller.delivery != before.delivery) {
    changed_ = true;
    if (tap_ != nullptr) tap_->controller(moment(now), controller.state);
  }
  snapshot_.timestamps = bus_.timestamp_source();
  snapshot_.state = slave_.state();
  snapshot_.activated = slave_.sync_activated();
  snapshot_.synchronized = synchronized_;
  snapshot_.status_word = desk_.status_word();
  snapshot_.interval = number_;
  snapshot_.missing_edges = sync_.missing_edges();
  snapshot_.missing_in_row = supervision_.misses();
  snapshot_.missing_references = supervision_.missed_references();
  snapshot_.fault = supervision_.fault();
  snapshot_.reaction = supervision_.reaction();
  snapshot_.sync_mode = slave_.sync_mode().value_or(0);
  for (const auto channel : {cansync::Channel::one, cansync::Channel::two})
    snapshot_.actual[index(channel)] = slave_.counters(channel);
  snapshot_.responses = slave_.response_counters();
  for (const auto channel : {cansync::Channel::one, cansync::Channel::two})
    snapshot_.unused[index(channel)] = dropped_releases_[index(channel)] + releases_.unused(channel);
  snapshot_.answers = answers_.counters();
  snapshot_.service = desk_.counters();
  if (cluster_ != nullptr) {
    const cansync::ClusterGateway& gateway = cluster_->gateway();
    snapshot_.cluster = {
        cluster_->state(), gateway.own_number(), gateway.counters(), cluster_->sync_losses(), {}};
    for (const auto channel : {cansync::Channel::one, cansync::Channel::two})
      snapshot_.cluster->lead[index(channel)] = cluster_->lead().counters(channel);
  }
  snapshot_.cansync_status = interface_status({.lost_frames = controller.lost_frames() != lost_frames_,
                                               .heard_others = heard_others_,
                                               .echo_due = echo_due_,
                                               .last_send = last_send_},
                                              controller.state);
}

void SlaveMachine::publish(can::Time now) noexcept {
  if (changed_ || now >= next_status_) {
    next_status_ = now + kSlaveStatusPeriod;
    fill_snapshot(now);
    exchange_.status.write(snapshot_);
    // Nobody is woken for counters alone.
    if (changed_) pending_ = true;
    changed_ = false;
  }
  if (desk_.take_told()) pending_ = true;
  if (!pending_) return;
  pending_ = false;
  exchange_.gateway_wake.signal();
}

void SlaveMachine::end(can::Time now) noexcept {
  while (const auto done = commands_.take_stopped()) (void)exchange_.done.try_push(*done);
  const State before = slave_.state();
  (void)slave_.control(ControlCommand::cold_restart);
  report(SlaveStateReport{moment(now), before, slave_.state()});
  changed_ = true;
  publish(now);
}

}  // namespace cansyncd
