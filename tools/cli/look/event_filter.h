#pragma once

#include <cansync/topics.h>
#include <cansync/types.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// Which of the daemon's events are shown. Not for the realtime thread.
namespace cansync::cli {

/// What an event must be to be shown.
struct EventFilter {
  std::int64_t since = 0;                               ///< CLOCK_REALTIME in ns: that old at most
  gateway_EventSeverity least = gateway_SEVERITY_INFO;  ///< at least as grave
  std::vector<std::string> codes;                       ///< one of these; empty: any
  std::optional<std::uint32_t> slaves;                  ///< concerns one of this mask; nothing: any or none
};

bool passes(const EventFilter& filter, const client::Event& event);

/// An instant in the past, CLOCK_REALTIME in ns: so long before `now` ("90s", "10m", "2h", "1d"), a time of
/// day ("14:05", "14:05:30": the last such time), or a date with or without one ("2026-11-23 14:05"), in the
/// time zone of this computer. Throws UsageError.
std::int64_t parse_since(std::string_view text, std::int64_t now);

/// "info", "warning" or "error". Throws UsageError.
gateway_EventSeverity parse_severity(std::string_view text);

/// Codes with commas between. Throws UsageError for what cannot be one.
std::vector<std::string> parse_codes(std::string_view text);

}  // namespace cansync::cli
