#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "cansync.h"
#include "daemon/cansync/config/config.h"
#include "daemon/cansync/exchange.h"
#include "daemon/service/event_codes.h"

/// What the realtime thread reports, in words. Pure functions; not for the realtime thread (allocates).
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
  int slave = -1;  ///< 0..31; -1: none
  std::string text;
  std::optional<Moment> when;                           ///< nothing: now
  std::optional<RequestRecord> request = std::nullopt;  ///< has its own entry in the journal
  std::string client = {};                              ///< who has to do with it, for the journal
  int parameter = -1;                                   ///< number, for the journal; -1: none
};

/// The kind of a master's event.
EventCode code_of(cansync::MasterEvent::Code code);

/// The event that stands for `report`; nothing for reports that are no events (progress of a transfer), or
/// that are counted before they become one (refused reference values).
std::optional<EventText> describe(const Report& report, const Config& config);

}  // namespace cansyncd
