// Order of work of one interval:
//  1. Wait for the edge, taking received frames as they come; they belong to the interval that ends.
//  2. Skip edges that have gone by: count, report, wait for the next one.
//  3. Produce the SYNC edge, account how late it was.
//  4. Take frames that came up to now, begin the interval in the master, tell the gateway.
//  5. Lead the master towards its target state.
//  6. For each slot in the order of their planned starts: take requests, wait, take what came meanwhile
//     (a bus that is looked at rarely: after WRC2 was handed over), ask the master for the telegram, and hand
//     it to the bus or leave it out when its latest start has passed.
//  7. Publish the state; once a second the timing.
// The gateway is woken before each sleep that follows a look for frames, if there is something for it.
#include "daemon/cansync/realtime/realtime_loop.h"

#include <algorithm>
#include <chrono>
#include <thread>

#include "can/frame_length.h"
#include "cansync/settings/timing.h"

namespace cansyncd {

using cansync::Slot;

namespace {

/// Requests taken while there is time to spare before a slot, and those that came in the last moment, just
/// before the telegram is built: the work they make must fit into the send margin.
constexpr unsigned kRequestsBeforeSlot = 32;
constexpr unsigned kRequestsAtSlot = 8;
/// Most frames taken at once; more cannot stand on the bus in one interval.
constexpr unsigned kFramesAtOnce = 64;

constexpr can::Time kSecond = std::chrono::seconds(1);

constexpr unsigned index(Slot slot) noexcept {
  return static_cast<unsigned>(slot);
}

}  // namespace

RealtimeLoop::RealtimeLoop(const cansync::MasterSettings& settings, const LoopSettings& loop, can::Bus& bus,
                           Exchange& exchange)
    : bus_(bus),
      exchange_(exchange),
      loop_(loop),
      interval_(cansync::slot_times(settings.bit_rate).interval),
      clock_(loop.wall_clock, loop.epoch),
      reporter_(exchange, clock_, loop.tap),
      master_(loop.cluster != nullptr ? loop.cluster->lower() : own_master_.emplace(settings, reporter_)),
      mode_(master_, bus, loop.target, loop.first_target.value_or(loop.target), loop.after_other_master,
            loop.cluster),
      requests_(exchange, master_, mode_, reporter_,
                loop.cluster != nullptr ? &loop.cluster->lead() : nullptr),
      timeline_(interval_, loop.sync_line != nullptr ? loop.sync_line->following() : std::nullopt,
                loop.cluster != nullptr ? loop.edges : nullptr),
      load_(cansync::slot_times(settings.bit_rate).bits_per_second),
      slots_(cansync::slot_times(settings.bit_rate)),
      watch_(bus, reporter_) {
  if (loop.cluster != nullptr) loop.cluster->tell(reporter_);
}

void RealtimeLoop::run() noexcept {
  begin();
  while (!stopping()) {
    sleep_until(timeline_.due());
    wake_ups_.fetch_add(1, std::memory_order_relaxed);
    decide_stop();
    if (stopping()) break;
    if (skip_missed_edges()) continue;
    begin_interval();
    mode_.pursue_target();
    requests_.finish_reset();
    for (const Slot slot : slots_in_order()) serve(slot);
    publish();
  }
  end();
}

bool RealtimeLoop::request_stop_unless_active() noexcept {
  stop_asked_.store(true);
  // An interval lasts 8 ms at most, and the main thread has nothing to do but feed the watchdog.
  while (stop_asked_.load()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return stopping();
}

/// Between two intervals, so that nothing can have enabled active operation meanwhile.
void RealtimeLoop::decide_stop() noexcept {
  if (!stop_asked_.load(std::memory_order_relaxed)) return;
  if (!cansync::is_active(master_.state())) {
    target_at_stop_ = mode_.target();
    request_stop();
  }
  stop_asked_.store(false);
}

void RealtimeLoop::begin() noexcept {
  clock_.adjust(bus_);
  const can::Time start = bus_.now() + interval_;
  timeline_.begin(start);
  if (loop_.sync_line != nullptr) loop_.sync_line->begin(bus_);
  sync_ = start - interval_;
  next_second_ = start + kSecond;
  load_.take(start);
  reporter_.at(0, start);
  watch_.begin();
  if (watch_.away()) master_.bus_away();
  requests_.publish_settings();
}

void RealtimeLoop::end() noexcept {
  reporter_.at(number_, bus_.now());
  mode_.shut_down();
  if (loop_.sync_line != nullptr) {
    loop_.sync_line->idle();
    loop_.sync_line->run(false);
  }
  requests_.refuse_all_as_stopped();
  publish();
  reporter_.written();
  reporter_.wake_gateway();
}

/// True when the edge that was waited for has gone by; the timeline's next one is then the one to wait for.
bool RealtimeLoop::skip_missed_edges() noexcept {
  const can::Time now = bus_.now();
  if (synchronous()) lateness_.add(now - timeline_.due());
  const Timeline::Missed missed = timeline_.skip_missed(now);
  if (missed.count == 0) return loop_.cluster != nullptr && missed.wait;
  if (synchronous()) {
    missed_syncs_ += missed.count;
    reporter_.at(timeline_.next(), timeline_.due());
    reporter_.report(SyncsMissed{reporter_.moment(), missed.count});
  }
  return missed.wait;
}

void RealtimeLoop::begin_interval() noexcept {
  const can::Time edge = timeline_.due();
  if (loop_.cluster != nullptr) {
    reporter_.at(timeline_.next(), edge);
    loop_.cluster->decide_sync();
  }
  if (synchronous() && looks_before_edge()) receive_frames();
  if (synchronous()) make_edge(edge);
  if (loop_.sync_line != nullptr) {
    loop_.sync_line->run(synchronous());
    if (synchronous()) loop_.sync_line->edge(bus_);
  }
  if (synchronous()) timeline_.made(bus_.now());
  receive_frames();
  sync_ = edge;
  number_ = timeline_.next();
  timeline_.advance();
  heard_others_ = false;
  reporter_.at(number_, edge);
  begun_ = synchronous();
  if (begun_) {
    begin_masters_interval();
  } else {
    master_.pass_interval(number_);
  }
  if (begun_ && loop_.report_intervals) {
    exchange_.interval.write({reporter_.moment(), master_.planned_start(Slot::reference_one)});
    reporter_.written();
  }
}

/// The first edge after silence or after edges that were missed, and in set-up one that is a frame: another
/// master may have begun since the last look.
bool RealtimeLoop::looks_before_edge() const noexcept {
  const bool is_frame = loop_.sync_line != nullptr && loop_.sync_line->makes_frame();
  const bool missed = timeline_.next() != number_ + 1;
  return !begun_ || missed || (is_frame && looks_before_sending());
}

void RealtimeLoop::begin_masters_interval() noexcept {
  if (loop_.cluster != nullptr) {
    loop_.cluster->begin_below(number_);
  } else {
    master_.begin_interval(number_);
  }
}

void RealtimeLoop::make_edge(can::Time due) noexcept {
  if (loop_.sync_wire != nullptr) loop_.sync_wire->sync_edge(due);
  if (loop_.tap != nullptr) loop_.tap->edge(due, bus_.now());
}

RealtimeLoop::Slots RealtimeLoop::slots_in_order() const noexcept {
  Slots slots = {Slot::reference_one, Slot::reference_two, Slot::command};
  std::sort(slots.begin(), slots.end(), [this](Slot a, Slot b) {
    const auto start_a = master_.planned_start(a);
    const auto start_b = master_.planned_start(b);
    return start_a != start_b ? start_a < start_b : a < b;
  });
  return slots;
}

void RealtimeLoop::serve(Slot slot) noexcept {
  if (!stopping()) requests_.take(kRequestsBeforeSlot);
  const can::Time planned = sync_ + master_.planned_start(slot);
  sleep_until(planned);
  if (loop_.look_at_every_slot || looks_before_sending()) receive_frames();
  if (loop_.sync_line != nullptr) loop_.sync_line->idle();
  reporter_.at(number_, planned);
  if (!stopping()) requests_.take(kRequestsAtSlot);
  // Without an edge at its beginning, this interval carries no telegram.
  if (begun_) {
    const auto frame = loop_.cluster != nullptr ? loop_.cluster->take(slot) : master_.take(slot);
    if (frame) hand_over(slot, *frame);
  }
  // An actual value telegram of the first channel and the answer to the last command have come by now; the
  // others have at the edge. A look costs a system call, so the telegram goes first.
  if (!loop_.look_at_every_slot && slot == Slot::reference_two) receive_frames();
}

void RealtimeLoop::hand_over(Slot slot, const can::Frame& frame) noexcept {
  if (bus_.now() <= sync_ + master_.latest_start(slot)) {
    const can::SendResult result = bus_.send(frame);
    watch_.sent(result);
    if (result == can::SendResult::queued) {
      last_sent_ = frame;
      echo_due_ = true;
      master_.sent(slot);
      return;
    }
  }
  ++left_out_[index(slot)];
  master_.left_out(slot);
  reporter_.left_out(slot);
}

/// What came up to the deadline is left to the caller: at the edge, the edge comes first. When looks are
/// rare, the gateway is woken after each of them and not in between.
void RealtimeLoop::sleep_until(can::Time deadline) noexcept {
  if (loop_.look_at_every_slot || looked_) reporter_.wake_gateway();
  looked_ = false;
  while (bus_.wait_until(deadline) != can::Wake::deadline) {
    receive_frames();
    reporter_.wake_gateway();
  }
}

/// True when it is no frame for the master.
bool RealtimeLoop::take_sync_frame(const can::ReceivedFrame& received) noexcept {
  if (loop_.sync_line->take_frame(received, timeline_.lock())) return true;
  if (!loop_.sync_line->is_others(received)) return false;
  heard_others_ = true;
  reporter_.at(number_, received.end);
  master_.other_sync();
  return true;
}

void RealtimeLoop::receive_frames() noexcept {
  looked_ = true;
  can::ReceivedFrame received;
  for (unsigned i = 0; i < kFramesAtOnce && bus_.receive(received); ++i) {
    const unsigned bits = can::frame_bits(received.frame);
    load_.add(bits);
    if (loop_.sync_line != nullptr && take_sync_frame(received)) continue;
    if (master_.state() == cansync::State::active_master)
      slots_.add(received.frame, bits, received.end, sync_);
    const can::Time since_sync = received.end - sync_;
    if (received.own) {
      if (received.frame == last_sent_) echo_due_ = false;
      master_.transmitted(received.frame, since_sync);
    } else {
      heard_others_ = true;
      reporter_.at(number_, received.end);
      master_.receive(received.frame, since_sync);
    }
  }
}

}  // namespace cansyncd
