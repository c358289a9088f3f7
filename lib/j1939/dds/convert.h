#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "dds/denial.h"
#include "dds/request_key.h"
#include "j1939.h"
#include "j1939/message.h"
#include "j1939/order.h"

/// Between the structs of the IDL and those of the core. Requests must have passed `check` (validate.h).
/// Gateway thread.
namespace j1939::dds {

/// `default_timeout` (over 0) counts for a request that names none, and kPacketTime for each packet besides.
/// `memory` gets the data, or room for an answer of at most `most` bytes; the order points into it.
/// Allocates.
Order to_core(const j1939_MessageRequest& request, OrderId id, Time default_timeout, std::size_t most,
              std::vector<std::uint8_t>& memory);
/// Bytes that a request is to send: those of `data` or of `long_data`.
std::size_t bytes_of(const j1939_MessageRequest& request) noexcept;
/// What a request without a time of its own gets for each of its packets.
inline constexpr Time kPacketTime = std::chrono::milliseconds(200);
/// The monitoring time of so many bytes by default.
Time monitoring_time(std::size_t bytes, Time default_timeout) noexcept;

/// `receive_time` is CLOCK_REALTIME (ns) of the last bit; `range` the position of the range, 0..63. Points at
/// the message's data.
j1939_ReceivedMessage received_message(const Message& message, std::int64_t receive_time,
                                       std::uint8_t range) noexcept;

/// Likewise, of a message of over 1785 bytes; `number` rises by one with each.
j1939_LongMessage long_message(const Message& message, std::int64_t receive_time, std::uint8_t range,
                               std::uint64_t number) noexcept;

/// The code by which an outcome is told.
gateway_ReplyCode to_reply_code(Outcome outcome) noexcept;

/// Terminal reply; `sent_time` is CLOCK_REALTIME (ns) and counts when done alone; `data`, to which the reply
/// points, is an answer's. Allocates.
j1939_MessageReply message_reply(const gateway::dds::RequestKey& key, const Answer& answer,
                                 std::int64_t sent_time, std::span<std::uint8_t> data);
/// Nothing was sent, for this cause and reason.
j1939_MessageReply message_refused(const gateway::dds::RequestKey& key,
                                   const gateway::dds::Denial& denial) noexcept;

/// A diagnostic message of `source`; the codes are written into `memory`, to which the list points. False:
/// too short for one. Allocates.
bool fault_list(std::span<const std::uint8_t> message, std::uint8_t source, bool active,
                std::int64_t receive_time, std::vector<j1939_TroubleCode>& memory, j1939_FaultList& out);

}  // namespace j1939::dds
