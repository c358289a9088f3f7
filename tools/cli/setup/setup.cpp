#include <fmt/format.h>

#include <array>
#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>

#include "cansync/config/file.h"
#include "cansync/config/options.h"
#include "cansync/config/reload.h"
#include "cli/base/child_process.h"
#include "cli/base/files.h"
#include "cli/base/interrupt.h"
#include "cli/base/person.h"
#include "cli/base/verb_groups.h"
#include "cli/cansync/leading_programs.h"
#include "cli/setup/appliance.h"
#include "cli/setup/configuration_edit.h"
#include "cli/setup/service_steps.h"
#include "cli/setup/setup_plan.h"
#include "cli/setup/verbs.h"
#include "config/document.h"
#include "config/option.h"
#include "config/settings.h"

namespace cansync::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 4> kSyncOutputs = {"none", "gpio", "phc", "can"};
constexpr std::array<std::string_view, 2> kTargets = {"setup", "active"};
constexpr std::size_t kLargestFile = std::size_t{4} << 20;

struct SetupTexts {
  std::string source;
  std::vector<std::string> names;
  std::string sync;
  std::string target;
  std::string root = "/";
  bool replace = false;
  bool restart = false;
  bool dry_run = false;
  bool yes = false;
  bool appliance = false;
  bool undo = false;
};

/// The person has ended it; nothing was written.
struct SetupCancelled {};

std::string whole_text(const fs::path& path) {
  const auto bytes = read_file(path.string(), kLargestFile);
  return {bytes.begin(), bytes.end()};
}

/// The configuration of a folder: its only file NAME.toml.
fs::path configuration_in(const std::string& source) {
  if (fs::is_regular_file(source)) return source;
  std::vector<fs::path> found;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(source, none))
    if (entry.is_regular_file() && entry.path().extension() == ".toml") found.push_back(entry.path());
  if (found.size() == 1) return found.front();
  throw UsageError(fmt::format(
      "FOLDER: found {} configurations (NAME.toml) in '{}'; allowed: a folder of `cansync scan --write` or `cansync "
      "learn --write`, or a configuration",
      found.size(), source));
}

cansyncd::ConfigFile read_configuration(const std::string& text, const fs::path& path) {
  const config::Document document = config::parse_document(text, path.string());
  return cansyncd::build_config(config::resolve(document, cansyncd::options()), path.string());
}

/// A configuration that is to be in `path`. Throws when anything is wrong with it.
cansyncd::ConfigFile checked(const std::string& text, const fs::path& path) {
  cansyncd::ConfigFile file = read_configuration(text, path);
  if (file.problems.empty() && file.config.bus.kind == cansyncd::BusKind::simulated)
    throw UsageError(fmt::format(
        "bus.interface: found \"{}\" in {}, a simulated bus, which no service runs; allowed: the name of a CAN "
        "interface",
        file.config.bus.interface, path.string()));
  if (file.problems.empty()) return file;
  throw std::runtime_error(fmt::format("{}; `cansyncd --check {}` tells everything that is wrong",
                                       config::to_string(file.problems.front()), path.string()));
}

template <std::size_t N>
std::string one_of(const std::string& text, const std::array<std::string_view, N>& words, const char* what) {
  std::string allowed;
  for (const std::string_view word : words) {
    if (text == word) return text;
    allowed += fmt::format("{}{}", allowed.empty() ? "" : ", ", word);
  }
  throw UsageError(fmt::format("{}: found '{}'; allowed: {}", what, text, allowed));
}

/// What the person answers; `given` where Enter alone is pressed.
std::string answer_or(const std::string& question, const std::string& given) {
  const auto answer = ask_person(fmt::format("{} [{}]: ", question, given));
  if (!answer) throw SetupCancelled{};
  return answer->empty() ? given : *answer;
}

/// A choice, asked until it is one of the words.
template <std::size_t N>
std::string asked_choice(Output& output, const std::string& question, const std::string& given,
                         const std::array<std::string_view, N>& words) {
  for (;;) {
    try {
      return one_of(answer_or(question, given), words, "answer");
    } catch (const UsageError& error) {
      output.remark(error.what());
    }
  }
}

void take_names(const SetupTexts& texts, const cansyncd::Config& config, SetupAnswers& answers) {
  for (const std::string& text : texts.names) {
    const Assignment name = parse_assignment(text);
    const auto number = static_cast<unsigned>(parse_integer(name.value, "--name", 0, kSlaves - 1));
    if (!config.master.slaves[number].configured)
      throw UsageError(fmt::format("--name: slave {} is not in the configuration", number));
    answers.names[number] = name.number;
  }
}

/// Asks for what was not typed.
void ask_rest(Output& output, const cansyncd::Config& config, bool sync_given, SetupAnswers& answers) {
  for (const SlaveNumber slave : config.master.configured()) {
    const unsigned number = slave.value();
    if (answers.names.count(number) != 0) continue;
    const std::string& profile = config.slaves[number].profile;
    answers.names[number] =
        answer_or(fmt::format("Name of slave {}{}", number, profile.empty() ? "" : " (" + profile + ")"),
                  config.slaves[number].name);
  }
  if (!answers.sync_output && !sync_given)
    answers.sync_output = asked_choice(
        output,
        "Where SYNC comes out: none, gpio (a GPIO line), phc (a PTP clock), can (a frame, for simulated "
        "drives)",
        "none", kSyncOutputs);
  if (!answers.target)
    answers.target = asked_choice(
        output, "How far the daemon goes by itself: setup, or active (drives get reference values)", "setup",
        kTargets);
}

