#include "cansync/application.h"

#include <fmt/format.h>

#include <iostream>
#include <sstream>
#include <string>

#include "cansync/completion.h"
#include "cansync/verbs.h"
#include "text/completion.h"

namespace cansync::cli {
namespace {

/// The options of every verb, as they were typed.
struct GlobalTexts {
  std::string domain = "0";
  std::string timeout;
};

constexpr std::int64_t kHighestDomain = 230;
constexpr double kLongestTimeout = 3600.0;  // seconds; the daemon takes no longer monitoring time

void add_global_options(CLI::App& app, Globals& globals, GlobalTexts& texts) {
  app.add_option("--domain", texts.domain, "DDS domain of the daemon, 0..230 (default 0)")
      ->envname("CANSYNC_DOMAIN")
      ->type_name("N");
  app.add_option("--bus", globals.bus, "name of the bus, which is the DDS partition (default sim)")
      ->envname("CANSYNC_BUS")
      ->type_name("BUS");
  app.add_option("--interface", globals.interface, "network interface to look for the daemon on (default lo)")
      ->envname("CANSYNC_INTERFACE")
      ->type_name("INTERFACE");
  app.add_option("--security", globals.security,
                 "folder of this user's identity, for a daemon with DDS Security (default: without)")
      ->envname("CANSYNC_SECURITY")
      ->type_name("FOLDER");
  app.add_option("--profiles", globals.profiles,
                 "folder of drive profiles, before /etc/cansync/profiles and those of the installation")
      ->envname("CANSYNC_PROFILES")
      ->type_name("FOLDER");
  app.add_option("--timeout", texts.timeout,
                 "how long to look for the daemon (default 3, at least 1); with verbs that read or "
                 "write parameters, and with upload and download, also the monitoring time of each job "
                 "(default: the daemon's)")
      ->type_name("SECONDS");
  app.add_flag("--json", globals.json,
               "data as JSON, one object a line; docs/command-line.md lists the keys");
}

void take_global_texts(const GlobalTexts& texts, Globals& globals) {
  globals.domain = static_cast<std::uint32_t>(parse_integer(texts.domain, "--domain", 0, kHighestDomain));
  if (texts.timeout.empty()) return;
  const double seconds = parse_real(texts.timeout, "--timeout");
  if (!(seconds > 0.0 && seconds <= kLongestTimeout))
    throw UsageError(
        fmt::format("--timeout: found '{}'; allowed: over 0 and up to 3600 seconds", texts.timeout));
  globals.timeout = seconds;
}

void add_verbs(CLI::App& app, Verb& chosen) {
  add_status_verbs(app, chosen);
  add_timing_verb(app, chosen);
  add_doctor_verb(app, chosen);
  add_watch_verb(app, chosen);
  add_record_verb(app, chosen);
  add_plot_verb(app, chosen);
  add_event_verb(app, chosen);
  add_trace_verb(app, chosen);
  add_parameter_verbs(app, chosen);
  add_params_verb(app, chosen);
  add_passport_verbs(app, chosen);
  add_restore_verb(app, chosen);
  add_transfer_verbs(app, chosen);
  add_command_verbs(app, chosen);
  add_reference_verb(app, chosen);
  add_polling_verb(app, chosen);
  add_mapping_verb(app, chosen);
  for (CLI::App* verb : app.get_subcommands({})) {
    verb->group("Verbs");
    verb->footer(verb->get_footer() +
                 "\n\n`cansync --help` shows the options of every verb and the exit codes.");
  }
}

/// CLI11's help in the words of this program.
void name_help_parts(CLI::App& app) {
  app.get_formatter()->label("SUBCOMMAND", "VERB");
  app.get_formatter()->label("TEXT", "");
  app.get_formatter()->label("REQUIRED", "");
}

std::string verb_list(const CLI::App& app) {
  std::string list;
  for (const CLI::App* verb : app.get_subcommands({})) list += (list.empty() ? "" : ", ") + verb->get_name();
  return list;
}

/// Help and version are data; everything else that CLI11 reports is a usage error.
ExitCode parse_ended(const CLI::App& app, const CLI::ParseError& error, Output& output) {
  std::ostringstream text;
  std::ostringstream complaint;
  const bool asked = app.exit(error, text, complaint) == 0;
  if (asked) {
    output.bytes(text.str());
    return ExitCode::done;
  }
  output.remark(fmt::format("{}\nTry `cansync --help`, or `cansync VERB --help`.", error.what()));
  return ExitCode::usage;
}

ExitCode parse_and_run(int argc, const char* const* argv, std::FILE* data, std::FILE* remarks) {
  CLI::App app("Speaks to a running cansyncd: looks at a CANsync line and works with its slaves.", "cansync");
  app.set_version_flag("--version", "cansync " CANSYNC_VERSION);
  app.footer(exit_code_help());
  // One at most: the word after a verb may be a slave that is named like a verb. None is told below.
  app.require_subcommand(0, 1);
  app.fallthrough();  // options of every verb may also stand after the verb
  Globals globals;
  GlobalTexts texts;
  Verb verb;
  name_help_parts(app);
  add_global_options(app, globals, texts);
  add_verbs(app, verb);
  if (const auto words = text::words_to_complete(argc, argv); !words.empty()) {
    Output(data, remarks, false).bytes(text::completions(app, words, completion_lookup()));
    return ExitCode::done;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    Output output(data, remarks, false);
    return parse_ended(app, error, output);
  }
  if (!verb) throw UsageError("VERB: found nothing; allowed: " + verb_list(app));
  take_global_texts(texts, globals);
  Output output(data, remarks, globals.json);
  Session session(globals, output);
  return verb(session);
}

}  // namespace

ExitCode run(int argc, const char* const* argv, std::FILE* data, std::FILE* remarks) {
  Output output(data, remarks, false);
  try {
    return parse_and_run(argc, argv, data, remarks);
  } catch (const UsageError& error) {
    output.remark(error.what());
    return ExitCode::usage;
  } catch (const Interrupted& error) {
    output.remark(error.what());
    return ExitCode::cancelled;
  } catch (const client::NoDaemon& error) {
    output.remark(error.what());
    return ExitCode::not_reachable;
  } catch (const client::SetupError& error) {
    output.remark(error.what());
    return ExitCode::not_reachable;
  } catch (const std::exception& error) {
    output.remark(error.what());
    return ExitCode::failed;
  }
}

}  // namespace cansync::cli
