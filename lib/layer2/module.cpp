#include "layer2/module.h"

#include <algorithm>
#include <chrono>

#include "can/frame_length.h"

namespace layer2 {
namespace {

/// Commands of a script done in one step: they cost time.
constexpr unsigned kCommandsAtOnce = 32;
/// Events that may wait to be taken.
constexpr std::size_t kMostEvents = 64;

std::size_t depth_of(std::uint16_t depth) noexcept {
  return std::min<std::size_t>(depth, Station::kMostQueue);
}

Station::QueueState state_of(const BoundedQueue<WaitingFrame>& queue) noexcept {
  return {static_cast<std::uint16_t>(queue.size()), static_cast<std::uint16_t>(queue.depth()),
          queue.half_full(), queue.overflowed(), queue.lost()};
}

StatusFacts::Queues queues_of(const Station::QueueState& high, const Station::QueueState& normal) noexcept {
  return {high.half_full, normal.half_full, high.overflowed || normal.overflowed,
          high.size == 0 && normal.size == 0};
}

}  // namespace

Module::Module(const ModuleSettings& settings)
    : settings_(settings),
      station_(settings.station),
      window_(settings.window),
      orders_(objects_, settings.object_patience),
      received_(depth_of(settings.receive_queue), settings.receive_overflow, Station::kMostQueue),
      received_high_(depth_of(settings.receive_high_queue), settings.receive_overflow, Station::kMostQueue),
      events_(kMostEvents) {
  for (unsigned number = 1; number <= Timers::kMost; ++number) {
    if (const auto& timer = settings_.timers[number - 1]) (void)timers_.configure(number, *timer);
  }
  if (!settings_.mapped.empty()) {
    mapping_.configure(settings_.mapping, settings_.mapped);
    // Saia 3.5: the mapping has two of the objects.
    for (const unsigned number : {28u, 29u}) objects_.reserve(number);
  }
  for (unsigned number = 0; number < MessageObjects::kMost; ++number) {
    if (const auto& object = settings_.objects[number]) (void)objects_.configure(number, *object);
  }
}

void Module::begin(Time now) noexcept {
  now_ = now;
  start_script(settings_.power_on);
  if (settings_.starts_in_run) set_running(true, now);
}

void Module::start_script(const Script& script) noexcept {
  script_frame_.reset();
  runner_.begin(script);
}

void Module::set_running(bool running, Time now) noexcept {
  now_ = now;
  if (running == running_) return;
  running_ = running;
  if (running) {
    mapping_.start(now);
    // What the script of power-on does comes before what that of run does.
    if (runner_.runs()) {
      next_script_ = &settings_.run;
    } else {
      start_script(settings_.run);
    }
  } else {
    timers_.stop_all();
    window_.timer_stopped(1);
    mapping_.stop();
    objects_.stop();
    station_.clear_queues();
    received_.clear();
    received_high_.clear();
    next_script_ = nullptr;
    start_script(settings_.stop);
  }
  step_script();
}

/// Does what needs no bus, up to the next frame or the next wait.
void Module::step_script() noexcept {
  for (unsigned i = 0; i < kCommandsAtOnce && !script_frame_; ++i) {
    const auto command = runner_.next(now_);
    if (!command) {
      if (runner_.runs() || next_script_ == nullptr) return;
      start_script(*next_script_);
      next_script_ = nullptr;
      continue;
    }
    switch (command->kind) {
      case ScriptCommand::Kind::send:
        script_frame_ = command;
        break;
      case ScriptCommand::Kind::start:
        (void)start_timer(command->number, now_);
        runner_.done();
        break;
      case ScriptCommand::Kind::stop:
        (void)stop_timer(command->number);
        runner_.done();
        break;
      case ScriptCommand::Kind::wait:
        return;  // the runner's own
    }
  }
}

Refusal Module::control(const ControlOrder& order, Time now) noexcept {
  const auto timer = [](bool done) { return done ? Refusal::none : Refusal::no_timer; };
  switch (order.what) {
    case Control::run:
      if (!order.led) return Refusal::not_led;
      [[fallthrough]];
    case Control::stop:
      set_running(order.what == Control::run, now);
      return Refusal::none;
    case Control::start_timer:
      return timer(start_timer(order.number, now));
    case Control::stop_timer:
      return timer(stop_timer(order.number));
    case Control::set_timer:
      return has_room(order.number, order.timer) ? timer(configure_timer(order.number, order.timer))
                                                 : Refusal::bus_full;
    case Control::clear_queues:
      clear_queues();
      return Refusal::none;
    case Control::reset_overflow:
      reset_overflow();
      return Refusal::none;
    case Control::configure:
      return order.prepared == nullptr ? Refusal::none : configure(*order.prepared, now);
    case Control::write_image:
      if (settings_.mapped.empty()) return Refusal::no_image;
      return order.written == mapping_.table() ? Refusal::none : Refusal::image_owned;
    case Control::reset_controller:
      break;
  }
  return Refusal::no_controller;
}

bool Module::start_timer(unsigned number, Time now) noexcept {
  if (window_.used() && (number == 1 || number == 2)) {
    window_.timer_started(number, now);
    return true;
  }
  window_.timer_started(number, now);
  return timers_.start(number, now);
}

bool Module::stop_timer(unsigned number) noexcept {
  window_.timer_stopped(number);
  return timers_.stop(number);
}

/// On the bus, beside the other timers and the process image.
bool Module::has_room(unsigned number, const TimerSettings& settings) const noexcept {
  const std::uint32_t rate = settings_.bits_per_second;
  if (settings.period <= Time{0}) return true;
  return timers_.share_of_others(number, rate) + mapping_.share_of_bus(rate) + share_of_bus(settings, rate) <=
         can::kWholeBus;
}

bool Module::configure_timer(unsigned number, const TimerSettings& settings) noexcept {
  return timers_.configure(number, settings);
}

bool Module::set_timer_frame(unsigned number, const can::Frame& frame) noexcept {
  return timers_.set_frame(number, frame);
}

void Module::clear_queues() noexcept {
  station_.clear_queues();
  received_.clear();
  received_high_.clear();
}

void Module::reset_overflow() noexcept {
  station_.reset_overflow();
  received_.reset_overflow();
  received_high_.reset_overflow();
}

void Module::receive(const can::Frame& frame, Time end) noexcept {
  if (!running_) {
    station_.count_received();
    return;
  }
  const auto object = objects_.receive(frame, end);
  if (object) {
    ++taken_by_objects_;
    tell(ModuleEvent::Kind::object_received, *object, frame, end);
  }
  if (object || mapping_.receive(frame)) {
    station_.count_received();
    return;
  }
  const auto range = station_.receive(frame);
  if (!range) return;
  const Priority priority = station_.priority_of(*range);
  (void)(priority == Priority::high ? received_high_ : received_).push({frame, end, *range, priority});
}

std::optional<WaitingFrame> Module::take_received() noexcept {
  if (!received_high_.empty()) return received_high_.pop();
  if (!received_.empty()) return received_.pop();
  return std::nullopt;
}

Station::QueueState Module::receive_queue(Priority priority) const noexcept {
  return state_of(priority == Priority::high ? received_high_ : received_);
}

Refusal Module::submit(const SendOrder& order, Time now) noexcept {
  return running_ ? station_.submit(order, now) : Refusal::not_running;
}

/// What stands in the controller already takes its time of the window, too.
bool Module::orders_may_go() const noexcept {
  const auto frames = static_cast<Time::rep>(station_.handed_over_count() + 1);
  return window_.open(
      now_, frames * can::kLongestFrameBits * Time(std::chrono::seconds(1)) / settings_.bits_per_second);
}

std::optional<can::Frame> Module::next_frame() noexcept {
  if (!station_.has_place()) return std::nullopt;
  if (const auto timer = timers_.due()) {
    offered_own_ = {Sender::timer, static_cast<std::uint8_t>(*timer)};
    return offered_ = timers_.settings(*timer).frame;
  }
  if (script_frame_) {
    offered_own_ = {Sender::script, 0};
    return offered_ = script_frame_->frame;
  }
  if (const auto object = running_ ? objects_.next() : std::nullopt) {
    offered_own_ = {Sender::object, static_cast<std::uint8_t>(*object)};
    return offered_ = objects_.frame(*object);
  }
  if (const auto telegram = mapping_.next()) {
    offered_own_ = {Sender::mapping, *telegram};
    return offered_ = mapping_.frame(*telegram);
  }
  offered_own_ = {};
  const bool open = orders_may_go();
  return station_.next_frame(open, open || !window_.holds_high());
}

void Module::handed_over() noexcept {
  orders_.held_back(Obstacle::none);
  if (offered_own_.sender == Sender::order) {
    station_.handed_over();
    return;
  }
  if (offered_own_.sender == Sender::object) {
    offered_own_.handing = objects_.handed_over(offered_own_.number);
    orders_.handed_over(offered_own_.number, now_);
  }
  station_.own_handed_over(offered_, offered_own_);
  switch (offered_own_.sender) {
    case Sender::timer:
      timers_.taken(offered_own_.number);
      break;
    case Sender::script:
      script_frame_.reset();
      runner_.done();
      step_script();
      timers_.advance(now_);  // what it has started is due now
      break;
    case Sender::object:
      break;
    case Sender::mapping:
      mapping_.handed_over(offered_own_.number, offered_);
      break;
    case Sender::order:
      break;
  }
}

void Module::echo(const can::Frame& frame, Time end) noexcept {
  const auto own = station_.echo(frame, end);
  pass_lost();
  if (!own || own->sender != Sender::object) return;
  if (objects_.sent(own->number, own->handing, end) && !frame.remote)
    tell(ModuleEvent::Kind::object_sent, own->number, frame, end);
}

void Module::echoes_lost() noexcept {
  station_.echoes_lost();
  pass_lost();
}

/// Tells those who wait for the echo of their frame that it does not come.
void Module::pass_lost() noexcept {
  const auto lost = station_.take_lost();
  for (std::size_t i = 0; i < lost.size(); ++i) {
    const OwnFrame& own = lost[i];
    if (own.sender == Sender::object) objects_.lost(own.number, own.handing);
    if (own.sender == Sender::mapping) mapping_.lost(own.number);
  }
}

void Module::tell(ModuleEvent::Kind kind, unsigned number, const can::Frame& frame, Time time) noexcept {
  if (objects_.tells(number)) (void)events_.push({kind, static_cast<std::uint8_t>(number), frame, time});
}

std::optional<ModuleEvent> Module::take_event() noexcept {
  if (!events_.empty()) return events_.pop();
  if (station_.submitted() == emptied_for_ || station_.waiting() != 0) return std::nullopt;
  emptied_for_ = station_.submitted();
  return ModuleEvent{.time = now_};
}

void Module::controller_emptied() noexcept {
  station_.controller_emptied();
  objects_.controller_emptied();
  mapping_.controller_emptied();
}

void Module::advance(Time now) noexcept {
  now_ = now;
  step_script();  // before the timers it starts
  timers_.advance(now);
  objects_.advance(now);
  orders_.advance(now);
  mapping_.advance(now);
  station_.advance(now);
}

Time Module::next_deadline() const noexcept {
  Time next = std::min({station_.next_deadline(), timers_.next_deadline(), runner_.next_deadline(),
                        objects_.next_deadline(), orders_.next_deadline(), mapping_.next_deadline()});
  if (station_.waiting() != 0) next = std::min(next, window_.next_opening(now_));
  return next;
}

StatusFacts Module::status() const noexcept {
  StatusFacts facts;
  facts.running = running_;
  facts.send = queues_of(station_.queue(Priority::high), station_.queue(Priority::normal));
  facts.receive = queues_of(receive_queue(Priority::high), receive_queue(Priority::normal));
  if (settings_.station.node) facts.node = settings_.station.node->node;
  return facts;
}

}  // namespace layer2
