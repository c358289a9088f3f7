#include "client/src/j1939/message_side.h"

#include <cansync/message_connection.h>

#include <algorithm>
#include <utility>

#include "client/src/connect_options.h"
#include "client/src/layer2/bus_facts.h"
#include "dds/bounded_text.h"
#include "j1939/identifier.h"

namespace cansync::client {
namespace detail {
namespace {

// Of NodeStatus.claim_state.
constexpr std::string_view kClaimed = "claimed";
constexpr std::string_view kListening = "listening";

/// The identifier that a message of one frame had.
std::uint32_t identifier_of(const j1939_ReceivedMessage& message) {
  return j1939::compose(
      j1939::identifier_of(message.pgn, message.priority, message.destination, message.source));
}

}  // namespace

MessageSide::MessageSide(const Options& options)
    : client_(connect_to<j1939::client::MessageClient>(options)), open_(client_) {
  if (!client_.status(first_status_wait(options)))
    throw NoDaemon("the daemon tells nothing of itself as a node (" + client_.place() + ")");
}

void MessageSide::look() {
  client_.look({.ended = [this](std::uint64_t request,
                                const j1939::client::Result& result) { open_.ended(request, result); },
                .batch = [this](const j1939_MessageBatch& batch) { note(batch); }});
  if (open_.watch_daemon()) {
    restarted_ = true;
    batch_ = lost_ = 0;
    queues_.clear();  // what was meant for the daemon before is not sent by the next one
  }
  queues_.hand_over([this](const Frame& frame, bool /*high*/) { return begin(frame); });
}

void MessageSide::note(const j1939_MessageBatch& batch) {
  if ((batch_ != 0 && batch.number != batch_ + 1) || (batch_ != 0 && batch.lost != lost_)) queues_.missed();
  batch_ = batch.number;
  lost_ = batch.lost;
  for (std::uint32_t i = 0; i < batch.messages._length; ++i) {
    const j1939_ReceivedMessage& message = batch.messages._buffer[i];
    if (message.transport != j1939_TRANSPORT_FRAME) continue;
    Frame frame;
    frame.identifier = identifier_of(message);
    frame.length = static_cast<std::uint8_t>(std::min<std::uint32_t>(message.data._length, 8));
    std::copy_n(message.data._buffer, frame.length, frame.bytes.begin());
    queues_.received(frame, false);
  }
}

bool MessageSide::begin(const Frame& frame) {
  if (open_.full()) return false;
  const j1939::Identifier parts = j1939::parse(frame.identifier);
  const j1939::Pgn number = j1939::pgn_of(parts);
  j1939::client::Message message;
  message.pgn = number;
  message.priority = parts.priority;
  message.destination = j1939::has_destination(number) ? parts.specific : j1939::kGlobalAddress;
  message.data.assign(frame.bytes.begin(), frame.bytes.begin() + frame.length);
  return open_.begin(
      [&](j1939::client::MessageClient& client) { return client.begin(j1939_MESSAGE_SEND, message, 0); },
      [this](const j1939::client::Result& result) {
        queues_.ended();
        if (result.replied && result.code == gateway_REPLY_DONE) return;
        ++failures_;
        failure_ = "daemon: " + result.reason;
      });
}

/// What the daemon told last of its claim.
std::string_view MessageSide::claim() const {
  const auto& status = client_.newest_status();
  return status ? gateway::dds::text(status->claim_state) : "unknown";
}

std::string MessageSide::obstacle() {
  if (!daemon_present()) return "client: no daemon serves the bus";
  if (claim() == kClaimed) return {};
  return "daemon: it has no address on this bus (" + std::string(claim()) +
         "); give it address.preferred, or wait until it is claimed";
}

std::string MessageSide::silence() {
  if (!daemon_present()) return "client: no daemon serves the bus";
  if (claim() == kClaimed || claim() == kListening) return {};
  return "daemon: it has no address on this bus (" + std::string(claim()) + ")";
}

std::optional<std::uint8_t> MessageSide::address() {
  if (claim() != kClaimed) return std::nullopt;
  return static_cast<std::uint8_t>(client_.newest_status()->address);
}

std::uint16_t MessageSide::status_word() {
  layer2::StatusFacts facts = facts_of(client_.bus_status());
  facts.running = silence().empty();
  facts.send = queues_.sending();
  facts.receive = queues_.receiving();
  return layer2::status_word(facts);
}

}  // namespace detail

MessageConnection::MessageConnection(std::unique_ptr<detail::MessageSide> side) noexcept
    : side_(std::move(side)) {}
MessageConnection::MessageConnection(MessageConnection&& other) noexcept = default;
MessageConnection& MessageConnection::operator=(MessageConnection&& other) noexcept = default;
MessageConnection::~MessageConnection() = default;

MessageConnection MessageConnection::connect(const Options& options) {
  return MessageConnection(std::make_unique<detail::MessageSide>(options));
}

bool MessageConnection::daemon_present() const {
  return side_->daemon_present();
}

}  // namespace cansync::client
