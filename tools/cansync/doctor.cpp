#include <fmt/format.h>

#include <memory>
#include <system_error>

#include "can/link_kernel.h"
#include "cansync/doctor_findings.h"
#include "cansync/doctor_link.h"
#include "cansync/verbs.h"
#include "dds/entity.h"

namespace cansync::cli {
namespace {

/// What the daemon tells; leaves `in.status` empty, with the reason, when there is none.
void ask_daemon(Session& session, DoctorInput& in) {
  try {
    client::Client& client = session.client();
    in.status = client.master_status();
    in.participants = client.participants();
  } catch (const client::NoDaemon& error) {
    in.no_daemon = error.what();
  } catch (const dds::SetupError& error) {
    in.no_daemon = error.what();
  }
}

/// What this computer's kernel knows of the interface.
void ask_kernel(DoctorInput& in) {
  if (in.interface_name == kSimulated) return;
  try {
    in.link = can::make_link_kernel()->read(in.interface_name);
  } catch (const std::system_error& error) {
    in.kernel_silent = error.what();
  }
}

void show(Output& output, const Finding& finding) {
  if (!output.json()) {
    output.line(fmt::format("{:<8} {:<16} {}", name(finding.level), finding.topic, finding.found));
    if (!finding.remedy.empty()) output.line(fmt::format("{:<25} mend: {}", "", finding.remedy));
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

ExitCode doctor_verb(Session& session) {
  DoctorInput in;
  in.bus = session.bus();
  in.cli_version = CANSYNC_VERSION;
  in.data_model = cansync_DATA_MODEL;
  ask_daemon(session, in);
  // A bus without a name of its own is named like its interface.
  in.interface_name = in.status ? std::string(in.status->bus_interface) : in.bus;
  in.machine = read_machine("/", in.status ? in.status->realtime_cpu : -1);
  ask_kernel(in);
  const std::vector<Finding> findings = diagnose(in);
  for (const Finding& finding : findings) show(session.output(), finding);
  return exit_code(findings, in.status.has_value());
}

}  // namespace

void add_doctor_verb(CLI::App& app, Verb& chosen) {
  auto* doctor = app.add_subcommand("doctor", "what is well and what is not, and how to mend it");
  doctor->footer(
      "Looks at the daemon, the bus's interface, the realtime thread's rights, processors, kernel and DDS. "
      "Lines are\n"
      "ok, warning or error, each with the command or setting that mends it. Nothing is changed. Works "
      "without a\n"
      "daemon as far as it can. Exit code: 0 all ok, 1 warnings, 8 errors, 6 no daemon was found.");
  doctor->callback([&chosen] { chosen = doctor_verb; });
}

}  // namespace cansync::cli
