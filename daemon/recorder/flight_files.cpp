#include "daemon/recorder/flight_files.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <map>
#include <string_view>
#include <system_error>

#include "can/bus_names.h"
#include "can/candump.h"
#include "daemon/service/replace_file.h"
#include "text/json.h"

namespace cansyncd {
namespace {

namespace fs = std::filesystem;
using Kind = rt::FlightEntry::Kind;
using text::json_string;

constexpr can::Frame kSyncFrame{.id = 0x080};
constexpr std::string_view kLog = ".log";
constexpr std::string_view kHeader = ".json";
constexpr std::string_view kHalf = ".new";  // of `replace_file`

std::string safe(std::string_view name) {
  std::string out(name);
  for (char& c : out) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '_' && c != '-') c = '_';
  }
  return out;
}

/// What the files of this bus begin with.
std::string prefix(const FlightFileSettings& settings) {
  return "flight-" + safe(settings.bus) + "-";
}

const char* reason_of(const FlightRecording& recording) noexcept {
  return name(static_cast<FlightReason>(recording.trigger.reason));
}

std::string stem(const FlightRecording& recording, const FlightFileSettings& settings) {
  const auto wall = recording.trigger.at + recording.trigger.wall_clock_offset;
  const auto seconds = std::chrono::floor<std::chrono::seconds>(wall);
  const auto millis = std::chrono::floor<std::chrono::milliseconds>(wall - seconds);
  const std::time_t time = seconds.count();
  return fmt::format("{}{:%Y%m%dT%H%M%S}.{:03}Z-{}", prefix(settings), fmt::gmtime(time), millis.count(),
                     reason_of(recording));
}

const char* name_of(can::SendResult result) noexcept {
  switch (result) {
    case can::SendResult::queued:
      return "queued";
    case can::SendResult::queue_full:
      return "queue_full";
    case can::SendResult::bus_off:
      return "bus_off";
    case can::SendResult::interface_down:
      return "interface_down";
    case can::SendResult::not_delivered:
      return "not_delivered";
  }
  return "unknown";
}

std::string_view name_of(FlightProtocol::Name name, std::uint32_t number) noexcept {
  return name == nullptr ? "unknown" : name(number);
}

/// One entry as a JSON object, for the list its kind has in the header.
std::string object_of(const rt::FlightEntry& entry, can::Time offset, const FlightProtocol& protocol) {
  const auto at = (entry.at + offset).count();
  switch (entry.kind) {
    case Kind::wake:
    case Kind::edge:
      return fmt::format("{{\"interval\": {}, \"due_ns\": {}, \"actual_ns\": {}}}", entry.interval,
                         (entry.due + offset).count(), at);
    case Kind::sent:
      return fmt::format("{{\"interval\": {}, \"time_ns\": {}, \"id\": {}, \"result\": \"{}\"}}",
                         entry.interval, at, entry.frame.id,
                         name_of(static_cast<can::SendResult>(entry.value)));
    case Kind::left_out:
      return fmt::format("{{\"interval\": {}, \"time_ns\": {}, \"slot\": \"{}\"}}", entry.interval, at,
                         name_of(protocol.slot, entry.value));
    case Kind::state:
      return fmt::format("{{\"interval\": {}, \"time_ns\": {}, \"state\": \"{}\"}}", entry.interval, at,
                         name_of(protocol.state, entry.value));
    case Kind::controller:
      return fmt::format("{{\"interval\": {}, \"time_ns\": {}, \"controller\": \"{}\"}}", entry.interval, at,
                         name(static_cast<can::ControllerState>(entry.value)));
    case Kind::received:
    case Kind::echo:
      break;
  }
  return "{}";
}

void add_list(std::string& out, std::string_view key, const FlightRecording& recording,
              const FlightProtocol& protocol, std::initializer_list<Kind> kinds) {
  fmt::format_to(std::back_inserter(out), ",\n  \"{}\": [", key);
  const char* between = "\n    ";
  for (const rt::FlightEntry& entry : recording.entries) {
    if (std::find(kinds.begin(), kinds.end(), entry.kind) == kinds.end()) continue;
    out += between;
    out += object_of(entry, recording.trigger.wall_clock_offset, protocol);
    between = ",\n    ";
  }
  out += "]";
}

bool on_bus(const rt::FlightEntry& entry) noexcept {
  return entry.kind == Kind::received || entry.kind == Kind::echo;
}

/// What is between the time and the ending in the name of a file of this bus's recordings, e.g. "bus_off" of
/// `.log`; empty: it is none. The buses "a" and "a-b" may share a folder.
std::string_view reason_in(std::string_view file, std::string_view prefix, std::string_view ending) {
  constexpr std::string_view kTime = "ddddddddTdddddd.dddZ-";
  if (!file.starts_with(prefix) || !file.ends_with(ending)) return {};
  file.remove_prefix(prefix.size());
  if (file.size() <= kTime.size() + ending.size()) return {};
  file.remove_suffix(ending.size());
  const bool timed = std::equal(kTime.begin(), kTime.end(), file.begin(), [](char wanted, char found) {
    return wanted == 'd' ? std::isdigit(static_cast<unsigned char>(found)) != 0 : wanted == found;
  });
  file.remove_prefix(kTime.size());
  return timed ? file : std::string_view{};
}

/// The files of this bus's recordings with that ending.
std::vector<fs::path> files_of(const FlightFileSettings& settings, std::string_view ending) {
  std::error_code error;
  std::vector<fs::path> found;
  for (fs::directory_iterator entry(settings.folder, error), end; !error && entry != end;
       entry.increment(error)) {
    if (!reason_in(entry->path().filename().string(), prefix(settings), ending).empty())
      found.push_back(entry->path());
  }
  return found;
}

