#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>

#include "cli/base/verb_groups.h"
#include "cli/look/verbs.h"
#include "gateway_members.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

/// What every bus has.
struct CommonStatus {
  client::GatewayStatus gateway;
  client::BusStatus bus;
  client::RealtimeStatus realtime;
  bool brief = false;  ///< counts of 0 are left out
  bool has_sync = true;
};

/// A count with its words, such as "in the kernel".
struct CountedWords {
  std::uint64_t count;
  std::string_view words;
};

/// "3 in the kernel, 0 in the controller"; `brief`: those that are not 0 alone.
std::string list_counts(std::initializer_list<CountedWords> counts, bool brief, bool words_first = false) {
  std::string list;
  for (const auto& [count, words] : counts) {
    if (brief && count == 0) continue;
    if (!list.empty()) list += ", ";
    list += words_first ? fmt::format("{} {}", words, count) : fmt::format("{} {}", count, words);
  }
  return list;
}

std::string daemon_text(const CommonStatus& status) {
  const client::GatewayStatus& gateway = status.gateway;
  return fmt::format("{}, cansyncd {} (process {} on {})", gateway.bus, gateway.version, gateway.process,
                     gateway.host);
}

std::string configuration_text(const CommonStatus& status) {
  return std::string(client::text(status.gateway.configuration_reason));
}

std::string network_text(const CommonStatus& status) {
  return std::string(client::text(status.gateway.network_reason));
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
    if (line.sync_output_failures > 0)
      text += fmt::format(", {} failed", text::counted(line.sync_output_failures, "edge"));
  }
  if (std::string_view(line.sync_state).empty()) return text;
  constexpr double kMicrosecond = 1e3;
  constexpr double kMillisecond = 1e6;
  text +=
      fmt::format("{}follows {}: {}, {:.1f} us off, {} used, {} rejected", text.empty() ? "" : "; ",
                  line.sync_input, line.sync_state, static_cast<double>(line.sync_phase_error) / kMicrosecond,
                  text::counted(line.sync_edges, "edge"), line.sync_rejected_edges);
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
  const std::string_view adapter = bus.adapter;
  if (std::string_view(bus.link_state) == "wrong-adapter")
    text += fmt::format(", adapter {} instead of {}", adapter.empty() ? "-" : adapter, bus.adapter_wanted);
  else if (!adapter.empty() && !status.brief)
    text += fmt::format(", adapter {}", adapter);
  return text + fmt::format("; times by: {}", bus.timestamp_source);
}

std::string bus_faults_text(const CommonStatus& status) {
  const client::BusStatus& bus = status.bus;
  std::string seen = list_counts({{bus.error_frames, bus.error_frames == 1 ? "error frame" : "error frames"},
                                  {bus.acknowledge_errors, "not acknowledged"},
                                  {bus.restarts, bus.restarts == 1 ? "restart" : "restarts"},
                                  {bus.queue_full, "times no room in the send queue"}},
                                 status.brief);
  const std::string lost =
      list_counts({{bus.overruns, "in the controller"}, {bus.dropped_frames, "in the kernel"}}, status.brief);
  if (seen.empty() && lost.empty()) return "none";
  if (lost.empty()) return seen;
  return fmt::format("{}{}lost: {}", seen, seen.empty() ? "" : "; ", lost);
}

std::string clients_text(const CommonStatus& status) {
  const client::GatewayStatus& gateway = status.gateway;
  const std::string rejected = list_counts({{gateway.rejected_values, "value"},
                                            {gateway.rejected_full, "limit"},
                                            {gateway.rejected_stale, "age"},
                                            {gateway.rejected_numbers, "number"},
                                            {gateway.rejected_identities, "identity"},
                                            {gateway.rejected_malformed, "form"},
                                            {gateway.rejected_other_daemon, "daemon"},
                                            {gateway.rejected_state, "state or right"}},
                                           status.brief, true);
  return fmt::format("{}; requests rejected{}{}", gateway.clients, rejected.empty() ? ": none" : " by ",
                     rejected);
}

std::string restart_text(const CommonStatus& status) {
  return std::string(client::text(status.gateway.restart_reason));
}

std::string missed_text(const CommonStatus& status) {
  std::string reports = text::counted(status.realtime.lost_reports, "report");
  if (!status.has_sync) return reports;
  return fmt::format("{}, {}", text::counted(status.realtime.missed_syncs, "SYNC edge"), reports);
}

struct CommonLine {
  std::string_view label;
  std::string_view help;
  std::string (*text)(const CommonStatus&);  ///< empty: the line is left out
};

constexpr CommonLine kFirst = {"bus", "its name, and the daemon that serves it", daemon_text};

constexpr CommonLine kCommonLines[] = {
    {"configuration", "why another one than the file on disk runs; only when it does", configuration_text},
    {"restart",
     "what was replaced on disk since the start of the daemon and takes effect with a restart; only then",
     restart_text},
    {"network", "why DDS is not on the interface of the configuration; only when it is not", network_text},
    {"bit rate", "of the bus, as configured", bit_rate_text},
    {"controller", "state and error counters of the CAN controller", controller_text},
    {"access", "whether requests that change something are taken, and whether DDS Security is on",
     access_text},
    {"SYNC line",
     "where SYNC is put out, and what it follows with how much error; only with an output or input",
     sync_text},
    {"interface", "state and settings of the CAN interface, and where the times of frames come from",
     interface_text},
    {"bus faults", "since the start; what is lost cost frames, a full send queue only those of CANsync",
     bus_faults_text},
    {"clients",
     "programs that have asked for something (a mere look, such as this one, is not counted), and how many "
     "of their requests were rejected, by reason",
     clients_text},
    {"missed", "SYNC edges skipped, on a bus that has them, and reports of the realtime thread without room",
     missed_text},
};

void write_line(Output& output, std::string_view label, std::string_view text) {
  constexpr std::size_t kLabelWidth = 22;
  if (!text.empty())
    output.line(
        fmt::format("{:<{}}{}", label, kLabelWidth, folded(text, kLabelWidth, output.fitting_width())));
}

ExitCode status_verb(Session& session, std::span<const ProtocolVerbs* const> protocols) {
  session.look_only();
  client::Client& client = session.client();
  CommonStatus status{client.gateway_status(), client.bus_status(), client.realtime_status(),
                      session.output().fitting_width() != 0, true};
  const auto part = std::find_if(protocols.begin(), protocols.end(), [&status](const ProtocolVerbs* one) {
    return one->status != nullptr && one->status->protocol == client::text(status.gateway.protocol);
  });
  if (part != protocols.end()) status.has_sync = (*part)->status->has_sync;
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
  status->group(kLookingVerbs);
  status->footer(lines_help(protocols));
  status->callback([protocols, &chosen] {
    chosen = [protocols](Session& session) { return status_verb(session, protocols); };
  });
}

}  // namespace cansync::cli
