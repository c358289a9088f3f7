#include "cli/cansync/status_lines.h"

#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <initializer_list>
#include <string_view>
#include <utility>

#include "cansync/dds/lead_axis_writer.h"
#include "cansync_members.h"
#include "cli/base/session.h"
#include "cli/text/values.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

using Status = client::MasterStatus;

/// "released, given by 'lead axis' (lead_axis, process 1234 on host plc7), strength 5"
std::string release_text(const cansync_ReferenceRelease& release) {
  std::string text = release.state;
  if (release.cause[0] != '\0') text += fmt::format(" ({})", release.cause);
  if (release.writer[0] == '\0') return text + ", given by nobody";
  text += fmt::format(", given by {}", release.writer);
  if (release.writer == cansync::dds::kLeadAxisWriter) return text;
  text += fmt::format(", strength {}", release.strength);
  return release.waiting_writer[0] == '\0' ? text : text + fmt::format("; {} waits", release.waiting_writer);
}

/// "0-3 (4 of 4)".
std::string share(std::uint32_t mask, std::uint32_t of) {
  return fmt::format("{} ({} of {})", format_slave_set(mask), __builtin_popcount(mask),
                     __builtin_popcount(of));
}

/// " (3 of wrong length, 9 remote)": the kinds that there are; empty without any.
std::string kinds_text(std::initializer_list<std::pair<std::string_view, std::uint64_t>> kinds) {
  std::string text;
  for (const auto& [name, count] : kinds) {
    if (count != 0) text += fmt::format("{}{} {}", text.empty() ? " (" : ", ", count, name);
  }
  return text.empty() ? text : text + ")";
}

/// "12 rejected (3 of wrong length, 9 remote), 1 unexpected (1 late)".
std::string frames_text(const client::MasterStatus& status) {
  const std::string rejected = kinds_text({{"foreign", status.frames_foreign},
                                           {"extended", status.frames_extended},
                                           {"remote", status.frames_remote},
                                           {"error frames", status.frames_error},
                                           {"of a slave over 31", status.frames_slave_number},
                                           {"of wrong length", status.frames_length},
                                           {"with reserved bits", status.frames_reserved}});
  const std::string unexpected = kinds_text({{"of another slave than asked", status.unexpected_slave},
                                             {"with another answer than asked for", status.unexpected_answer},
                                             {"late", status.unexpected_late},
                                             {"twice", status.unexpected_duplicate},
                                             {"unasked", status.unexpected_unasked}});
  return fmt::format("{} rejected{}, {} unexpected{}", status.rejected_frames, rejected,
                     status.unexpected_frames, unexpected);
}

std::string state_text(const Status& status, unsigned) {
  return fmt::format("{} (0x{:04X}); CANsync status 0x{:04X}", status.state, status.option_status,
                     status.cansync_status);
}

std::string second_master_frame(std::uint32_t identifier) {
  return identifier == 0 ? std::string("a SYNC frame") : fmt::format("identifier 0x{:03X}", identifier);
}

std::string second_master_text(const Status& status, unsigned) {
  if (!status.second_master)
    return status.second_master_frames == 0
               ? ""
               : fmt::format("gone, {} of its frames seen", status.second_master_frames);
  return fmt::format("on the bus since {}, {}, {} of its frames seen",
                     time_text(status.second_master_since, true),
                     second_master_frame(status.second_master_identifier), status.second_master_frames);
}

std::string open_jobs_text(const Status& status, unsigned) {
  return fmt::format("{}, {}; served: {}",
                     text::counted_of(status.open_parameter_jobs, status.parameter_queue, "parameter job"),
                     text::counted_of(status.open_transfers, status.transfer_queue, "transfer"),
                     status.serving);
}

std::string reference_value_text(const Status& status, unsigned number) {
  const auto& value = status.reference_value[number];
  if (std::string_view(value.name).empty()) return "";
  return fmt::format("{}, one step is {} {}", value.name, value.factor, value.unit_symbol);
}