/// Removes recordings of this bus until as many are left as are kept; `newest` has just been written. What
/// cannot be removed stays.
void prune(const FlightFileSettings& settings, const fs::path& newest) {
  std::vector<fs::path> headers = files_of(settings, kHeader);
  // The names begin with the time. One later than the newest was made before the wall clock was set back.
  std::sort(headers.begin(), headers.end(), [&](const fs::path& a, const fs::path& b) {
    const bool a_before = a.filename() > newest.filename();
    const bool b_before = b.filename() > newest.filename();
    return a_before != b_before ? a_before : a < b;
  });
  const auto reason = [&](const fs::path& header) {
    return std::string(reason_in(header.filename().string(), prefix(settings), kHeader));
  };
  std::map<std::string, std::size_t> of_reason;
  for (const fs::path& header : headers) ++of_reason[reason(header)];
  std::error_code error;
  while (headers.size() > std::max(settings.files, 1U)) {
    // What happens often, or is asked for often, takes no place from what is rare.
    std::size_t most = 0;
    for (const fs::path& header : headers)
      if (header != newest) most = std::max(most, of_reason[reason(header)]);
    const auto oldest = std::find_if(headers.begin(), headers.end(), [&](const fs::path& header) {
      return header != newest && of_reason[reason(header)] == most;
    });
    if (oldest == headers.end()) return;
    --of_reason[reason(*oldest)];
    fs::remove(fs::path(*oldest).replace_extension(kLog), error);
    fs::remove(*oldest, error);
    headers.erase(oldest);
  }
}

}  // namespace

std::string flight_candump(const FlightRecording& recording, const FlightFileSettings& settings) {
  std::vector<rt::FlightEntry> lines;
  std::copy_if(recording.entries.begin(), recording.entries.end(), std::back_inserter(lines),
               [](const rt::FlightEntry& entry) { return on_bus(entry) || entry.kind == Kind::edge; });
  std::stable_sort(lines.begin(), lines.end(),
                   [](const rt::FlightEntry& a, const rt::FlightEntry& b) { return a.at < b.at; });
  std::string out;
  std::array<char, can::kCandumpLineLimit> line{};
  for (const rt::FlightEntry& entry : lines) {
    const auto time =
        std::chrono::floor<std::chrono::microseconds>(entry.at + recording.trigger.wall_clock_offset);
    const bool edge = entry.kind == Kind::edge;
    const std::size_t size = can::write_candump_line(
        time, edge ? std::string_view("sync") : settings.interface, edge ? kSyncFrame : entry.frame, line);
    out.append(line.data(), size);
  }
  return out;
}

std::string flight_header(const FlightRecording& recording, const FlightFileSettings& settings,
                          const std::string& log) {
  const rt::FlightTrigger& trigger = recording.trigger;
  const auto frames = std::count_if(recording.entries.begin(), recording.entries.end(), on_bus);
  std::string out = fmt::format(
      "{{\n  \"format\": 1,\n  \"bus\": {},\n  \"interface\": {},\n  \"bit_rate\": {},\n  \"interval_ns\": "
      "{},\n"
      "  \"reason\": \"{}\",\n  \"detail\": {},\n  \"fault_interval\": {},\n  \"fault_time_ns\": {},\n"
      "  \"faults_without_recording\": {},\n  \"candump\": {},\n  \"frames\": {}",
      json_string(settings.bus), json_string(settings.interface), settings.bits_per_second,
      settings.protocol.interval.count(), reason_of(recording), trigger.detail, trigger.interval,
      (trigger.at + trigger.wall_clock_offset).count(), recording.further_faults, json_string(log), frames);
  add_list(out, "states", recording, settings.protocol, {Kind::state, Kind::controller});
  add_list(out, "left_out", recording, settings.protocol, {Kind::left_out});
  add_list(out, "handed_over", recording, settings.protocol, {Kind::sent});
  add_list(out, "sync_edges", recording, settings.protocol, {Kind::edge});
  add_list(out, "wake_ups", recording, settings.protocol, {Kind::wake});
  return out + "\n}\n";
}

void remove_half_recordings(const FlightFileSettings& settings) {
  std::error_code error;
  for (const std::string_view ending : {kLog, kHeader}) {
    for (const fs::path& half : files_of(settings, std::string(ending) + std::string(kHalf)))
      fs::remove(half, error);
  }
  for (const fs::path& log : files_of(settings, kLog)) {
    if (!fs::exists(fs::path(log).replace_extension(kHeader), error)) fs::remove(log, error);
  }
}

FlightFileResult write_flight(const FlightRecording& recording, const FlightFileSettings& settings) {
  const fs::path path = fs::path(settings.folder) / stem(recording, settings);
  const std::string log = path.string() + std::string(kLog);
  const std::string header = path.string() + std::string(kHeader);
  FlightFileResult result;
  const auto written = [&](const std::string& file, const std::string& text) {
    const auto problem = replace_file(file, text, {.durable = true});
    if (!problem) return true;
    result.problem = fmt::format("{}: {}", file, *problem);
    (void)std::remove(log.c_str());
    return false;
  };
  if (!written(log, flight_candump(recording, settings))) return result;
  if (!written(header, flight_header(recording, settings, fs::path(log).filename().string()))) return result;
  result.log = log;
  result.frames =
      static_cast<std::size_t>(std::count_if(recording.entries.begin(), recording.entries.end(), on_bus));
  prune(settings, header);
  return result;
}

}  // namespace cansyncd
