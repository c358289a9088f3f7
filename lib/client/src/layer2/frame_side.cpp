#include "client/src/layer2/frame_side.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <thread>
#include <utility>

#include "client/src/connect_options.h"
#include "client/src/layer2/bus_facts.h"
#include "layer2/dds/convert.h"

namespace cansync::client {
namespace detail {
namespace {

/// Message objects that the mapping and the queues have (Saia 3.5).
constexpr unsigned kMappingObject = 28;
constexpr std::int16_t kReceiveObject = 30;
constexpr std::int16_t kSendObject = 31;

using std::chrono::steady_clock;

/// How long the end of a program waits for the end of its mapping.
constexpr std::chrono::milliseconds kFarewell{500};

bool half_full(std::uint32_t waiting, std::uint32_t depth) {
  return depth != 0 && 2 * waiting >= depth;
}

}  // namespace

FrameSide::FrameSide(const Options& options)
    : client_(connect_to<layer2::client::FrameClient>(options)),
      open_(client_),
      objects_(open_, [this](unsigned number, bool transmit) { interrupt_of_object(number, transmit); }) {
  if (!client_.status(first_status_wait(options)))
    throw NoDaemon("the daemon tells nothing of its frames (" + client_.place() + ")");
  client_.wait_for_objects();
}

FrameSide::~FrameSide() {
  if ((!mapped_ && !in_force_) || !client_.daemon_present()) return;
  routines_.clear();  // what they use of the program may be gone
  try {
    bool over = false;
    (void)map(
        {.toml = std::string(kNoMapping), .entries = false, .ended = [&](const Result&) { over = true; }});
    for (const auto end = steady_clock::now() + kFarewell; !over && steady_clock::now() < end;) {
      client_.look(
          {.ended = [this](std::uint64_t request, const Result& result) { open_.ended(request, result); }});
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  } catch (const std::exception&) {  // the image is given up all the same, as when a program dies
  }
}

void FrameSide::look() {
  client_.look(
      {.ended = [this](std::uint64_t request, const Result& result) { open_.ended(request, result); },
       .batch = [this](const layer2_FrameBatch& batch) { note(batch); },
       .object = [this](const layer2_ObjectStatus& status) { objects_.note(status); },
       .image =
           [this](const layer2_ProcessImage& image) {
             std::copy(std::begin(image.inputs), std::end(image.inputs), inputs_.begin());
           }});
  if (open_.watch_daemon()) {
    restarted_ = true;
    batch_ = lost_ = 0;
    queues_.clear();  // what was meant for the daemon before is not sent by the next one
    basic_.clear_sending();
    objects_.daemon_restarted();
    mapped_ = in_force_ = false;
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
  if (!daemon_present()) return "client: no daemon serves the bus";
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
  facts.send = queues_.sending();
  facts.receive = queues_.receiving();
  if (const auto& daemon = client_.newest_status()) {
    facts.send.high_half_full |= half_full(daemon->send_high_waiting, daemon->send_high_depth);
    facts.send.normal_half_full |= half_full(daemon->send_waiting, daemon->send_depth);
    facts.send.overflowed |= daemon->send_overflowed;
    facts.receive.overflowed |= daemon->receive_overflowed;
  }
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
  objects_.take_back();
  if (mapped_ || in_force_)
    (void)map({.toml = std::string(kNoMapping), .entries = false, .ended = [](const Result&) {}});
}

void FrameSide::interrupt_of_object(unsigned number, bool transmit) const {
  if (!beginning_) return;
  const QueueInterrupt& wanted = transmit ? beginning_->send : beginning_->receive;
  if (wanted.enabled)
    interrupt(wanted.routine, {.parameter = wanted.parameter, .object = static_cast<std::int16_t>(number)});
}

const std::vector<std::uint8_t>* FrameSide::data_block(int number) const {
  const auto found = data_blocks_.find(number);
  return found == data_blocks_.end() ? nullptr : &found->second;
}

bool FrameSide::map(Mapping wanted) {
  mapped_ = wanted.entries;
  if (mapping_under_way_) {  // a daemon refuses one while it takes another over
    if (next_mapping_) next_mapping_->ended({{.reason = "a later call took its place"}});
    next_mapping_ = std::move(wanted);
    return true;
  }
  layer2_ControlRequest request = {};
  request.kind = layer2_CONTROL_CONFIGURE;
  std::vector<std::uint8_t> bytes(wanted.toml.begin(), wanted.toml.end());
  request.data._buffer = bytes.data();
  request.data._length = request.data._maximum = static_cast<std::uint32_t>(bytes.size());
  mapping_under_way_ = control(
      request, [this, entries = wanted.entries, ended = std::move(wanted.ended)](const Result& result) {
        ended(result);
        end_mapping(result, entries);
      });
  mapped_ = mapped_ && mapping_under_way_;
  outputs_.reset();
  if (!mapped_) return mapping_under_way_;
  outputs_.emplace(client_, 0);
  for (const unsigned number : {kMappingObject, kMappingObject + 1}) objects_.forget(number);
  return true;
}

void FrameSide::end_mapping(const Result& result, bool entries) {
  mapping_under_way_ = false;
  if (result.replied && result.code == gateway_REPLY_DONE)
    in_force_ = entries;
  else if (!result.replied)
    in_force_ |= entries;
  if (next_mapping_) {
    Mapping next = *std::exchange(next_mapping_, std::nullopt);
    const Ended ended = next.ended;
    if (!result.replied || !map(std::move(next))) ended({{.reason = "the daemon has gone"}});
  } else if (!result.replied || result.code != gateway_REPLY_DONE) {
    mapped_ = false;
  }
}

bool FrameSide::reserved(unsigned number) const noexcept {
  if (number >= static_cast<unsigned>(kReceiveObject)) return basic_.configured();
  return number >= kMappingObject && mapped_;
}

std::string FrameSide::write_outputs(std::uint16_t address, std::span<const std::uint8_t> bytes) {
  if (!mapped_ || !outputs_)
    return "client: no data mapping is set up; call CAN_DMAP, also after another start of the daemon";
  if (address + bytes.size() > inputs_.size())
    return "client: address and bytes: end after the image; allowed 0..1024 together";
  if (mapping_under_way_ || !outputs_->matched())
    return "client: the daemon has not taken the mapping over yet; call again in the next cycle";
  const std::string problem = outputs_->write(address, bytes);
  return problem.empty() ? problem : "client: " + problem;
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

void FrameConnection::load_data_block(int number, std::vector<std::uint8_t> bytes) {
  side_->load_data_block(number, std::move(bytes));
}

std::span<const std::uint8_t, 1024> FrameConnection::inputs() const noexcept {
  return side_->inputs();
}

std::string FrameConnection::write_outputs(std::uint16_t address, std::span<const std::uint8_t> bytes) {
  return side_->write_outputs(address, bytes);
}

void FrameConnection::on_interrupt(int number, std::function<void(const Interrupt&)> routine) {
  side_->set_routine(number, std::move(routine));
}

}  // namespace cansync::client
