#include "cli/look/event_filter.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <ctime>

#include "cli/text/values.h"

namespace cansync::cli {
namespace {

constexpr std::int64_t kSecondInNs = 1'000'000'000;
constexpr std::int64_t kDay = 86400;            // seconds
constexpr std::int64_t kMostUnits = 1'000'000;  // of a length of time: more than any daemon runs

[[noreturn]] void refuse_since(std::string_view text) {
  throw UsageError(fmt::format(
      "--since: found '{}'; allowed: how long ago (90s, 10m, 2h, 1d), a time of day (14:05, 14:05:30), or a "
      "date with or without one ('2026-11-23', '2026-11-23 14:05'), none of them in the future",
      text));
}

/// Seconds of "90s", "10m", "2h", "1d"; nothing: it is none of these.
std::optional<std::int64_t> length_of_time(std::string_view text) {
  std::int64_t count = 0;
  const char* end = text.data() + text.size();
  const auto [rest, problem] = std::from_chars(text.data(), end, count);
  if (problem != std::errc() || rest + 1 != end || count < 0 || count > kMostUnits) return std::nullopt;
  switch (*rest) {
    case 's':
      return count;
    case 'm':
      return count * 60;
    case 'h':
      return count * 3600;
    case 'd':
      return count * kDay;
    default:
      return std::nullopt;
  }
}

/// The whole of `text` in this form of strptime, into `parts`.
bool has_form(const std::string& text, const char* form, std::tm& parts) {
  const char* rest = ::strptime(text.c_str(), form, &parts);
  return rest != nullptr && *rest == '\0';
}

/// Seconds since 1970 of a local time, whose hour decides about summer time.
std::int64_t seconds_of(std::tm parts) {
  parts.tm_isdst = -1;
  return std::mktime(&parts);
}

/// A local time, the last one before `now` when no date is given; nothing: no such form.
std::optional<std::int64_t> local_time(const std::string& text, std::int64_t now) {
  for (const char* form : {"%Y-%m-%d %H:%M:%S", "%Y-%m-%d %H:%M", "%Y-%m-%d"}) {
    std::tm parts{};
    if (has_form(text, form, parts)) return seconds_of(parts);
  }
  for (const char* form : {"%H:%M:%S", "%H:%M"}) {
    const std::time_t today = now;
    std::tm parts{};
    if (localtime_r(&today, &parts) == nullptr) return std::nullopt;
    parts.tm_sec = 0;
    if (!has_form(text, form, parts)) continue;
    const std::int64_t found = seconds_of(parts);
    if (found <= now) return found;
    --parts.tm_mday;
    return seconds_of(parts);
  }
  return std::nullopt;
}

}  // namespace

bool passes(const EventFilter& filter, const client::Event& event) {
  if (event.time < filter.since || event.severity < filter.least) return false;
  const std::string_view code = event.code;
  if (!filter.codes.empty() &&
      std::find(filter.codes.begin(), filter.codes.end(), code) == filter.codes.end())
    return false;
  if (!filter.slaves) return true;
  return event.slave >= 0 && event.slave < 32 && ((*filter.slaves >> event.slave) & 1u) != 0;
}

std::int64_t parse_since(std::string_view text, std::int64_t now) {
  if (const auto length = length_of_time(text)) {
    if (*length > now / kSecondInNs) refuse_since(text);
    return now - *length * kSecondInNs;
  }
  const auto found = local_time(std::string(text), now / kSecondInNs);
  if (!found || *found < 0 || *found > now / kSecondInNs) refuse_since(text);
  return *found * kSecondInNs;
}

gateway_EventSeverity parse_severity(std::string_view text) {
  if (text == "info") return gateway_SEVERITY_INFO;
  if (text == "warning") return gateway_SEVERITY_WARNING;
  if (text == "error") return gateway_SEVERITY_ERROR;
  throw UsageError(fmt::format("--level: found '{}'; allowed: info, warning, error", text));
}

std::vector<std::string> parse_codes(std::string_view text) {
  const auto in_code = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
  std::vector<std::string> codes;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    codes.emplace_back(text.substr(at, end - at));
    at = end + 1;
    if (codes.back().empty() || !std::all_of(codes.back().begin(), codes.back().end(), in_code))
      throw UsageError(fmt::format(
          "--code: found '{}'; allowed: codes of events as the column CODE has them, with commas between, such as "
          "slave_lost,slave_returned",
          text));
  }
  return codes;
}

}  // namespace cansync::cli
