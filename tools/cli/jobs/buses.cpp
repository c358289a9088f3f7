#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <span>

#include "cli/base/verb_groups.h"
#include "cli/connect/bus_connection.h"
#include "cli/jobs/verbs.h"
#include "cli/text/column_help.h"
#include "dds/bounded_text.h"
#include "dds/overview/every_bus.h"

namespace cansync::cli {
namespace {

using gateway::dds::text;

/// Each daemon tells its status once a second.
constexpr std::chrono::milliseconds kShortestLook{1200};

std::vector<Table::Column> bus_columns() {
  constexpr auto left = Table::Align::left;
  return {{"BUS", left, "its name, for `--bus`"},
          {"PROTOCOL", left, "what its daemon speaks: bus.protocol"},
          {"STATE", left, "operating state; - = its protocol has none, or it did not tell in time"},
          {"SLAVES", left, "that respond, of those configured"},
          {"HOST", left, "the computer its daemon runs on"},
          {"PROCESS", Table::Align::right, "number of the daemon's process there"},
          {"VERSION", left, "of the daemon"}};
}

/// State and slaves of one bus, as its protocol tells them; empty where it tells none.
BusSummary summary_of(Session& session, const gateway_GatewayStatus& status,
                      std::span<const ProtocolVerbs* const> protocols) {
  const auto part = std::find_if(protocols.begin(), protocols.end(), [&status](const ProtocolVerbs* one) {
    return one->status != nullptr && one->status->protocol == text(status.protocol);
  });
  if (part == protocols.end() || (*part)->status->summary == nullptr) return {};
  Globals globals = session.globals();
  globals.bus = text(status.bus);
  Connection connection;
  Session one(globals, session.output(), connection);
  one.look_only();
  try {
    return (*part)->status->summary(one);
  } catch (const client::NoDaemon&) {
    return {};
  }
}

JsonObject bus_object(const gateway_GatewayStatus& status, const BusSummary& summary) {
  JsonObject object;
  object.add("bus", text(status.bus)).add("protocol", text(status.protocol));
  if (summary.state.empty())
    object.add_null("state");
  else
    object.add("state", summary.state);
  if (summary.slaves)
    object.add("slaves_configured", summary.slaves->configured)
        .add("slaves_responding", summary.slaves->responding);
  else
    object.add_null("slaves_configured").add_null("slaves_responding");
  object.add("host", text(status.host))
      .add("process", status.process)
      .add("version", text(status.version))
      .add("data_model", status.data_model);
  return object;
}

ExitCode buses_verb(Session& session, std::span<const ProtocolVerbs* const> protocols) {
  auto options = domain_options(session);
  options.wait = session.globals().timeout ? session.search_time() : kShortestLook;
  std::vector<gateway_GatewayStatus> found;
  try {
    found = gateway::dds::daemons_of_every_bus(options);
  } catch (const gateway::dds::SetupError& error) {
    throw client::SetupError(error.what());
  }
  if (interrupt_flag().load()) throw Interrupted();
  Table table(bus_columns());
  for (const gateway_GatewayStatus& status : found) {
    const BusSummary summary = summary_of(session, status, protocols);
    if (session.json()) {
      session.output().object(bus_object(status, summary));
      continue;
    }
    const std::string slaves =
        summary.slaves ? fmt::format("{} of {}", summary.slaves->responding, summary.slaves->configured)
                       : "-";
    table.add({std::string(text(status.bus)), std::string(text(status.protocol)),
               summary.state.empty() ? "-" : summary.state, slaves, std::string(text(status.host)),
               fmt::to_string(status.process), std::string(text(status.version))});
  }
  if (found.empty()) {
    throw client::NoDaemon(fmt::format(
        "no daemon found in DDS domain {} on interface {}; is one running? --domain and --interface "
        "say where to look",
        options.domain, options.interface));
  }
  if (!session.json()) session.output().table(table);
  return ExitCode::done;
}

}  // namespace

void add_buses_verb(CLI::App& app, Verb& chosen, std::span<const ProtocolVerbs* const> protocols) {
  auto* buses = app.add_subcommand("buses", "the daemons of all buses in the domain");
  buses->group(kLookingVerbs);
  buses->footer(
      "Looks for 1.2 s, or for --timeout, in the domain and on the interface that are named, whatever --bus "
      "says.\n" +
      columns_help(bus_columns()));
  buses->callback([&chosen, protocols] {
    chosen = [protocols](Session& session) { return buses_verb(session, protocols); };
  });
}

}  // namespace cansync::cli
