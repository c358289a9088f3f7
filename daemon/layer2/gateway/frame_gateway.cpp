#include "daemon/layer2/gateway/frame_gateway.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "daemon/layer2/gateway/frame_metrics.h"
#include "dds/bounded_text.h"
#include "layer2/config/options.h"
#include "layer2/dds/convert.h"

namespace cansyncd {
namespace {

using std::chrono::steady_clock;

/// Batches published in one pass: requests must not wait behind a bus that never rests.
constexpr unsigned kBatchesAtOnce = 16;

LossRow::Texts telegrams_left_out() {
  return {"telegrams_left_out", "telegrams_left_out_over",
          "telegrams of the process image are left out, because they had no place on the bus within "
          "mapping.interval_ms; which ones says cansync can image; make the interval longer, or send fewer",
          "telegrams of the process image all have room again; left out"};
}

/// What FrameStatus says of the module.
void fill_module(const BusSnapshot& bus, layer2_FrameStatus& sample) {
  sample.running = bus.facts.running;
  sample.script_running = bus.script_running;
  sample.window_running = bus.window_running;
  sample.status_word = layer2::status_word(bus.facts);
  const auto image = layer2::status_image(bus.facts);
  std::copy(image.begin(), image.end(), std::begin(sample.status_image));
  sample.send_waiting = bus.send.size;
  sample.send_high_waiting = bus.send_high.size;
  sample.receive_waiting = bus.receive.size;
  sample.receive_high_waiting = bus.receive_high.size;
  sample.send_depth = bus.send.depth;
  sample.send_high_depth = bus.send_high.depth;
  sample.receive_depth = bus.receive.depth;
  sample.receive_high_depth = bus.receive_high.depth;
  sample.send_overflowed = bus.facts.send.overflowed;
  sample.receive_overflowed = bus.facts.receive.overflowed;
  sample.send_overflows = bus.send.lost + bus.send_high.lost;
  sample.receive_overflows = bus.receive.lost + bus.receive_high.lost;
  gateway::dds::copy_text(layer2::name_of(layer2::bus_fault(bus.facts)), sample.bus_fault);
}

}  // namespace

FrameGateway::FrameGateway(const Layer2File& file, Layer2Exchange& exchange,
                           const gateway::dds::Participant& participant, JournalSink& journal,
                           const DaemonIdentity& identity)
    : GatewayBase(file.config, exchange, participant, journal, identity, kLayer2Protocol, 0),
      running_(file),
      jobs_(participant, signal_, events_, trail_, SendRequests(running_), identity,
            !config_.dds.security.empty()),
      image_gate_(participant, signal_, events_, identity, exchange),
      lead_(participant, signal_, events_, identity, config_.run_follows, exchange),
      batches_(participant, 0, &signal_),
      status_(participant, 0, &signal_),
      timers_(participant, 0, &signal_),
      image_(participant, 0, &signal_),
      objects_(participant, 0, &signal_),
      module_events_(participant, 0, &signal_),
      left_out_(telegrams_left_out()) {
  batch_.reserve(layer2_BATCH);
  jobs_.set_read_by_all(common_.gateway_writer());
  set_rules(steady_clock::now());
}

FrameGateway::~FrameGateway() {
  stop();
}

std::string FrameGateway::metrics_text(std::uint64_t write_failures) const {
  return frame_metrics_text(common_.told(), told_status_, write_failures);
}

SendContext FrameGateway::context(SteadyTime now) {
  return {exchange_,   config_, now, {config_.dds.request_max_age, config_.access.read_only},
          image_gate_, lead_};
}

void FrameGateway::set_rules(SteadyTime now) {
  image_gate_.set_rules({!config_.mapped.empty(), config_.access.read_only, config_.writer_lost}, now);
  lead_.set_read_only(config_.access.read_only, now);
}

SteadyTime FrameGateway::pass(bool samples_may_wait) {
  const SteadyTime now = steady_clock::now();
  if (take_access(now)) set_rules(now);
  const SendContext jobs = context(now);
  // A frame that was sent is told before what came after it.
  take_answers(jobs);
  const bool more_frames = publish_frames();
  publish_events();
  posted_.publish(events_, now);
  if (samples_may_wait) {
    second_daemon_.look(now);
    const bool more_outputs = image_gate_.take_samples(now);
    const bool more_leads = lead_.take_samples(now);
    if (jobs_.take_requests(jobs) || more_outputs || more_leads) signal_.raise();
  }
  if (lead_.take_stopped()) jobs_.replace_waiting({}, jobs);
  const SteadyTime status_due = publish_status(now);
  const SteadyTime due = earliest(
      status_due,
      {jobs_.retry(jobs), losses_.next(), left_out_.next(), image_gate_.tick(now), lead_.tick(now),
       status_line_.step([this] { return bus_sentence(state_text(), bus_.controller, config_.bus); }, now)},
      now);
  return more_frames ? now : due;
}

std::string FrameGateway::state_text() const {
  std::string text = bus_.facts.running ? "run: general frames" : "stop: general frames";
  if (!image_gate_.owner().empty()) text += "; the image is written by " + image_gate_.owner();
  if (losses_.next()) text += "; received frames are lost";
  return text;
}

void FrameGateway::take_answers(const SendContext& context) {
  SendDone done;
  while (exchange_.done.try_pop(done)) jobs_.finish(done, context);
  take_running(context.now);
}

/// What a request has changed.
void FrameGateway::take_running(SteadyTime time) {
  if (std::exchange(told_changes_, running_.changes()) == running_.changes()) return;
  const Layer2Config& now = running_.config();
  const bool sends_otherwise = now.send.queue != config_.send.queue ||
                               now.send.high_queue != config_.send.high_queue ||
                               now.send.overflow != config_.send.overflow;
  config_.send = now.send;
  config_.mapped = now.mapped;
  config_.writer_lost = now.writer_lost;
  set_rules(time);
  if (image_gate_.table() != running_.tables()) take_table(time);
  if (sends_otherwise) jobs_.renew_limits();
}

/// The process image begins anew, or there is none any more.
void FrameGateway::take_table(SteadyTime time) {
  image_gate_.begin_anew(time);
  if (config_.mapped.empty() && std::exchange(image_told_, false)) (void)image_.dispose({});
}

bool FrameGateway::publish_frames() {
  for (unsigned i = 0; i < kBatchesAtOnce; ++i) {
    ReceivedReport report;
    batch_.clear();
    while (batch_.size() < layer2_BATCH && exchange_.frames.try_pop(report))
      batch_.push_back(layer2::dds::received_frame(report.frame, report.receive_time.count(), report.range,
                                                   report.high_priority));
    if (batch_.empty()) return false;
    layer2_FrameBatch sample = {};
    sample.number = ++batch_number_;
    sample.lost = bus_.lost + unwritten_;
    sample.frames._length = static_cast<std::uint32_t>(batch_.size());
    sample.frames._maximum = sample.frames._length;
    sample.frames._buffer = batch_.data();  // lent for the call
    sample.first = published_;
    (batches_.write(sample) == DDS_RETCODE_OK ? published_ : unwritten_) += batch_.size();
  }
  return true;
}

SteadyTime FrameGateway::publish_status(SteadyTime now) {
  const can::ControllerStatus before = bus_.controller;
  if (exchange_.status.read(bus_)) tell_bus(before, bus_.controller, now);
  losses_.tell(bus_.lost + unwritten_, events_, now);
  publish_timers(now >= next_status_);
  publish_image(now);
  tell_left_out(left_out_, newest_image_.left_out, bus_.controller, now);
  publish_objects();
  const SteadyTime common_due = tell_common(
      {.controller = bus_.controller, .timestamps = bus_.timestamps, .in_run = bus_.facts.running}, jobs_,
      now);
  const bool owner_changed = ownership_.take(image_gate_.arbiter(), lead_.arbiter());
  const bool due = now >= next_status_;
  if (!due && !owner_changed) return std::min(common_due, next_status_);
  if (due) {
    next_status_ = now + kStatusPeriod;
    told_status_ = frame_status();
  }
  gateway::dds::copy_text(lead_.program(), told_status_.run_lead);
  put_ownership(image_gate_.arbiter(), told_status_.image_ownership);
  put_ownership(lead_.arbiter(), told_status_.run_lead_ownership);
  (void)status_.write(told_status_);
  return std::min(common_due, next_status_);
}

layer2_FrameStatus FrameGateway::frame_status() const {
  layer2_FrameStatus sample = {};
  sample.time = wall_clock_now();
  sample.bus_load = bus_.bus_load;
  sample.received = bus_.counters.received;
  sample.taken = bus_.counters.taken;
  sample.taken_by_objects = bus_.taken_by_objects;
  sample.taken_by_mapping = bus_.taken_by_mapping;
  sample.dropped_by_mapping = bus_.dropped_by_mapping;
  sample.lost = bus_.lost + unwritten_;
  sample.sent = bus_.counters.sent;
  sample.unanswered = bus_.counters.unanswered;
  sample.not_sent = bus_.counters.not_sent;
  sample.waiting = bus_.waiting;
  sample.send_timeout = static_cast<std::uint32_t>(config_.send.timeout.count());
  sample.sending = sample.sent != told_status_.sent;
  sample.receiving = sample.received != told_status_.received;
  fill_module(bus_, sample);
  return sample;
}

void FrameGateway::publish_timers(bool all) {
  for (unsigned number = 1; number <= layer2::Timers::kMost; ++number) {
    const TimerState& timer = bus_.timers[number - 1];
    TimerState& told = told_timers_[number - 1];
    if (!timer.configured) {
      if (std::exchange(told, {}).configured) forget_timer(number);
      continue;
    }
    const layer2::TimerSettings& settings = timer.settings;
    const bool same = told.configured && told.running == timer.running &&
                      told.settings.frame == settings.frame && told.settings.period == settings.period &&
                      told.settings.phase == settings.phase && told.settings.cyclic == settings.cyclic;
    if (same && (!all || (told.sent == timer.sent && told.left_out == timer.left_out))) continue;
    told = timer;
    using std::chrono::duration_cast;
    using std::chrono::microseconds;
    layer2_TimerStatus sample = {};
    sample.number = static_cast<std::uint8_t>(number);
    sample.running = timer.running;
    sample.content = layer2::dds::to_idl(settings.frame);
    sample.period = static_cast<std::uint32_t>(duration_cast<microseconds>(settings.period).count());
    sample.phase = static_cast<std::uint32_t>(duration_cast<microseconds>(settings.phase).count());
    sample.cyclic = settings.cyclic;
    sample.sent = timer.sent;
    sample.left_out = timer.left_out;
    (void)timers_.write(sample);
  }
}

/// It is configured no longer.
void FrameGateway::forget_timer(unsigned number) {
  layer2_TimerStatus sample = {};
  sample.number = static_cast<std::uint8_t>(number);
  (void)timers_.dispose(sample);
}

void FrameGateway::publish_image(SteadyTime now) {
  if (config_.mapped.empty()) return;
  ImageSnapshot read;
  bool changed = false;
  if (exchange_.image.read(read) && read.table == image_gate_.table()) {
    changed = read.exchanging != newest_image_.exchanging || read.sending != newest_image_.sending ||
              read.inputs != newest_image_.inputs || read.outputs != newest_image_.outputs;
    newest_image_ = read;
  }
  if (newest_image_.table != image_gate_.table() || (!changed && now < next_image_)) return;
  next_image_ = now + kStatusPeriod;
  image_told_ = true;
  layer2_ProcessImage sample = {};
  sample.time = wall_clock_now();
  sample.exchanging = newest_image_.exchanging;
  sample.sending = newest_image_.exchanging && newest_image_.sending;
  gateway::dds::copy_text(image_gate_.owner(), sample.writer);
  sample.received = newest_image_.received;
  sample.dropped = newest_image_.dropped;
  sample.sent = newest_image_.sent;
  sample.left_out = newest_image_.left_out;
  sample.telegrams = newest_image_.telegrams;
  for (std::size_t i = 0; i < newest_image_.telegrams; ++i) {
    sample.telegram_identifier[i] = newest_image_.each_left_out[i].identifier;
    sample.telegram_left_out[i] = newest_image_.each_left_out[i].times;
  }
  std::copy(newest_image_.inputs.begin(), newest_image_.inputs.end(), std::begin(sample.inputs));
  std::copy(newest_image_.outputs.begin(), newest_image_.outputs.end(), std::begin(sample.outputs));
  (void)image_.write(sample);
}

void FrameGateway::publish_objects() {
  ObjectsSnapshot read;
  if (!exchange_.objects.read(read)) return;
  for (unsigned number = 0; number < read.objects.size(); ++number) {
    if (read.objects[number] == told_objects_.objects[number]) continue;
    (void)objects_.write(
        layer2::dds::object_status(number, read.objects[number], read.times[number].count()));
  }
  told_objects_ = read;
}

void FrameGateway::publish_events() {
  ModuleReport report;
  for (std::size_t i = 0; i < Layer2Exchange::kEvents && exchange_.events.try_pop(report); ++i) {
    if (module_events_.matched() == 0) continue;
    layer2_ModuleEvent sample = layer2::dds::module_event(report.event, report.time.count());
    sample.number = report.number;
    (void)module_events_.write(sample);
  }
}

void FrameGateway::end() {
  take_answers(context(steady_clock::now()));
  while (publish_frames()) {
  }  // the realtime thread has ended: the ring grows no more
  publish_events();
  publish_objects();
  posted_.publish(events_, steady_clock::now());
  jobs_.stop_and_deliver(signal_, [this] { return context(steady_clock::now()); });
}

}  // namespace cansyncd
