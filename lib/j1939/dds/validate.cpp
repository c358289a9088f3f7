#include "j1939/dds/validate.h"

#include <fmt/format.h>

#include <cstdint>

#include "dds/enumerator.h"
#include "j1939/dds/convert.h"
#include "j1939/identifier.h"
#include "j1939/transport.h"
#include "text/counts.h"

namespace j1939::dds {

using gateway::dds::Denial;
using gateway::dds::Problem;

namespace {

Problem check_group(const j1939_MessageRequest& request) {
  const Pgn number = request.pgn;
  if (number > kLargestPgn)
    return Denial{gateway_CAUSE_FIELD,
                  fmt::format("pgn 0x{:X}: out of range; allowed 0..0x{:X}", number, kLargestPgn)};
  if (!is_pgn(number))
    return Denial{gateway_CAUSE_FIELD,
                  fmt::format("pgn 0x{:X}: its lowest byte is the destination's place below PDU format 240; "
                              "allowed 0x{:X}, with `destination` beside it",
                              number, number & ~0xFFu)};
  return std::nullopt;
}

Problem check_destination(const j1939_MessageRequest& request) {
  if (request.destination == kNullAddress)
    return Denial{gateway_CAUSE_FIELD, "destination 254: nobody has it; allowed 0..253, or 255 for all"};
  const bool one_frame = request.kind == j1939_MESSAGE_SEND && bytes_of(request) <= 8;
  if (one_frame && !has_destination(request.pgn) && request.destination != kGlobalAddress)
    return Denial{gateway_CAUSE_FIELD,
                  fmt::format("destination {}: a group from PDU format 240 on goes to all; allowed 255, or "
                              "over 8 bytes of data",
                              request.destination)};
  return std::nullopt;
}

}  // namespace

Problem check(const j1939_MessageRequest& request) {
  const std::int64_t kind = gateway::dds::raw_number_of(request.kind);
  if (kind != j1939_MESSAGE_SEND && kind != j1939_MESSAGE_ASK)
    return Denial{gateway_CAUSE_KIND,
                  fmt::format("kind {}: not known; allowed MESSAGE_SEND, MESSAGE_ASK", kind)};
  if (auto problem = check_group(request)) return problem;
  if (request.priority > 7)
    return Denial{gateway_CAUSE_FIELD,
                  fmt::format("priority {}: out of range; allowed 0..7", request.priority)};
  if (request.data._length > kMostBytes)
    return Denial{gateway_CAUSE_LENGTH, fmt::format("data: {}; allowed 0..{}, more in `long_data`",
                                                    text::counted(request.data._length, "byte"), kMostBytes)};
  if (request.long_data._length != 0 &&
      (request.data._length != 0 || request.long_data._length <= kMostBytes ||
       request.long_data._length > j1939_LONG_MESSAGE_BYTES))
    return Denial{gateway_CAUSE_LENGTH,
                  fmt::format("long_data: {} beside {} of data; allowed {}..{}, and none of data",
                              text::counted(request.long_data._length, "byte"), request.data._length,
                              kMostBytes + 1, j1939_LONG_MESSAGE_BYTES)};
  if (request.kind == j1939_MESSAGE_ASK && bytes_of(request) != 0)
    return Denial{gateway_CAUSE_LENGTH, "data: MESSAGE_ASK has none; allowed 0 bytes"};
  if (auto problem = check_destination(request)) return problem;
  if (request.timeout > kMaximumTimeoutMs)
    return Denial{gateway_CAUSE_FIELD,
                  fmt::format("timeout {} ms: out of range; allowed 0..{} ms, 0 = the daemon's default",
                              request.timeout, kMaximumTimeoutMs)};
  return std::nullopt;
}

Problem explain(Refusal refusal, std::uint16_t queue, std::size_t most) {
  switch (refusal) {
    case Refusal::none:
      return std::nullopt;
    case Refusal::queue_full:
      return Denial{
          gateway_CAUSE_QUEUE_FULL,
          fmt::format(
              "queue full: at most {} may wait to be sent, and 32 requests to be answered; try again when "
              "one has been",
              text::counted(queue, "message"))};
    case Refusal::bad_order:
      return Denial{gateway_CAUSE_FIELD,
                    "pgn: carried by the transport protocol or the address claim themselves (0xC700, 0xC800, "
                    "0xEB00, 0xEC00, 0xEE00); allowed are all others"};
    case Refusal::too_long:
      return Denial{gateway_CAUSE_LENGTH,
                    fmt::format("data: the daemon is set to at most {} (transport.most_bytes)",
                                text::counted(most, "byte"))};
    case Refusal::too_long_for_all:
      return Denial{gateway_CAUSE_LENGTH,
                    fmt::format("data: over {} bytes go to one node, not to all; name a destination 0..253",
                                kMostBytes)};
    case Refusal::no_address:
      return Denial{gateway_CAUSE_WRONG_STATE,
                    "the daemon has no address on this bus: it was given none (address.preferred), or a "
                    "stronger NAME has it; NodeStatus says which"};
    case Refusal::stopped:
      break;
  }
  return Denial{gateway_CAUSE_STOPPING, "the daemon is being stopped; send again when it runs"};
}

}  // namespace j1939::dds
