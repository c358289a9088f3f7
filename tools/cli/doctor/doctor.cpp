#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <span>
#include <string>
#include <system_error>
#include <utility>

#include "can/link_kernel.h"
#include "cli/base/own_process.h"
#include "cli/base/verb_groups.h"
#include "cli/cansync/fault_words.h"
#include "cli/doctor/doctor_findings.h"
#include "cli/doctor/doctor_link.h"
#include "cli/doctor/verbs.h"
#include "cli/text/column_help.h"

namespace cansync::cli {
namespace {

/// Of a reload that is taken in part both are told, in any order.
constexpr std::int64_t kOneReload = 1'000'000'000;  // ns

/// What the daemon tells; leaves `in.status` empty, with the reason, when there is none.
void ask_daemon(Session& session, DoctorInput& in) {
  try {
    client::Client& client = session.client();
    DaemonStatus status{client.gateway_status(), client.bus_status(), client.realtime_status(), std::nullopt};
    // Others have a status of their own, which the findings do not need.
    if (client::text(status.gateway.protocol) == "cansync-master") {
      status.master = client.master_status();
      status.reset_command = "cansync mode reset-can";
      status.slaves = client.slaves();
      FaultWords faults(session);
      for (const client::SlaveStatus& slave : status.slaves)
        if (std::string fault = faults.of(slave); !fault.empty())
          status.faults.emplace(slave.slave, std::move(fault));
    }
    in.status = status;
    in.participants = client.participants();
    in.incompatible = client.gateway_status().incompatible;
    std::int64_t not_taken = 0;
    for (const client::Event& event : client.recent_events()) {
      const std::string_view code = event.code;
      if (code == "dds_incompatible") in.newest_incompatible = client::text(event.text);
      if (code == "syncs_missed") in.newest_missed = time_text(event.time, true);
      if (code == "configuration_reloaded" && event.time > not_taken + kOneReload) in.reload_refused.clear();
      if (code == "reload_refused" || code == "setting_needs_restart") {
        in.reload_refused = client::text(event.text);
        not_taken = event.time;
      }
    }
  } catch (const client::SeveralDaemons& error) {
    in.several_daemons = error.what();
  } catch (const client::NoDaemon& error) {
    in.no_daemon = error.what();
  } catch (const client::SetupError& error) {
    in.no_daemon = error.what();
  }
}

/// What this computer's kernel knows of the interface.
void ask_kernel(DoctorInput& in) {
  if (in.interface_name == kSimulated) return;
  try {
    in.link = can::make_link_kernel()->read(in.interface_name);
    in.adapters = can::adapters_there();
  } catch (const std::system_error& error) {
    in.kernel_silent = error.what();
  }
}

std::vector<Table::Column> doctor_columns() {
  constexpr auto left = Table::Align::left;
  constexpr std::size_t kLongestLevel = 7;   // "warning"
  constexpr std::size_t kLongestTopic = 16;  // a line that is longer is only less pretty
  return {{"LEVEL", left, "ok; warning = works, but not as it should; error = does not work", kLongestLevel},
          {"TOPIC", left, "what was looked at", kLongestTopic},
          {"FOUND", left,
           "what is the case, with the figures; the line below says after \"fix:\" which command or setting "
           "fixes it"}};
}

Style style_of(Level level) {
  if (level == Level::error) return Style::bad;
  return level == Level::warning ? Style::warning : Style::plain;
}

void show(Output& output, const Table& table, const Finding& finding) {
  if (!output.json()) {
    const std::size_t width = output.fitting_width();
    output.line(
        output.painted(table.line({std::string(name(finding.level)), finding.topic, finding.found}, width),
                       style_of(finding.level)));
    if (!finding.remedy.empty()) output.line(table.line({"", "", "fix: " + finding.remedy}, width));
    return;
  }
  JsonObject object;
  object.add("topic", finding.topic).add("level", name(finding.level)).add("found", finding.found);
  if (finding.remedy.empty())
    object.add_null("remedy");
  else
    object.add("remedy", finding.remedy);
  output.object(object);
}

/// What the bus's protocol says of itself.
void ask_protocol(Session& session, DoctorInput& in, std::span<const ProtocolVerbs* const> protocols) {
  for (const ProtocolVerbs* one : protocols) {
    const StatusPart* part = one->status;
    if (part == nullptr || part->protocol != client::text(in.status->gateway.protocol)) continue;
    in.status->has_sync = part->has_sync;
    in.status->reset_command = part->reset_command;
    if (part->findings != nullptr) in.of_protocol = part->findings(session);
  }
}

void show_conclusion(Output& output, const std::vector<Finding>& findings, Level worst) {
  constexpr std::size_t kSetIn = 10;  // behind "do first: "
  const std::size_t width = output.fitting_width();
  output.line(output.painted(folded(summary(findings), 0, width), style_of(worst)));
  if (const Finding* first = first_to_fix(findings); first != nullptr)
    output.line("do first: " + folded(fmt::format("{}: {}", first->topic, first->remedy), kSetIn, width));
}

/// " OPTION VALUE" for an option of further commands; empty: the value is the usual one, or that of the
/// environment, which further commands have, too.
std::string option_text(const char* option, const char* variable, const std::string& value,
                        const std::string& usual) {
  const char* of_environment =
      std::getenv(variable);  // NOLINT(concurrency-mt-unsafe): nobody changes the environment
  if (value == usual || (of_environment != nullptr && value == of_environment)) return {};
  return fmt::format(" {} {}", option, value);
}

/// The options with which the bus was chosen, for further commands; empty: none is needed.
std::string options_of(const Globals& globals) {
  const Globals usual;
  const std::string options =
      option_text("--bus", "CANSYNC_BUS", globals.bus, usual.bus) +
      option_text("--domain", "CANSYNC_DOMAIN", std::to_string(globals.domain),
                  std::to_string(usual.domain)) +
      option_text("--interface", "CANSYNC_INTERFACE", globals.interface, usual.interface) +
      option_text("--security", "CANSYNC_SECURITY", globals.security, usual.security) +
      (globals.final_types ? option_text("--types", "CANSYNC_TYPES", "final", "") : std::string());
  return options.empty() ? options : options.substr(1);
}

ExitCode doctor_verb(Session& session, std::span<const ProtocolVerbs* const> protocols) {
  session.look_only();
  DoctorInput in;
  in.cli_version = CANSYNC_VERSION;
  in.data_model = gateway_DATA_MODEL;
  ask_daemon(session, in);
  // Where no daemon is, and none was named, the first CAN interface is looked at.
  in.bus = in.status                       ? std::string(client::text(in.status->gateway.bus))
           : session.globals().bus.empty() ? "can0"
                                           : session.globals().bus;
  if (in.status) ask_protocol(session, in, protocols);
  // A bus without a name of its own is named like its interface.
  const auto configured = configured_bus("/", in.bus);
  in.interface_name = in.status ? std::string(client::text(in.status->bus.bus_interface))
                      : configured && !configured->interface.empty() ? configured->interface
                                                                     : in.bus;
  // `cansync setup` names the file, and with it the unit, after the interface.
  in.unit = configured ? configured->unit : in.interface_name == kSimulated ? in.bus : in.interface_name;
  in.machine = read_machine("/", in.status ? in.status->realtime.realtime_cpu : -1);
  in.host = read_host("/");
  in.host_name = name_of_this_host();
  ask_kernel(in);
  in.places = gateway::dds::places_taken(session.globals().domain);
  const std::vector<Finding> found = with_options(diagnose(in), options_of(session.globals()));
  const std::vector<Finding> findings = session.json() ? found : grouped(found);
  const Table table(doctor_columns());
  if (!session.json()) session.output().line(table.heading());
  Level worst = Level::ok;
  for (const Finding& finding : findings) {
    show(session.output(), table, finding);
    worst = std::max(worst, finding.level);
  }
  if (!session.json()) show_conclusion(session.output(), findings, worst);
  return exit_code(findings, in.status.has_value() || !in.several_daemons.empty());
}

}  // namespace

void add_doctor_verb(CLI::App& app, Verb& chosen, std::span<const ProtocolVerbs* const> protocols) {
  auto* doctor = app.add_subcommand("doctor", "what is well and what is not, and how to mend it");
  doctor->group(kLookingVerbs);
  doctor->footer(
      "Looks at the daemon, the bus's interface, the realtime thread's rights, processors, kernel, DDS, and at what could "
      "make\nthis computer sleep, restart or slow down. Nothing is changed. Works without a daemon as far as it can.\n"
      "Exit code: 0 all ok, 1 warnings, 8 errors, 6 no daemon was found.\n" +
      columns_help(doctor_columns()));
  doctor->callback([protocols, &chosen] {
    chosen = [protocols](Session& session) { return doctor_verb(session, protocols); };
  });
}

}  // namespace cansync::cli
