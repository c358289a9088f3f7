#include "client/src/frame_side.h"

#include <algorithm>
#include <utility>

#include "client/src/bus_facts.h"
#include "client/src/connect_options.h"
#include "layer2/dds/convert.h"

namespace cansync::client {
namespace detail {
namespace {

/// Message objects that the queues have (Saia 3.5).
constexpr std::int16_t kReceiveObject = 30;
constexpr std::int16_t kSendObject = 31;

bool half_full(std::uint32_t waiting, std::uint32_t depth) {
  return depth != 0 && 2 * waiting >= depth;
}

}  // namespace

FrameSide::FrameSide(const Options& options)
    : client_(connect_to<layer2::client::FrameClient>(options)), open_(client_) {
  if (!client_.status(first_status_wait(options)))
    throw NoDaemon("the daemon tells nothing of its frames (" + client_.place() + ")");
}

void FrameSide::look() {
  client_.look(
      {.ended = [this](std::uint64_t request, const Result& result) { open_.ended(request, result); },
       .batch = [this](const layer2_FrameBatch& batch) { note(batch); }});
  if (open_.watch_daemon()) {
    restarted_ = true;
    batch_ = lost_ = 0;
    queues_.clear();  // what was meant for the daemon before is not sent by the next one
    basic_.clear_sending();
  }
  hand_over();
}

void FrameSide::note(const layer2_FrameBatch& batch) {
  if (batch_ != 0 && (batch.number != batch_ + 1 || batch.lost != lost_)) {
    queues_.missed();
    basic_.missed();
  }
  batch_ = batch.number;
  lost_ = batch.lost;
  for (std::uint32_t i = 0; i < batch.frames._length; ++i) {
    const layer2_ReceivedFrame& received = batch.frames._buffer[i];
    const can::Frame frame = layer2::dds::to_core(received.received);
    queues_.received(frame, received.high_priority);
    const QueueInterrupt& wanted = basic_.settings().received;
    if (basic_.receive(frame) && wanted.enabled)
      interrupt(wanted.routine, {.parameter = wanted.parameter, .object = kReceiveObject});
  }
}

void FrameSide::hand_over() {
  basic_.hand_over([this](const SaiaQueues::Waiting& one) {
    return begin(one.frame, {.by_identifier = one.by_identifier}, [this](const Result& result) {
      note_failure(result);
      const QueueInterrupt& wanted = basic_.settings().sent_empty;
      const bool sent = result.replied && result.code == gateway_REPLY_DONE;
      if (basic_.ended() && sent && wanted.enabled)
        interrupt(wanted.routine, {.parameter = wanted.parameter, .object = kSendObject});
    });
  });
  queues_.hand_over([this](const can::Frame& frame, bool high) {
    return begin(frame, {.high_priority = high}, [this](const Result& result) {
      queues_.ended();
      note_failure(result);
    });
  });
}

bool FrameSide::begin(const can::Frame& frame, const layer2::client::SendChoice& choice, Ended ended) {
  if (open_.full()) return false;
  return open_.begin([&](layer2::client::FrameClient& client) { return client.begin_send(frame, 0, choice); },
                     std::move(ended));
}

bool FrameSide::control(const layer2_ControlRequest& wanted, Ended ended) {
  if (open_.full()) return false;
  return open_.begin([&](layer2::client::FrameClient& client) { return client.begin_control(wanted); },
                     std::move(ended));
}

void FrameSide::note_failure(const Result& result) {
  if (result.replied && result.code == gateway_REPLY_DONE) return;
  ++failures_;
  failure_ = "daemon: " + result.reason;
}

std::string FrameSide::obstacle() const {
  if (!client_.daemon_present()) return "client: no daemon serves the bus";
  if (!client_.newest_status()->running) return "daemon: it is in stop; let it run first (cansync can run)";
  return {};
}

layer2::StatusFacts FrameSide::facts() {
  layer2::StatusFacts facts = facts_of(client_.bus_status());
  facts.running = obstacle().empty();
  return facts;
}

std::uint16_t FrameSide::status_word() {
  layer2::StatusFacts facts = this->facts();
  const layer2_FrameStatus& daemon = *client_.newest_status();
  facts.send = queues_.sending();
  facts.send.high_half_full |= half_full(daemon.send_high_waiting, daemon.send_high_depth);
  facts.send.normal_half_full |= half_full(daemon.send_waiting, daemon.send_depth);
  facts.send.overflowed |= daemon.send_overflowed;
  facts.receive = queues_.receiving();
  facts.receive.overflowed |= daemon.receive_overflowed;
  return layer2::status_word(facts);
}

std::uint32_t FrameSide::bit_rate() {
  const auto& bus = client_.bus_status();
  return bus ? bus->bit_rate : 0;
}

std::uint64_t FrameSide::error_count() {
  const auto& bus = client_.bus_status();
  return bus ? bus->error_frames + bus->acknowledge_errors : 0;
}

void FrameSide::begin_anew(const Beginning& beginning) {
  beginning_ = beginning;
  basic_.remove();
}

void FrameSide::interrupt(int routine, const Interrupt& interrupt) const {
  const auto found = routines_.find(routine);
  if (found != routines_.end()) found->second(interrupt);
}

void FrameSide::set_routine(int number, std::function<void(const Interrupt&)> routine) {
  if (routine) {
    routines_[number] = std::move(routine);
  } else {
    routines_.erase(number);
  }
}

}  // namespace detail

FrameConnection::FrameConnection(std::unique_ptr<detail::FrameSide> side) noexcept : side_(std::move(side)) {}
FrameConnection::FrameConnection(FrameConnection&& other) noexcept = default;
FrameConnection& FrameConnection::operator=(FrameConnection&& other) noexcept = default;
FrameConnection::~FrameConnection() = default;

FrameConnection FrameConnection::connect(const Options& options) {
  return FrameConnection(std::make_unique<detail::FrameSide>(options));
}

bool FrameConnection::daemon_present() const {
  return side_->daemon_present();
}

void FrameConnection::on_interrupt(int number, std::function<void(const Interrupt&)> routine) {
  side_->set_routine(number, std::move(routine));
}

}  // namespace cansync::client