/// The files of the system: the configuration first, then profiles and network files beside it.
SetupPlan plan_of(const fs::path& configuration, std::string text, const std::string& interface,
                  const fs::path& root) {
  SetupPlan plan;
  plan.files.push_back(planned_file(root / "etc/cansync" / (interface + ".toml"), std::move(text)));
  const fs::path folder = configuration.parent_path();
  std::set<fs::path> found;
  std::error_code none;
  for (const char* part : {"profiles", "network"})
    for (const auto& entry : fs::directory_iterator(folder / part, none))
      if (entry.is_regular_file()) found.insert(entry.path());
  bool network = false;
  for (const fs::path& path : found) {
    const bool profile = path.parent_path().filename() == "profiles";
    const fs::path to = root / (profile ? "etc/cansync/profiles" : "etc/systemd/network") / path.filename();
    network = network || !profile;
    plan.files.push_back(planned_file(to, whole_text(path)));
  }
  if (network) {
    plan.commands.push_back({"systemctl", "enable", "--now", "systemd-networkd"});
    // Enabled with it, and on its own it would hold up each boot for two minutes: no CAN interface has an address.
    if (!fs::is_symlink(root / "etc/systemd/system/multi-user.target.wants/systemd-networkd.service"))
      plan.commands.push_back({"systemctl", "disable", "systemd-networkd-wait-online.service"});
    plan.commands.push_back({"networkctl", "reload"});
  }
  return plan;
}

bool service_is_active(const std::string& interface) {
  try {
    return is_active(run_child({"systemctl", "is-active", service_unit(interface)}, "").output);
  } catch (const NoProgram&) {
    return false;
  }
}

/// The programs that lead the drives of a bus, asked from its daemon; empty: none, or it does not answer.
std::string leading_on(const cansyncd::Config& running) {
  client::Options options;
  options.domain = running.dds.domain;
  options.bus = running.dds.partition;
  options.interface = running.dds.interface;
  options.security = running.dds.security;
  options.final_types = running.dds.final_types;
  options.client_name = "cansync";
  options.wait = std::chrono::seconds(1);
  options.requests = false;
  options.go_on = [] { return !interrupt_flag().load(); };
  try {
    return leading_writers(client::Client::connect(options).master_status());
  } catch (const std::exception&) {
    return "";  // the restart is asked for all the same
  }
}

/// `file`: the configuration as it is planned; `wanted`: the same, read.
ServiceFacts facts_of(const PlannedFile& file, const cansyncd::ConfigFile& wanted) {
  const std::string& interface = wanted.config.bus.interface;
  ServiceFacts facts;
  facts.active = service_is_active(interface);
  facts.file_changes = file.kind != PlannedFile::Kind::same;
  if (!facts.active || !facts.file_changes) return facts;
  facts.needs_restart = {"the file that runs is not there, or is wrong"};
  if (file.kind != PlannedFile::Kind::replace) return facts;
  const cansyncd::ConfigFile running = read_configuration(whole_text(file.path), file.path);
  if (running.problems.empty()) facts.needs_restart = cansyncd::plan_reload(running, wanted).needs_restart;
  if (!facts.needs_restart.empty()) facts.leading = leading_on(running.config);
  return facts;
}

void expect_replaceable(const SetupPlan& plan, const SetupTexts& texts) {
  const auto replaced = plan.replaced();
  if (replaced.empty() || texts.replace || texts.dry_run) return;
  std::string list;
  for (const std::string& path : replaced) list += (list.empty() ? "" : ", ") + path;
  if (texts.yes || !person_is_there())
    throw UsageError(
        fmt::format("{} is there already with other contents; nothing was written. --replace keeps it "
                    "as .before-setup and takes its place",
                    list));
  if (!person_agrees(fmt::format("{} is there already with other contents. It is kept as .before-setup, and "
                                 "replaced.",
                                 list)))
    throw SetupCancelled{};
}

/// Before anything is written: `--yes` alone stops no line.
void expect_interruptible(const std::string& interrupts, const SetupTexts& texts) {
  if (interrupts.empty() || texts.restart || texts.dry_run || !texts.yes) return;
  throw UsageError(fmt::format("{}; nothing was written. --restart restarts it", interrupts));
}

