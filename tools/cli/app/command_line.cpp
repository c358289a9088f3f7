#include "cli/app/command_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <sstream>

#include "cli/app/batch.h"
#include "cli/app/completion.h"
#include "cli/app/protocols.h"
#include "cli/doctor/verbs.h"
#include "cli/jobs/verbs.h"
#include "cli/learn/verbs.h"
#include "cli/look/verbs.h"
#include "cli/record/verbs.h"
#include "cli/scan/verbs.h"
#include "cli/setup/verbs.h"
#include "cli/text/words.h"
#include "cli/trace/verbs.h"
#include "cli/watch/verbs.h"
#include "text/build_info.h"
#include "text/completion.h"

namespace cansync::cli {
namespace {

/// The options of every verb, as they were typed.
struct GlobalTexts {
  std::string domain;
  std::string timeout;
  std::string retry;
  std::string types;
  std::string colours;
};

constexpr std::int64_t kHighestDomain = 230;
constexpr double kLongestTimeout = 3600.0;  // seconds; the daemon takes no longer monitoring time
constexpr double kLongestRetry = 86400.0;   // seconds

/// Where a command line stands.
enum class Place : std::uint8_t { shell, batch };

/// Options that say where the daemon is: a batch has them for all of its lines.
constexpr std::array<const char*, 6> kOptionsOfPlace = {"--domain",   "--bus",   "--interface",
                                                        "--security", "--types", "--profiles"};

void add_place_options(CLI::App& app, Globals& globals, GlobalTexts& texts) {
  app.add_option("--domain", texts.domain, "DDS domain of the daemon, 0..230 (default 0)")
      ->envname("CANSYNC_DOMAIN")
      ->type_name("N");
  app.add_option(
         "--bus", globals.bus,
         "name of the bus, which is the DDS partition; HOST/BUS: that of this computer alone (default: the only "
         "bus in the domain)")
      ->envname("CANSYNC_BUS")
      ->type_name("BUS");
  app.add_option("--interface", globals.interface, "network interface to look for the daemon on (default lo)")
      ->envname("CANSYNC_INTERFACE")
      ->type_name("INTERFACE");
  app.add_option("--security", globals.security,
                 "folder of this user's identity, for a daemon with DDS Security (default: without)")
      ->envname("CANSYNC_SECURITY")
      ->type_name("FOLDER");
  app.add_option("--types", texts.types,
                 "appendable or final, as the daemon's option dds.types (default appendable)")
      ->envname("CANSYNC_TYPES")
      ->type_name("TYPES");
  app.add_option("--profiles", globals.profiles,
                 "folder of drive profiles, before /etc/cansync/profiles and those of the installation")
      ->envname("CANSYNC_PROFILES")
      ->type_name("FOLDER");
}

void add_global_options(CLI::App& app, Globals& globals, GlobalTexts& texts) {
  add_place_options(app, globals, texts);
  app.add_option(
         "--timeout", texts.timeout,
         "how long to look for the daemon (default 3; less than 1 is taken as 1); with verbs that read or write "
         "parameters, with upload, download, control and broadcast, also the monitoring time of each "
         "job (default: the daemon's); with wait: how long to wait in all")
      ->type_name("SECONDS");
  app.add_option(
         "--retry", texts.retry,
         "try again for so long what surely did nothing: no daemon is there yet, or it refuses because of "
         "what passes; what only reads also when no answer came (default: never)")
      ->type_name("SECONDS");
  app.add_option(
         "--color", texts.colours,
         "colours in data for people: on a terminal unless NO_COLOR is set (auto, the default), always, or "
         "never")
      ->type_name("auto|always|never");
  app.add_flag("--wide", globals.wide,
               "all columns and figures, however wide, on a terminal too; elsewhere it is always so");
  app.add_flag("--json", globals.json,
               "data as JSON, one object a line; docs/command-line-json.md lists the keys");
}

double parse_seconds(const std::string& text, const char* option, double longest) {
  const double seconds = parse_real(text, option);
  if (seconds > 0.0 && seconds <= longest) return seconds;
  throw UsageError(
      fmt::format("{}: found '{}'; allowed: over 0 and up to {:g} seconds", option, text, longest));
}

bool parse_types(const std::string& text) {
  if (text == "final") return true;
  if (text == "appendable") return false;
  throw UsageError(
      fmt::format("--types: found '{}'; allowed: appendable or final, as the daemon's dds.types", text));
}

ColourUse parse_colours(const std::string& text) {
  if (text == "auto") return ColourUse::automatic;
  if (text == "always") return ColourUse::always;
  if (text == "never") return ColourUse::never;
  throw UsageError(fmt::format("--color: found '{}'; allowed: auto, always, never", text));
}

/// As the daemon's bus.name or empty, after a host name and `/` at the most, so that what is meant for a shell or a unit cannot
/// stand in it.
void expect_bus(std::string_view bus) {
  constexpr std::size_t kLongest = 63;
  const auto fits = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '.' || c == '-'; };
  const auto is_name = [&](std::string_view name) {
    return name.size() <= kLongest && std::all_of(name.begin(), name.end(), fits);
  };
  const auto cut = bus.find('/');
  const bool right = cut == std::string_view::npos ? is_name(bus)
                                                   : cut > 0 && is_name(bus.substr(0, cut)) &&
                                                         cut + 1 < bus.size() && is_name(bus.substr(cut + 1));
  if (right) return;
  throw UsageError(fmt::format(
      "--bus: found '{}'; allowed: 1..{} letters, digits, '_', '.' or '-', or HOST/BUS of such names", bus,
      kLongest));
}

void take_global_texts(const GlobalTexts& texts, Globals& globals) {
  if (!texts.domain.empty())
    globals.domain = static_cast<std::uint32_t>(parse_integer(texts.domain, "--domain", 0, kHighestDomain));
  expect_bus(globals.bus);
  if (!texts.types.empty()) globals.final_types = parse_types(texts.types);
  if (!texts.colours.empty()) globals.colours = parse_colours(texts.colours);
  if (!texts.timeout.empty()) globals.timeout = parse_seconds(texts.timeout, "--timeout", kLongestTimeout);
  if (!texts.retry.empty()) globals.retry = parse_seconds(texts.retry, "--retry", kLongestRetry);
}

/// What every verb has in its help, also those of two words (`second`), which stand in no group.
void finish_verbs(CLI::App& app, bool second) {
  for (CLI::App* verb : app.get_subcommands({})) {
    if (second) verb->group("Verbs");
    verb->footer(verb->get_footer() +
                 "\n\n`cansync --help` shows the options of every verb and the exit codes.");
    finish_verbs(*verb, true);
  }
}

void add_verbs(CLI::App& app, Verb& chosen) {
  add_status_verb(app, chosen, protocols());
  add_buses_verb(app, chosen, protocols());
  add_doctor_verb(app, chosen, protocols());
  for (const ProtocolVerbs* protocol : protocols()) protocol->add(app, chosen);
  for (const AddVerbs add :
       {add_job_verbs, add_watch_verb, add_record_verb, add_plot_verb, add_event_verb, add_trace_verb,
        add_scan_verb, add_learn_verb, add_setup_verb, add_wait_verb, add_batch_verb}) {
    add(app, chosen);
  }
  finish_verbs(app, false);
}

/// The build, and what it understands.
std::string version_text() {
  std::string names;
  for (const ProtocolVerbs* protocol : protocols())
    if (protocol->status != nullptr)
      names += (names.empty() ? "" : ", ") + std::string(protocol->status->protocol);
  return fmt::format("cansync {}\ndata model {}; protocols: {}", text::build_text(), gateway_DATA_MODEL,
                     names);
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

std::vector<std::string> verb_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* verb : app.get_subcommands({})) names.push_back(verb->get_name());
  return names;
}