/// A line, or several that differ in a number.
struct Line {
  std::string_view label;
  std::string_view help;
  std::string (*text)(const Status&, unsigned number);  ///< empty: the line is left out
  std::string_view number_name = "";  ///< of several: what stands for the number in the help
  unsigned first = 0;
  unsigned count = 1;
};

constexpr Line kLines[] = {
    {"state", "operating state, with w_OPTION_STATUS and w_CANsync_STATUS", state_text},
    {"interval", "number of the present interval, and how long each is",
     [](const Status& status, unsigned) {
       return fmt::format("{}; each takes {}", status.interval,
                          text::duration_text(std::chrono::nanoseconds(status.interval_length)));
     }},
    {"second master", "somebody else sends what only a master may send; only when one was seen",
     second_master_text},
    {"slaves configured", "those of the configuration",
     [](const Status& status, unsigned) { return format_slave_set(status.slaves_configured); }},
    {"slaves responding", "those that answer",
     [](const Status& status, unsigned) {
       return share(status.slaves_responding, status.slaves_configured);
     }},
    {"slaves synchronized", "those that have locked to SYNC",
     [](const Status& status, unsigned) {
       return share(status.slaves_synchronized, status.slaves_configured);
     }},
    {"slaves released", "those that may be used with reference values",
     [](const Status& status, unsigned) { return share(status.slaves_released, status.slaves_configured); }},
    {"open jobs", "queued and running ones, how many there may be, and whose are served", open_jobs_text},
    {"telegrams sent", "since the start",
     [](const Status& status, unsigned) { return fmt::format("{}", status.telegrams_sent); }},
    {"telegrams left out", "not sent because their slot had passed",
     [](const Status& status, unsigned) { return fmt::format("{}", status.left_out); }},
    {"reference telegram",
     "whether its values are released, why not, who gives them with which strength, and who waits",
     [](const Status& status, unsigned number) { return release_text(status.reference_release[number - 1]); },
     "1, 2", 1, 2},
    {"no reference values", "active intervals in which a reference value telegram had nothing to send",
     [](const Status& status, unsigned) {
       return text::counted(status.references_not_released, "telegram");
     }},
    {"frames", "received ones that were no valid telegram, and ones nobody asked for, by kind",
     [](const Status& status, unsigned) { return frames_text(status); }},
    {"reference value", "name and scaling of each value that has a name", reference_value_text, "n", 0, 8},
};

std::string label(const Line& line, unsigned number) {
  return line.number_name.empty() ? std::string(line.label) : fmt::format("{} {}", line.label, number);
}

std::vector<Explained> lines_of(Session& session) {
  return master_lines(session.client().master_status());
}

void add_master_members(Session& session, JsonObject& object) {
  text::add_members(object, session.client().master_status(), "daemon");  // that of GatewayStatus is there
}

BusSummary master_summary(Session& session) {
  const client::MasterStatus status = session.client().master_status();
  const auto count = [](std::uint32_t mask) { return static_cast<unsigned>(std::popcount(mask)); };
  return {std::string(client::text(status.state)),
          BusSummary::Slaves{count(status.slaves_configured), count(status.slaves_responding)}};
}

std::vector<Explained> master_lines_help() {
  std::vector<Explained> entries;
  for (const Line& line : kLines) {
    const std::string number = line.number_name.empty() ? "" : fmt::format(" {}", line.number_name);
    entries.emplace_back(std::string(line.label) + number, line.help);
  }
  return entries;
}

}  // namespace

std::vector<Explained> master_lines(const client::MasterStatus& status) {
  std::vector<Explained> out;
  for (const Line& line : kLines) {
    for (unsigned number = line.first; number < line.first + line.count; ++number)
      out.emplace_back(label(line, number), line.text(status, number));
  }
  return out;
}

const StatusPart kMasterStatusPart = {"cansync-master", lines_of, add_master_members, master_lines_help,
                                      master_summary};

bool asks_slaves(const client::MasterStatus& master) {
  constexpr std::uint16_t kInSetUp = 0x0043;  // w_OPTION_STATUS
  constexpr std::uint16_t kInActiveOperation = 0x0080;
  return master.option_status == kInSetUp || master.option_status == kInActiveOperation;
}

}  // namespace cansync::cli
