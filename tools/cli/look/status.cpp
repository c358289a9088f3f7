#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string>
#include <string_view>

#include "cli/look/verbs.h"
#include "gateway_members.h"

namespace cansync::cli {
namespace {

/// What every bus has.
struct CommonStatus {
  client::GatewayStatus gateway;
  client::BusStatus bus;
  client::RealtimeStatus realtime;
};

std::string daemon_text(const CommonStatus& status) {
  const client::GatewayStatus& gateway = status.gateway;
  return fmt::format("{}, cansyncd {} (process {} on {})", gateway.bus, gateway.version, gateway.process,
                     gateway.host);
}

std::string bit_rate_text(const CommonStatus& status) {
  return fmt::format("{} bit/s", status.bus.bit_rate);
}

std::string controller_text(const CommonStatus& status) {
  return fmt::format("{}; errors: {} transmit, {} receive", status.bus.controller_state,
                     status.bus.transmit_errors, status.bus.receive_errors);
}

std::string access_text(const CommonStatus& status) {
  return fmt::format("{}, DDS Security {}", status.gateway.read_only ? "read-only" : "requests are taken",
                     status.gateway.secured ? "on" : "off");
}

/// "output gpio; follows pps: locked, 0.3 us off, 120 edges used, 1 rejected"; empty without a SYNC line.
std::string sync_text(const CommonStatus& status) {
  const client::RealtimeStatus& line = status.realtime;
  std::string text;
  if (std::string_view(line.sync_output) != "none" && !std::string_view(line.sync_output).empty()) {
    text = fmt::format("output {}", line.sync_output);
    if (line.sync_output_failures > 0) text += fmt::format(", {} edges failed", line.sync_output_failures);
  }
  if (std::string_view(line.sync_state).empty()) return text;
  constexpr double kMicrosecond = 1e3;
  constexpr double kMillisecond = 1e6;
  text +=
      fmt::format("{}follows {}: {}, {:.1f} us off, {} edges used, {} rejected", text.empty() ? "" : "; ",
                  line.sync_input, line.sync_state, static_cast<double>(line.sync_phase_error) / kMicrosecond,
                  line.sync_edges, line.sync_rejected_edges);
  if (line.sync_holdover > 0)
    text += fmt::format(", none for {:.0f} ms", static_cast<double>(line.sync_holdover) / kMillisecond);
  return text;
}

/// "can0 is up, 500000 bit/s, sample point 0.600, restart-ms 100, txqueuelen 10; times by the kernel".
std::string interface_text(const CommonStatus& status) {
  const client::BusStatus& bus = status.bus;
  std::string text = fmt::format("{} is {}", bus.bus_interface, bus.link_state);
  if (bus.interface_bit_rate != 0) text += fmt::format(", {} bit/s", bus.interface_bit_rate);
  if (bus.sample_point != 0) text += fmt::format(", sample point 0.{:03}", bus.sample_point);
  if (bus.restart_time >= 0) text += fmt::format(", restart-ms {}", bus.restart_time);
  if (bus.queue_length != 0) text += fmt::format(", txqueuelen {}", bus.queue_length);
  return text + fmt::format("; times by: {}", bus.timestamp_source);
}

std::string bus_faults_text(const CommonStatus& status) {
  const client::BusStatus& bus = status.bus;
  return fmt::format(
      "{} error frames, {} not acknowledged, {} restarts; lost: {} for a full send queue, {} in the "
      "controller, {} in the kernel",
      bus.error_frames, bus.acknowledge_errors, bus.restarts, bus.queue_full, bus.overruns,
      bus.dropped_frames);
}

std::string clients_text(const CommonStatus& status) {
  const client::GatewayStatus& gateway = status.gateway;
  return fmt::format(
      "{}; requests rejected: {} values, {} limits, {} stale, {} numbers, {} identities, {} malformed, {} for "
      "another daemon, {} by state or right",
      gateway.clients, gateway.rejected_values, gateway.rejected_full, gateway.rejected_stale,
      gateway.rejected_numbers, gateway.rejected_identities, gateway.rejected_malformed,
      gateway.rejected_other_daemon, gateway.rejected_state);
}

std::string missed_text(const CommonStatus& status) {
  return fmt::format("{} SYNC edges, {} reports", status.realtime.missed_syncs, status.realtime.lost_reports);
}

struct CommonLine {
  std::string_view label;
  std::string_view help;
  std::string (*text)(const CommonStatus&);  ///< empty: the line is left out
};

constexpr CommonLine kFirst = {"bus", "its name, and the daemon that serves it", daemon_text};

constexpr CommonLine kCommonLines[] = {
    {"bit rate", "of the bus, as configured", bit_rate_text},
    {"controller", "state and error counters of the CAN controller", controller_text},
    {"access", "whether requests that change something are taken, and whether DDS Security is on",
     access_text},
    {"SYNC line",
     "where SYNC is put out, and what it follows with how much error; only with an output or input",
     sync_text},
    {"interface", "state and settings of the CAN interface, and where the times of frames come from",
     interface_text},
    {"bus faults", "since the start; a full send queue and what is lost cost frames", bus_faults_text},
    {"clients", "programs that use the daemon, and how many of their requests were rejected, by reason",
     clients_text},
    {"missed", "SYNC edges skipped, and reports of the realtime thread without room", missed_text},
};

void write_line(Output& output, std::string_view label, std::string_view text) {
  if (!text.empty()) output.line(fmt::format("{:<22}{}", label, text));
}

ExitCode status_verb(Session& session, std::span<const ProtocolVerbs* const> protocols) {
  session.look_only();
  client::Client& client = session.client();
  const CommonStatus status{client.gateway_status(), client.bus_status(), client.realtime_status()};
  const auto part = std::find_if(protocols.begin(), protocols.end(), [&status](const ProtocolVerbs* one) {
    return one->status != nullptr && one->status->protocol == client::text(status.gateway.protocol);
  });
  if (session.json()) {
    JsonObject object;
    text::add_members(object, status.gateway);
    text::add_members(object, status.bus);
    text::add_members(object, status.realtime);
    if (part != protocols.end()) (*part)->status->members(session, object);
    session.output().object(object);
    return ExitCode::done;
  }
  Output& output = session.output();
  write_line(output, kFirst.label, kFirst.text(status));
  if (part != protocols.end())
    for (const auto& [label, text] : (*part)->status->lines(session)) write_line(output, label, text);
  for (const CommonLine& line : kCommonLines) write_line(output, line.label, line.text(status));
  return ExitCode::done;
}

std::string lines_help(std::span<const ProtocolVerbs* const> protocols) {
  std::vector<Explained> entries{{std::string(kFirst.label), std::string(kFirst.help)}};
  for (const CommonLine& line : kCommonLines) entries.emplace_back(line.label, line.help);
  for (const ProtocolVerbs* protocol : protocols) {
    if (protocol->status == nullptr) continue;
    for (const auto& [label, help] : protocol->status->help())
      entries.emplace_back(label, fmt::format("{}: {}", protocol->status->protocol, help));
  }
  return "Those that begin with the name of a protocol (bus.protocol) are of its buses alone.\n" +
         explanation("Lines", entries);
}

}  // namespace

void add_status_verb(CLI::App& app, Verb& chosen, std::span<const ProtocolVerbs* const> protocols) {
  auto* status = app.add_subcommand("status", "the daemon and its bus: operating state, interface, counters");
  status->footer(lines_help(protocols));
  status->callback([protocols, &chosen] {
    chosen = [protocols](Session& session) { return status_verb(session, protocols); };
  });
}

}  // namespace cansync::cli
