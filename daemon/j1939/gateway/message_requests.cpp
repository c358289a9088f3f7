#include "daemon/j1939/gateway/message_requests.h"

#include <fmt/format.h>

#include "daemon/desk/job_desk_answers.h"
#include "daemon/desk/job_desk_oversight.h"
#include "daemon/desk/job_desk_requests.h"
#include "text/counts.h"

namespace cansyncd {

template class JobDesk<MessageRequests>;

/// A request for a group reads, but for one that erases; what is sent may change something.
std::optional<Change> MessageRequests::change_of(const j1939_MessageRequest& sample, const MessageContext&) {
  const bool asks = sample.kind == j1939_MESSAGE_ASK;
  if (asks && !erases(sample.pgn)) return std::nullopt;
  constexpr unsigned kShown = 8;
  Change change;
  change.action = "send_message";
  const std::string destination = sample.destination == j1939::kGlobalAddress
                                      ? std::string("all")
                                      : fmt::format("address {}", sample.destination);
  if (asks) {
    change.new_value =
        fmt::format("request of PGN 0x{:05X} to {}, which erases its faults", sample.pgn, destination);
    return change;
  }
  const auto bytes = j1939::dds::bytes_of(sample);
  change.series = fmt::format("PGN 0x{:05X} to {}", sample.pgn, destination);
  change.new_value = fmt::format("{}, {}", change.series, text::counted(bytes, "byte"));
  for (unsigned i = 0; i < sample.data._length && i < kShown; ++i)
    change.new_value += fmt::format("{}{:02X}", i == 0 ? ": " : " ", sample.data._buffer[i]);
  if (bytes > kShown) change.new_value += " ..";
  change.hashed = bytes > kShown;
  return change;
}

}  // namespace cansyncd