ExitCode carry_out(Output& output, SetupPlan plan, const SetupTexts& texts,
                   const cansyncd::ConfigFile& wanted) {
  const bool systemd = systemd_runs(texts.root);
  const std::string& interface = wanted.config.bus.interface;
  const std::string path = "/etc/cansync/" + interface + ".toml";
  const ServiceFacts facts = systemd ? facts_of(plan.files.front(), wanted) : ServiceFacts{};
  ServiceSteps steps = service_steps(interface, path, facts);
  plan.commands.insert(plan.commands.end(), steps.commands.begin(), steps.commands.end());
  if (texts.dry_run) {
    write_plan(output, plan, false);
    if (!steps.interrupts.empty()) output.remark(steps.interrupts);
    return ExitCode::done;
  }
  expect_replaceable(plan, texts);
  expect_interruptible(steps.interrupts, texts);
  std::vector<std::vector<std::string>> later;
  if (!systemd) later.swap(plan.commands);
  std::string question = plan_words(plan);
  if (!steps.interrupts.empty()) question += fmt::format("\n{}.", steps.interrupts);
  if (!texts.yes && !person_agrees(question)) throw SetupCancelled{};
  if (interrupt_flag().load()) throw SetupCancelled{};
  write_planned_files(plan);
  const bool ran = run_commands(output, plan);
  write_plan(output, plan, ran);
  for (const auto& command : later)
    output.remark(fmt::format("systemd does not run here; later: {}", command_text(command)));
  output.remark(fmt::format("next: cansync --bus {} doctor", wanted.config.bus.name));
  if (!systemd) return ExitCode::done;
  const bool active = service_is_active(interface);
  output.remark(in_force_text(interface, path, active, fs::exists(fs::path("/sys/class/net") / interface)));
  return ran && active ? ExitCode::done : ExitCode::failed;
}

ExitCode set_up(Session& session, const SetupTexts& texts) {
  Output& output = session.output();
  const fs::path path = configuration_in(texts.source);
  const std::string text = whole_text(path);
  const cansyncd::Config config = checked(text, path).config;
  SetupAnswers answers;
  take_names(texts, config, answers);
  if (!texts.sync.empty()) answers.sync_output = one_of(texts.sync, kSyncOutputs, "--sync");
  if (!texts.target.empty()) answers.target = one_of(texts.target, kTargets, "--start");
  const bool asks = !texts.yes && !texts.dry_run;
  if (asks && !person_is_there())
    throw UsageError(
        "nobody can be asked here: --name, --sync and --start say what is to stand, and --yes goes on");
  if (asks) ask_rest(output, config, config.sync.output != decltype(config.sync.output){}, answers);
  std::string edited = edited_configuration(text, answers);
  const cansyncd::ConfigFile wanted = checked(edited, path);
  return carry_out(output, plan_of(path, std::move(edited), config.bus.interface, texts.root), texts, wanted);
}

ExitCode setup_verb(Session& session, const SetupTexts& texts) {
  if (texts.appliance) return set_up_appliance(session, {texts.undo, texts.dry_run, texts.yes, texts.root});
  if (texts.source.empty())
    throw UsageError("FOLDER is missing: a folder of --write, or a configuration; or use --appliance");
  session.expect_input(texts.source);
  try {
    return set_up(session, texts);
  } catch (const SetupCancelled&) {
    session.output().remark("ended; nothing was written");
    return ExitCode::cancelled;
  }
}

}  // namespace

void add_setup_verb(CLI::App& app, Verb& chosen) {
  auto* setup =
      app.add_subcommand("setup", "put what `scan` or `learn` has written in place, and start the daemon");
  setup->group(kLookingVerbs);
  auto texts = std::make_shared<SetupTexts>();
  auto* folder = setup->add_option("FOLDER", texts->source, "folder of --write, or a configuration");
  setup->add_option("--name", texts->names, "name of a slave, such as 3=winder; repeatable")
      ->type_name("N=NAME");
  setup->add_option("--sync", texts->sync, "where SYNC comes out: none, gpio, phc or can")
      ->type_name("none|gpio|phc|can");
  setup->add_option("--start", texts->target, "how far the daemon goes by itself: setup or active")
      ->type_name("setup|active");
  setup
      ->add_option("--root", texts->root,
                   "write below this folder in the place of /, and start nothing (default: /)")
      ->type_name("FOLDER");
  setup->add_flag("--replace", texts->replace,
                  "a file that is there with other contents is kept as .before-setup, and replaced");
  setup->add_flag("--restart", texts->restart,
                  "with --yes: restart the service when the new configuration needs it, which stops its bus");
  setup->add_flag("--dry-run", texts->dry_run, "say what would be done, and do nothing");
  setup->add_flag("--yes", texts->yes, "ask nothing; what is not given stays as it is in the configuration");
  auto* appliance = setup->add_flag(
      "--appliance", texts->appliance,
      "prepare this computer to run a machine: no sleep, no automatic reboot, full clock rate, hardware watchdog");
  appliance->excludes(folder);
  setup->add_flag("--undo", texts->undo, "remove what --appliance has written")->needs(appliance);
  setup->footer(
      "No daemon is needed. Everything is asked before the first file is written, and each file is written in one "
      "step.\n"
      "Examples:\n"
      "  cansync scan can0 --ask --write line && sudo cansync setup line\n"
      "  cansync setup line --name 3=winder --sync gpio --dry-run\n"
      "  sudo cansync setup --appliance");
  setup->callback(
      [texts, &chosen] { chosen = [texts](Session& session) { return setup_verb(session, *texts); }; });
}

}  // namespace cansync::cli
