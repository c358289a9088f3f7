#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <stdexcept>

#include "cli/base/interrupt.h"
#include "cli/base/verb_groups.h"
#include "cli/scan/ask_line.h"
#include "cli/scan/found_report.h"
#include "cli/scan/heard_line.h"
#include "cli/scan/scan_files.h"
#include "cli/scan/verbs.h"
#include "cli/text/column_help.h"

namespace cansync::cli {
namespace {

struct ScanTexts {
  RecordingTexts recording;
  AskTexts ask;
  std::string write;
  bool try_rates = false;
};

/// Before anything is listened to or asked: nothing is written over.
void expect_new_folder(const std::string& folder) {
  std::error_code ignored;
  if (std::filesystem::exists(folder, ignored))
    throw UsageError(fmt::format(
        "--write: {} is there already, and nothing is written over; name another folder", folder));
}

constexpr const char* kNobodyAnswered =
    "no slave answered: power, cable, termination, bit rate, an interface that only listens? The manuals "
    "leave open whether a drive answers while no SYNC runs; if these do not, start cansyncd with the slaves "
    "that are expected and target = \"setup\", and look at `cansync slaves`";

/// Asks the slaves; the exit code says how that ended.
ExitCode ask_after_listening(Session& session, const ScanTexts& texts, ScannedLine& scanned) {
  const InstalledProfiles installed = installed_profiles(session);
  auto found = ask_line(scanned.heard, texts.ask, installed);
  if (!found) {
    session.output().remark("nothing was asked");
    return ExitCode::cancelled;
  }
  write_found_slaves(session.output(), *found);
  scanned.slaves = std::move(found->slaves);
  scanned.profiles = installed.elsewhere;
  if (found->stopped) {
    session.output().remark("stopped before everything was asked");
    return ExitCode::cancelled;
  }
  if (scanned.slaves.empty()) session.output().remark(kNobodyAnswered);
  return scanned.slaves.empty() ? ExitCode::timeout : ExitCode::done;
}

void write_scan(Output& output, const std::string& folder, const ScannedLine& scanned) {
  const auto files = scan_files(scanned);
  write_learned_files(folder, files);
  output.remark(fmt::format("{} {} written below {}; next: cansync setup {}", files.size(),
                            files.size() == 1 ? "file" : "files", folder, folder));
  if (scanned.heard.census.master())
    output.remark(fmt::format("a master runs: `cansync learn {} --write FOLDER` tells more than this",
                              scanned.heard.interface));
}

ExitCode scan_verb(Session& session, const ScanTexts& texts) {
  if (texts.ask.ask && texts.try_rates)
    throw UsageError(
        "--try-rates: found together with --ask; allowed: first the one, then the other at that rate");
  if (!texts.ask.ask && (texts.ask.parameters || (texts.ask.yes && !texts.try_rates)))
    throw UsageError("--parameters, --yes: found without --ask; allowed: with it");
  Output& output = session.output();
  session.expect_input(texts.recording.source);
  if (!texts.write.empty()) expect_new_folder(texts.write);
  ScannedLine scanned;
  if (texts.try_rates) {
    auto heard = hear_line_at_all_rates(output, texts.recording, texts.ask.yes);
    if (!heard) return ExitCode::cancelled;
    scanned.heard = std::move(*heard);
  } else {
    scanned.heard = hear_line(output, texts.recording);
  }
  if (interrupt_flag().load()) output.remark("stopped before the time was over");
  write_heard_line(output, scanned.heard);
  if (!scanned.heard.live && scanned.heard.census.frames == 0)
    throw std::runtime_error(fmt::format("{}: no frame at all was found", texts.recording.source));
  ExitCode code = scanned.heard.problems == 0 ? ExitCode::done : ExitCode::failed;
  if (texts.ask.ask) code = ask_after_listening(session, texts, scanned);
  if (!texts.write.empty() && code == ExitCode::done) write_scan(output, texts.write, scanned);
  return code;
}

}  // namespace

void add_scan_verb(CLI::App& app, Verb& chosen) {
  auto* scan = app.add_subcommand("scan", "what is on a line that nobody knows, without a daemon");
  scan->group(kLookingVerbs);
  auto texts = std::make_shared<ScanTexts>();
  add_recording_options(*scan, texts->recording, "3");
  scan->add_flag(
      "--ask", texts->ask.ask,
      "ask slaves 0 to 31 for status word, identity and block length, after a question; refused while a "
      "master is heard");
  scan->add_flag("--parameters", texts->ask.parameters,
                 "with --ask: read every parameter number, 0 to 4095, of each slave that answers");
  scan->add_flag("--yes", texts->ask.yes, "with --ask and --try-rates: without a question");
  scan->add_flag(
      "--try-rates", texts->try_rates,
      "set the interface to each of the four bit rates, listening only, and tell at which one frames come; "
      "afterwards it is as before");
  scan->add_option(
          "--write", texts->write,
          "write a configuration, drafts of profiles and the files for systemd-networkd into this folder, "
          "which must be new")
      ->type_name("FOLDER");
  scan->footer(
      "No daemon is needed. Without --ask nothing is sent; with it reads alone, and no SYNC. Exit code 5: no slave "
      "answered.\n"
      "Examples:\n"
      "  cansync scan can0\n"
      "  cansync scan can0 --ask --write line\n"
      "  candump -L can0 > old.log; cansync scan old.log\n" +
      columns_help(line_point_columns()) + "\n\n" + heard_tables_help() + "\n\n" + found_tables_help());
  scan->callback(
      [texts, &chosen] { chosen = [texts](Session& session) { return scan_verb(session, *texts); }; });
}

}  // namespace cansync::cli
