#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <memory>
#include <stdexcept>

#include "can/adapter/adapters.h"
#include "cli/base/interrupt.h"
#include "cli/base/verb_groups.h"
#include "cli/learn/evidence_text.h"
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
  std::string interface_name;
  bool try_rates = false;
};

/// Before anything is listened to or asked: nothing is written over.
void expect_new_folder(const std::string& folder) {
  std::error_code ignored;
  if (std::filesystem::exists(folder, ignored))
    throw UsageError(fmt::format(
        "--write: {} is there already, and nothing is written over; name another folder", folder));
}

/// Of what is to be the new name of an interface.
void expect_interface_name(const ScanTexts& texts) {
  const std::string& name = texts.interface_name;
  if (name.empty()) return;
  if (texts.write.empty()) throw UsageError("--interface-name: found without --write; allowed: with it");
  constexpr std::size_t kMost = 15;  // the kernel's
  const bool letters = std::all_of(name.begin(), name.end(), [](char one) {
    return std::isalnum(static_cast<unsigned char>(one)) != 0 || one == '-' || one == '_';
  });
  if (name.size() <= kMost && letters && !can::is_kernel_name(name) && name != "sim") return;
  throw UsageError(fmt::format(
      "--interface-name: found '{}'; allowed: 1..{} letters, digits, '-' or '_', and no name that the kernel gives by "
      "itself, such as can0",
      name, kMost));
}

constexpr const char* kNobodyAnswered =
    "no slave answered: power, cable, termination, bit rate, an interface that only listens? The manuals "
    "leave open whether a drive answers while no SYNC runs; if these do not, start cansyncd with the slaves "
    "that are expected and target = \"setup\", and look at `cansync slaves`";

/// Asks the slaves; the exit code says how that ended.
ExitCode ask_after_listening(Session& session, const ScanTexts& texts, ScannedLine& scanned) {
  const InstalledProfiles installed = installed_profiles(session);
  const auto& evidence = scanned.heard.census.evidence;
  const observe::LineKind kind = evidence.kind();
  if (kind == observe::LineKind::j1939 || kind == observe::LineKind::canopen) {
    session.output().remark(
        "nothing is asked: questions of CANsync would be frames of another protocol there");
    return ExitCode::not_cansync;
  }
  auto found = ask_line(scanned.heard, texts.ask, installed);
  if (!found) {
    session.output().remark("nothing was asked");
    return ExitCode::cancelled;
  }
  write_found_slaves(session.output(), *found);
  scanned.slaves = std::move(found->slaves);
  scanned.profiles = installed.elsewhere;
  if (found->stopped) {
    session.output().remark(found->failure.empty() ? "stopped before everything was asked"
                                                   : found->failure + "; what was found until then is shown");
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
  if (!scanned.new_name.empty())
    output.remark(fmt::format(
        "before that, give {0} its name: ip link set {0} down && ip link set {0} name {1}; after a boot or when it is "
        "plugged in it has it from the .link file",
        scanned.heard.interface, scanned.new_name));
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
  expect_interface_name(texts);
  ScannedLine scanned;
  scanned.new_name = texts.interface_name;
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
  const auto& census = scanned.heard.census;
  const bool other = is_other_protocol(census.evidence, census.frames);
  if (other)
    output.remark(other_protocol_text(census.evidence));
  else
    remark_on_stamps(output, census.stamps);
  ExitCode code = scanned.heard.problems == 0 ? ExitCode::done : ExitCode::in_part;
  if (texts.ask.ask)
    code = ask_after_listening(session, texts, scanned);
  else if (other)
    return ExitCode::not_cansync;
  // What was found before the line failed, or before Ctrl-C, is worth minutes.
  const bool found = code == ExitCode::done || code == ExitCode::in_part || !scanned.slaves.empty();
  if (!texts.write.empty() && found) write_scan(output, texts.write, scanned);
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
  scan->add_option(
          "--interface-name", texts->interface_name,
          "with --write: name that stays with the adapter, such as can-winder, in the place of the one that "
          "the kernel gives")
      ->type_name("NAME");
  scan->footer(
      "No daemon is needed. Without --ask nothing is sent; with it reads alone, and no SYNC. Exit code 5: no slave "
      "answered; 11: a file was read in part; 12: the frames do not look like CANsync, and nothing is written.\n"
      "Examples:\n"
      "  cansync scan can0\n"
      "  cansync scan can0 --ask --write line\n"
      "  candump -L can0 > old.log; cansync scan old.log\n" +
      columns_help(line_point_columns()) + "\n\n" + heard_tables_help() + "\n\n" + found_tables_help());
  scan->callback(
      [texts, &chosen] { chosen = [texts](Session& session) { return scan_verb(session, *texts); }; });
}

}  // namespace cansync::cli
