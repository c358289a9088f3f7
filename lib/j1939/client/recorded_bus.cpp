#include "j1939/client/recorded_bus.h"

#include <algorithm>
#include <span>

#include "j1939/identifier.h"

namespace j1939::client {

std::optional<j1939::Message> RecordedBus::receive(std::uint32_t bus, const can::Frame& frame, Time time) {
  if (!frame.extended || frame.remote || frame.error) {
    ++counters_.foreign;
    return std::nullopt;
  }
  const Identifier from = parse(frame.id);
  const Pgn number = pgn_of(from);
  const Address destination = destination_of(from);
  const Time now = clock(bus, time);
  if (number == pgn::kTransportControl || number == pgn::kExtendedTransportControl) {
    const auto said = transport_control_in(frame);
    if (said && from.source < kNullAddress) control(bus, *said, from, now);
    return std::nullopt;
  }
  if (number == pgn::kTransportData || number == pgn::kExtendedTransportData) {
    TransportReceiver* receiver = find({bus, destination, number == pgn::kExtendedTransportData}, now);
    auto message = receiver == nullptr ? std::nullopt : receiver->packet(from, frame, now);
    if (message) message->end = time;
    return message;
  }
  last_ = frame;
  return j1939::Message{number,
                        from.priority,
                        from.source,
                        destination,
                        Transport::frame,
                        time,
                        std::span<const std::uint8_t>(last_.data).first(std::min<std::size_t>(frame.dlc, 8))};
}

RecordedBus::Counters RecordedBus::counters() const {
  Counters all = counters_;
  for (const auto& [key, destination] : destinations_) {
    const ReceiverCounters& counters = destination.receiver.counters();
    all.incomplete += counters.broken + destination.receiver.open();
    all.refused += counters.refused();
  }
  return all;
}

Time RecordedBus::clock(std::uint32_t bus, Time time) {
  Clock& clock = clocks_[bus];
  if (clock.last && time > *clock.last) clock.now += time - *clock.last;
  clock.last = time;
  return clock.now;
}

TransportReceiver* RecordedBus::find(const Key& key, Time now) {
  const auto found = destinations_.find(key);
  if (found == destinations_.end()) return nullptr;
  found->second.receiver.advance(now);
  found->second.answers.clear();
  return &found->second.receiver;
}

TransportReceiver* RecordedBus::find_or_make(const Key& key, Time now) {
  if (TransportReceiver* receiver = find(key, now)) return receiver;
  if (destinations_.size() == kMostReceivers || (key.extended && extended_ == kMostExtended)) {
    ++counters_.refused;
    return nullptr;
  }
  if (key.extended) ++extended_;
  return &destinations_.try_emplace(key, key.extended ? kMostLongBytes : 0).first->second.receiver;
}

/// What both ends of a connection say; of what the destination says only that matters which moves the time on,
/// or ends the connection.
void RecordedBus::control(std::uint32_t bus, const TransportControl& said, const Identifier& from, Time now) {
  const Address destination = destination_of(from);
  const Key to{bus, destination, said.extended};
  const Key back{bus, from.source, said.extended};
  if (const auto* announced = std::get_if<Announcement>(&said.what)) {
    if (destination != kGlobalAddress) return;
    if (TransportReceiver* receiver = find_or_make(to, now))
      receiver->announce(from, said.number, *announced, now);
  } else if (const auto* request = std::get_if<RequestToSend>(&said.what)) {
    if (destination >= kNullAddress) return;
    if (TransportReceiver* receiver = find_or_make(to, now))
      receiver->request(from, said.number, *request, said.extended, destination, now);
  } else if (const auto* offset = std::get_if<DataOffset>(&said.what)) {
    if (TransportReceiver* receiver = find(to, now)) receiver->offset(from.source, said.number, *offset, now);
  } else if (std::holds_alternative<ClearToSend>(said.what)) {
    if (TransportReceiver* receiver = find(back, now))
      receiver->cleared_to_send(destination, said.number, said.extended, now);
  } else if (std::holds_alternative<Abort>(said.what)) {
    if (TransportReceiver* receiver = find(to, now))
      receiver->aborted(from.source, said.number, said.extended);
    if (TransportReceiver* receiver = find(back, now))
      receiver->aborted(destination, said.number, said.extended);
  }
}

}  // namespace j1939::client
