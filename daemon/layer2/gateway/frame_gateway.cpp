#include "daemon/layer2/gateway/frame_gateway.h"

#include <fmt/format.h>
#include <poll.h>
#include <pthread.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "can/bus_names.h"
#include "daemon/layer2/gateway/bus_events.h"
#include "dds/bounded_text.h"
#include "dds/malformed.h"
#include "layer2/dds/convert.h"

namespace cansyncd {
namespace {

using std::chrono::steady_clock;

/// Batches published in one pass: requests must not wait behind a bus that never rests.
constexpr unsigned kBatchesAtOnce = 16;

/// Milliseconds from now to `due`, rounded up, at least 0.
int milliseconds_to(SteadyTime due) {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(due - steady_clock::now());
  return static_cast<int>(std::max<std::int64_t>(left.count(), 0));
}

}  // namespace

FrameGateway::FrameGateway(const Layer2Config& config, Layer2Exchange& exchange,
                           const gateway::dds::Participant& participant, JournalSink& journal,
                           const DaemonIdentity& identity)
    : config_(config),
      exchange_(exchange),
      identity_(identity),
      events_(participant, journal, config.bus.name),
      trail_(journal, events_, config.bus.name, 0),
      jobs_(participant, signal_, events_, trail_, SendRequests(config.send), !config.dds.security.empty()),
      batches_(participant, 0, &signal_),
      status_(participant, 0, &signal_) {
  batch_.reserve(layer2_BATCH);
}

FrameGateway::~FrameGateway() {
  stop();
}

void FrameGateway::start() {
  gateway::dds::count_malformed();
  thread_ = std::thread([this] {
    pthread_setname_np(pthread_self(), "cansync-gateway");  // for `top -H` and whoever measures
    run();
  });
}

void FrameGateway::stop() noexcept {
  if (!thread_.joinable()) return;
  stop_ = true;
  exchange_.gateway_wake.signal();
  thread_.join();
}

void FrameGateway::post(const EventText& event) {
  {
    const std::lock_guard lock(mutex_);
    if (posted_.size() < kPosted) posted_.push_back(event);
  }
  exchange_.gateway_wake.signal();
}

void FrameGateway::reload(const Layer2Config& config) {
  {
    const std::lock_guard lock(mutex_);
    new_configuration_ = config;
  }
  exchange_.gateway_wake.signal();
}

void FrameGateway::run() {
  std::array<pollfd, 2> wake{{{exchange_.gateway_wake.descriptor(), POLLIN, 0}, {signal_.fd(), POLLIN, 0}}};
  bool samples_may_wait = true;
  while (!stop_) {
    const SteadyTime due = pass(samples_may_wait);
    passes_.fetch_add(1, std::memory_order_relaxed);
    // An interrupted or failed poll only means one pass too many.
    const int ready = ::poll(wake.data(), wake.size(), milliseconds_to(due));
    if (ready > 0 && wake[0].revents != 0) exchange_.gateway_wake.clear();
    samples_may_wait = ready <= 0 || wake[1].revents != 0;
    if (samples_may_wait) signal_.clear();
  }
  end_jobs();
}

SendContext FrameGateway::context(SteadyTime now) const {
  return {exchange_, config_, now, {config_.dds.request_max_age, config_.access.read_only}};
}

SteadyTime FrameGateway::pass(bool samples_may_wait) {
  const SteadyTime now = steady_clock::now();
  take_configuration(now);
  const SendContext jobs = context(now);
  // A frame that was sent is told before what came after it.
  take_answers(jobs);
  const bool more_frames = publish_frames();
  publish_posted(now);
  // Asking every reader costs more than all the rest of a pass.
  if (samples_may_wait && jobs_.take_requests(jobs)) signal_.raise();
  SteadyTime due = publish_status(now);
  for (const auto next : {jobs_.retry(jobs), events_.tick(now), losses_.next()}) {
    if (next) due = std::min(due, *next);
  }
  return more_frames ? now : due;
}

void FrameGateway::take_configuration(SteadyTime now) {
  std::optional<Layer2Config> taken;
  {
    const std::lock_guard lock(mutex_);
    taken = std::exchange(new_configuration_, std::nullopt);
  }
  if (!taken) return;
  config_.access = taken->access;
  config_.dds.request_max_age = taken->dds.request_max_age;
  status_due_ = true;
  events_.publish(
      {gateway_SEVERITY_INFO, "configuration_reloaded", -1, "the configuration was read again", {}}, now);
}

void FrameGateway::publish_posted(SteadyTime now) {
  std::vector<EventText> taken;
  {
    const std::lock_guard lock(mutex_);
    taken.swap(posted_);
  }
  for (const EventText& event : taken) events_.publish(event, now);
}

void FrameGateway::take_answers(const SendContext& context) {
  SendDone done;
  while (exchange_.done.try_pop(done)) jobs_.finish(done, context);
}

bool FrameGateway::publish_frames() {
  for (unsigned i = 0; i < kBatchesAtOnce; ++i) {
    ReceivedReport report;
    batch_.clear();
    while (batch_.size() < layer2_BATCH && exchange_.frames.try_pop(report))
      batch_.push_back(layer2::dds::received_frame(report.frame, report.receive_time.count(), report.range));
    if (batch_.empty()) return false;
    layer2_FrameBatch sample = {};
    sample.number = ++batch_number_;
    sample.lost = bus_.lost + unwritten_;
    sample.frames._length = static_cast<std::uint32_t>(batch_.size());
    sample.frames._maximum = sample.frames._length;
    sample.frames._buffer = batch_.data();  // lent for the call
    if (batches_.write(sample) != DDS_RETCODE_OK) unwritten_ += batch_.size();
  }
  return true;
}

void FrameGateway::tell_losses(SteadyTime now) {
  const std::uint64_t lost = bus_.lost + unwritten_;
  if (losses_.add(lost - std::exchange(told_lost_, lost), now)) {
    events_.publish({gateway_SEVERITY_WARNING, "frames_dropped", -1,
                     "received frames are not published, because they come faster than they can be; take "
                     "fewer by ranges, or give realtime.report_queue more room",
                     std::nullopt},
                    now);
  }
  if (const std::uint64_t row = losses_.take_over(now); row != 0) {
    events_.publish({gateway_SEVERITY_INFO, "frames_dropped_over", -1,
                     fmt::format("received frames are all published again; {} were not", row), std::nullopt},
                    now);
  }
}

void FrameGateway::tell_bus(const can::ControllerStatus& before, SteadyTime now) {
  for (const EventText& event : bus_events(before, bus_.controller, config_.bus)) {
    events_.publish(event, now);
    status_due_ = true;
  }
}

SteadyTime FrameGateway::publish_status(SteadyTime now) {
  const can::ControllerStatus before = bus_.controller;
  if (exchange_.status.read(bus_)) tell_bus(before, now);
  tell_losses(now);
  if (!status_due_ && now < next_status_) return next_status_;
  status_due_ = false;
  next_status_ = now + kStatusPeriod;
  layer2_BusStatus sample = {};
  sample.time = wall_clock_now();
  gateway::dds::copy_text(config_.bus.name, sample.bus_name);
  gateway::dds::copy_text(config_.bus.interface, sample.interface_name);
  gateway::dds::copy_text(CANSYNC_VERSION, sample.version);
  sample.bit_rate = config_.bus.bits_per_second;
  const can::ControllerStatus& controller = bus_.controller;
  gateway::dds::copy_text(can::name(controller.state), sample.state);
  gateway::dds::copy_text(can::name(controller.link), sample.link);
  sample.transmit_errors = controller.transmit_errors;
  sample.receive_errors = controller.receive_errors;
  sample.bus_load = bus_.bus_load;
  sample.received = bus_.counters.received;
  sample.taken = bus_.counters.taken;
  sample.lost = bus_.lost + unwritten_;
  sample.dropped = controller.overruns + controller.dropped;
  sample.sent = bus_.counters.sent;
  sample.unanswered = bus_.counters.unanswered;
  sample.not_sent = bus_.counters.not_sent;
  sample.waiting = bus_.waiting;
  sample.send_timeout = static_cast<std::uint32_t>(config_.send.timeout.count());
  sample.read_only = config_.access.read_only;
  std::copy(identity_.begin(), identity_.end(), std::begin(sample.daemon));
  (void)status_.write(sample);
  return next_status_;
}

void FrameGateway::end_jobs() {
  constexpr std::chrono::milliseconds kPatience{500};
  constexpr int kLook = 20;
  const SteadyTime end = steady_clock::now() + kPatience;
  take_answers(context(steady_clock::now()));
  while (publish_frames()) {
  }  // the realtime thread has ended: the ring grows no more
  publish_posted(steady_clock::now());
  jobs_.stop(context(steady_clock::now()));
  while (jobs_.replies_waiting() && steady_clock::now() < end) {
    (void)signal_.wait(kLook);
    signal_.clear();
    (void)jobs_.retry(context(steady_clock::now()));
  }
  jobs_.wait_for_readers(DDS_MSECS(kPatience.count()));
}

}  // namespace cansyncd
