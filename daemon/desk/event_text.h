#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "daemon/loop/moment.h"
#include "daemon/service/event_codes.h"
#include "gateway.h"

namespace cansyncd {

/// The request of a client that an event tells of (request_done, request_failed, request_refused).
struct RequestRecord {
  std::string client;
  std::string participant;
  std::string_view action;  ///< stable word; a literal
  std::string old_value;
  std::string new_value;
  std::string result;
};

/// One event before it is numbered and published.
struct EventText {
  gateway_EventSeverity severity = gateway_SEVERITY_INFO;
  EventCode code;
  int slave = -1;  ///< number; -1: none
  std::string text;
  std::optional<Moment> when;                           ///< nothing: now
  std::optional<RequestRecord> request = std::nullopt;  ///< has its own entry in the journal
  std::string client = {};                              ///< who has to do with it, for the journal
  std::string participant = {};                         ///< its DDS participant, hexadecimal
  int parameter = -1;                                   ///< number, for the journal; -1: none
};

}  // namespace cansyncd
