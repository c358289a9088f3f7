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
    if (from.source < kNullAddress && frame.dlc == 8) control(bus, frame, from, now);
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
    all.refused += counters.refused;
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
void RecordedBus::control(std::uint32_t bus, const can::Frame& frame, const Identifier& from, Time now) {
  const bool extended = pgn_of(from) == pgn::kExtendedTransportControl;
  const Address destination = destination_of(from);
  const Key to{bus, destination, extended};
  const Key back{bus, from.source, extended};
  switch (static_cast<Control>(frame.data[0])) {
    case Control::bam:
      if (!extended && destination == kGlobalAddress)
        if (TransportReceiver* receiver = find_or_make(to, now)) receiver->announce(from, frame, now);
      break;
    case Control::rts:
      if (!extended && destination < kNullAddress)
        if (TransportReceiver* receiver = find_or_make(to, now))
          receiver->request(from, frame, destination, now);
      break;
    case Control::extended_rts:
      if (extended && destination < kNullAddress)
        if (TransportReceiver* receiver = find_or_make(to, now))
          receiver->request_extended(from, frame, destination, now);
      break;
    case Control::extended_offset:
      if (TransportReceiver* receiver = find(to, now)) receiver->offset(from, frame, now);
      break;
    case Control::cts:
    case Control::extended_cts:
      if (TransportReceiver* receiver = find(back, now))
        receiver->cleared_to_send(destination, pgn_in(frame), extended, now);
      break;
    case Control::abort:
      if (TransportReceiver* receiver = find(to, now))
        receiver->aborted(from.source, pgn_in(frame), extended);
      if (TransportReceiver* receiver = find(back, now))
        receiver->aborted(destination, pgn_in(frame), extended);
      break;
    default:
      break;
  }
}

}  // namespace j1939::client