/// The verb that was typed, the last word of it; null: none.
const CLI::App* typed_verb(const CLI::App& app) {
  const CLI::App* verb = nullptr;
  for (auto verbs = app.get_subcommands(); !verbs.empty(); verbs = verb->get_subcommands())
    verb = verbs.front();
  return verb;
}

/// Its words, such as "can dump".
std::string name_of(const CLI::App& verb, const CLI::App& app) {
  const CLI::App* parent = verb.get_parent();
  return (parent == nullptr || parent == &app ? "" : name_of(*parent, app) + " ") + verb.get_name();
}

/// Long options of every verb, and of `verb`.
std::vector<std::string> option_names(const CLI::App& app, const CLI::App* verb) {
  std::vector<std::string> names;
  for (const CLI::App* from : {&app, verb}) {
    if (from == nullptr) continue;
    for (const CLI::Option* option : from->get_options())
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

/// The verb that was called like this before; null: none was.
const FormerVerb* former_verb(std::string_view word) {
  for (const ProtocolVerbs* protocol : protocols())
    for (const FormerVerb& former : protocol->former)
      if (former.was == word) return &former;
  return nullptr;
}

/// `help`, `help VERB` and `version` in the words of options, as people type them; all others as they are.
std::vector<std::string> as_options(const CLI::App& app, std::vector<std::string> words) {
  if (words.empty()) return words;
  if (words.front() == "help") {
    words.erase(words.begin());
    const auto verbs = verb_names(app);
    // A word that is no verb is left alone, so that it is said.
    if (words.empty() || former_verb(words.front()) != nullptr ||
        std::find(verbs.begin(), verbs.end(), words.front()) != verbs.end())
      words.emplace_back("--help");
  } else if (words.size() == 1 && (words.front() == "version" || words.front() == "-V")) {
    words.front() = "--version";
  }
  return words;
}

/// Where the verb is among the words: the first that is no option, and no value of one.
std::size_t place_of_verb(const CLI::App& app, const std::vector<std::string>& words) {
  std::size_t at = 0;
  while (at < words.size() && words[at].starts_with('-')) {
    const CLI::Option* option = app.get_option_no_throw(words[at]);
    at += option != nullptr && option->get_items_expected_max() > 0 ? 2 : 1;
  }
  return at;
}

/// The program's description of its command line, and where what was typed goes to. Stays where it is.
class CommandLine {
 public:
  CommandLine(const Globals& globals, Place place)
      : app_("Speaks to a running cansyncd: looks at a CANsync line and works with its slaves.", "cansync"),
        place_(place) {
    command_.globals = globals;
    app_.set_version_flag("--version", version_text());
    app_.footer(exit_code_help());
    // One at most: the word after a verb may be a slave that is named like a verb. None is told below.
    app_.require_subcommand(0, 1);
    app_.fallthrough();  // options of every verb may also stand after the verb
    name_help_parts(app_);
    add_global_options(app_, command_.globals, texts_);
    if (place == Place::batch)
      for (const char* option : kOptionsOfPlace) app_.get_option(option)->envname("");
    add_verbs(app_, command_.verb);
  }

  const CLI::App& app() const noexcept { return app_; }

  Command parse(std::vector<std::string> words) {
    const FormerVerb* former = nullptr;
    if (const std::size_t at = place_of_verb(app_, words); at < words.size()) former = former_verb(words[at]);
    if (former != nullptr) put_present_name(*former, words);
    std::vector<const char*> arguments{"cansync"};
    for (const std::string& word : words) arguments.push_back(word.c_str());
    try {
      app_.parse(static_cast<int>(arguments.size()), arguments.data());
    } catch (const CLI::ExtrasError&) {
      refuse_extra_words();
    } catch (const CLI::ParseError& error) {
      return parse_ended(error);
    }
    if (!command_.verb) {
      throw UsageError(fmt::format(
          "VERB: found nothing; allowed: {}\nTry `cansync help`, or `cansync help VERB`.", verb_list(app_)));
    }
    if (place_ == Place::batch) refuse_place_options();
    take_global_texts(texts_, command_.globals);
    command_.name = name_of(*typed_verb(app_), app_);
    command_.globals.verb = command_.name;
    if (former != nullptr) say_present_name(*former);
    return command_;
  }

 private:
  void put_present_name(const FormerVerb& former, std::vector<std::string>& words) const {
    const auto verb = words.begin() + static_cast<std::ptrdiff_t>(place_of_verb(app_, words));
    *verb = former.protocol;
    words.insert(verb + 1, std::string(former.verb));
  }

  void say_present_name(const FormerVerb& former) {
    command_.verb = [verb = command_.verb, &former](Session& session) {
      session.output().remark(
          fmt::format("`{}` is now `cansync {} {}`", former.was, former.protocol, former.verb));
      return verb(session);
    };
  }

  /// Help and version are data; everything else that CLI11 reports is a usage error.
  Command parse_ended(const CLI::ParseError& error) const {
    std::ostringstream text;
    std::ostringstream complaint;
    if (app_.exit(error, text, complaint) != 0)
      throw UsageError(fmt::format("{}\nTry `cansync --help`, or `cansync VERB --help`.", error.what()));
    Command help;
    help.verb = [told = text.str()](Session& session) {
      session.output().bytes(told);
      return ExitCode::done;
    };
    return help;
  }

  /// Words that stand for nothing: throws UsageError with the first one.
  [[noreturn]] void refuse_extra_words() const {
    const CLI::App* verb = typed_verb(app_);
    const std::vector<std::string> words = app_.remaining(true);
    const std::string first = words.empty() ? "" : words.front();
    if (verb == nullptr && !first.starts_with('-'))
      throw UsageError(fmt::format("VERB: found '{}'{}; allowed: {}", first,
                                   did_you_mean(first, verb_names(app_)), verb_list(app_)));
    const std::string name = verb == nullptr ? "" : name_of(*verb, app_);
    throw UsageError(fmt::format("found '{}', which is no argument of {}{}; see `cansync {}--help`", first,
                                 name.empty() ? "cansync" : name,
                                 first.starts_with('-') ? did_you_mean(first, option_names(app_, verb)) : "",
                                 name.empty() ? "" : name + " "));
  }

  void refuse_place_options() const {
    for (const char* option : kOptionsOfPlace) {
      if (app_.get_option(option)->count() == 0) continue;
      throw UsageError(
          fmt::format("{}: not allowed in a line of a batch, which has one connection; give it to `cansync "
                      "batch` itself",
                      option));
    }
  }

  CLI::App app_;
  Place place_;
  GlobalTexts texts_;
  Command command_;
};

}  // namespace

Command parse_command(const std::vector<std::string>& words) {
  CommandLine line(Globals{}, Place::shell);
  return line.parse(as_options(line.app(), words));
}

Command parse_batch_command(const std::vector<std::string>& words, const Globals& globals) {
  return CommandLine(globals, Place::batch).parse(words);
}

std::string complete_command(const std::vector<std::string_view>& words) {
  const CommandLine line(Globals{}, Place::shell);
  return text::completions(line.app(), words, completion_lookup());
}

}  // namespace cansync::cli
