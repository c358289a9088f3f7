#include "j1939/dds/convert.h"

#include <algorithm>
#include <chrono>
#include <iterator>

#include "dds/bounded_text.h"
#include "j1939/dds/texts.h"
#include "j1939/diagnostics.h"
#include "j1939/transport.h"

namespace j1939::dds {
namespace {

j1939_MessageReply reply_to(const gateway::dds::RequestKey& key) noexcept {
  j1939_MessageReply reply = {};
  std::copy(key.client.begin(), key.client.end(), std::begin(reply.client));
  reply.request = key.request;
  return reply;
}

}  // namespace

Time monitoring_time(std::size_t bytes, Time default_timeout) noexcept {
  return bytes <= 8 ? default_timeout : default_timeout + kPacketTime * packets_of(bytes);
}

std::size_t bytes_of(const j1939_MessageRequest& request) noexcept {
  return std::size_t{request.data._length} + request.long_data._length;
}

Order to_core(const j1939_MessageRequest& request, OrderId id, Time default_timeout, std::size_t most,
              std::vector<std::uint8_t>& memory) {
  Order order;
  order.id = id;
  order.kind = request.kind == j1939_MESSAGE_ASK ? OrderKind::request : OrderKind::send;
  order.number = request.pgn;
  order.priority = request.priority;
  order.destination = request.destination;
  const Time timeout = std::chrono::milliseconds(request.timeout);
  order.timeout = timeout == Time{0} ? monitoring_time(bytes_of(request), default_timeout) : timeout;
  if (order.kind == OrderKind::send) {
    const auto& data = request.data._length != 0 ? request.data._buffer : request.long_data._buffer;
    memory.assign(data, data + bytes_of(request));
  } else {
    memory.assign(request.destination == kGlobalAddress ? 0 : most, 0);
  }
  order.memory = memory;
  return order;
}

j1939_ReceivedMessage received_message(const Message& message, std::int64_t receive_time,
                                       std::uint8_t range) noexcept {
  j1939_ReceivedMessage out = {};
  out.pgn = message.number;
  out.priority = message.priority;
  out.source = message.source;
  out.destination = message.destination;
  out.transport = message.transport == Transport::frame       ? j1939_TRANSPORT_FRAME
                  : message.transport == Transport::broadcast ? j1939_TRANSPORT_BROADCAST
                  : message.transport == Transport::extended  ? j1939_TRANSPORT_EXTENDED
                                                              : j1939_TRANSPORT_CONNECTION;
  out.receive_time = receive_time;
  out.range_index = range;
  out.data._length = static_cast<std::uint32_t>(message.data.size());
  out.data._maximum = out.data._length;
  out.data._buffer = const_cast<std::uint8_t*>(message.data.data());  // lent: DDS only reads it
  return out;
}

j1939_LongMessage long_message(const Message& message, std::int64_t receive_time, std::uint8_t range,
                               std::uint64_t number) noexcept {
  j1939_LongMessage out = {};
  out.number = number;
  out.pgn = message.number;
  out.priority = message.priority;
  out.source = message.source;
  out.destination = message.destination;
  out.receive_time = receive_time;
  out.range_index = range;
  out.data._length = static_cast<std::uint32_t>(message.data.size());
  out.data._maximum = out.data._length;
  out.data._buffer = const_cast<std::uint8_t*>(message.data.data());  // lent: DDS only reads it
  return out;
}

gateway_ReplyCode to_reply_code(Outcome outcome) noexcept {
  switch (outcome) {
    case Outcome::done:
      return gateway_REPLY_DONE;
    case Outcome::refused:
    case Outcome::aborted:
      return gateway_REPLY_SLAVE_ERROR;
    case Outcome::no_answer:
      return gateway_REPLY_NO_ANSWER;
    case Outcome::timeout:
      return gateway_REPLY_TIMEOUT;
    case Outcome::cancelled:
      return gateway_REPLY_CANCELLED;
    case Outcome::address_lost:
    case Outcome::stopped:
      break;
  }
  return gateway_REPLY_MASTER_STOPPED;
}

j1939_MessageReply message_reply(const gateway::dds::RequestKey& key, const Answer& answer,
                                 std::int64_t sent_time, std::span<std::uint8_t> data) {
  j1939_MessageReply reply = reply_to(key);
  reply.code = to_reply_code(answer.outcome);
  gateway::dds::copy_text(reason_of(answer), reply.reason);
  reply.answer_code = answer.code;
  if (answer.outcome != Outcome::done) return reply;
  reply.sent_time = sent_time;
  const auto lend = [&](auto& to) {
    to._length = static_cast<std::uint32_t>(std::min<std::size_t>(answer.size, data.size()));
    to._maximum = to._length;
    to._buffer = data.data();  // lent
  };
  if (answer.size > kMostBytes) {
    lend(reply.long_data);
  } else {
    lend(reply.data);
  }
  return reply;
}

j1939_MessageReply message_refused(const gateway::dds::RequestKey& key,
                                   const gateway::dds::Denial& denial) noexcept {
  j1939_MessageReply reply = reply_to(key);
  gateway::dds::refuse(reply, denial);
  return reply;
}

bool fault_list(std::span<const std::uint8_t> message, std::uint8_t source, bool active,
                std::int64_t receive_time, std::vector<j1939_TroubleCode>& memory, j1939_FaultList& out) {
  const auto lamps = lamps_of(message);
  if (!lamps) return false;
  memory.clear();
  for (std::size_t i = 0; i < trouble_codes_in(message); ++i) {
    const TroubleCode code = trouble_code(message, i);
    j1939_TroubleCode entry = {};
    entry.spn = code.spn;
    entry.fmi = code.fmi;
    entry.occurrences = code.occurrences;
    entry.old_conversion = code.old_conversion;
    memory.push_back(entry);
  }
  out = {};
  out.source = source;
  out.active = active;
  out.receive_time = receive_time;
  out.malfunction_lamp = static_cast<std::uint8_t>(lamps->malfunction);
  out.red_stop_lamp = static_cast<std::uint8_t>(lamps->red_stop);
  out.amber_warning_lamp = static_cast<std::uint8_t>(lamps->amber_warning);
  out.protect_lamp = static_cast<std::uint8_t>(lamps->protect);
  out.codes._length = static_cast<std::uint32_t>(memory.size());
  out.codes._maximum = out.codes._length;
  out.codes._buffer = memory.data();  // lent
  return true;
}

}  // namespace j1939::dds
