#include "cli/cansync/verbs.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>

#include "cli/base/consent.h"
#include "cli/base/interrupt.h"
#include "cli/base/verb_groups.h"
#include "cli/cansync/parameter/parameter_answer.h"
#include "cli/cansync/parameter/parameter_request.h"
#include "cli/text/column_help.h"
#include "cli/text/slave_list.h"
#include "profile/scaling.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

/// Those of `read`: several parameters, and again and again.
struct ReadOptions {
  ParameterOptions each;
  std::vector<std::string> parameters;
  std::string every;        ///< seconds; empty: once
  std::string count = "0";  ///< rounds; 0: until Ctrl-C
};

ExitCode run_job(Session& session, const KnownRequest& request) {
  const Effect effect = request.job.write ? Effect::changes : Effect::reads;
  return finish_parameter(session, request,
                          session.ask(effect, [&] { return session.client().submit(request.job); }));
}

std::vector<unsigned> slaves_of(const std::vector<KnownRequest>& requests) {
  std::vector<unsigned> slaves;
  slaves.reserve(requests.size());
  for (const KnownRequest& request : requests) slaves.push_back(request.job.slave);
  return slaves;
}

/// The parameters of one slave, in the order typed.
using Readings = std::vector<KnownRequest>;

/// Those of each slave, all of them checked; what needs no daemon first.
std::vector<Readings> parse_readings(Session& session, const ReadOptions& options) {
  ParameterOptions each = options.each;
  for (const std::string& parameter : options.parameters) {
    each.parameter = parameter;
    static_cast<void>(parse_numbers(session, each));
  }
  std::vector<Readings> slaves;
  for (const std::string& parameter : options.parameters) {
    each.parameter = parameter;
    const std::vector<KnownRequest> of_all = parse_requests(session, each, [](const KnownRequest& request) {
      if (request.known == nullptr) return;
      if (const auto problem = profile::read_problem(*request.known)) throw UsageError(problem->text);
    });
    slaves.resize(of_all.size());
    for (std::size_t i = 0; i < of_all.size(); ++i) slaves[i].push_back(of_all[i]);
  }
  return slaves;
}

ExitCode read_one(Session& session, const KnownRequest& request, Table& table, bool timed) {
  const client::ParameterReply reply =
      session.ask(Effect::reads, [&] { return session.client().submit(request.job); });
  Shown shown{&table, std::nullopt};
  if (timed) {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    shown.time = std::chrono::nanoseconds(now).count();
  }
  return finish_parameter(session, request, reply, shown);
}

/// Writes the rows of a round; `first`: below the heading.
void show_round(Session& session, Table& table, bool first) {
  if (session.json()) return;
  if (first) {
    session.output().table(table);
  } else {
    for (const std::string& line : table.lines(session.output().fitting_width())) session.output().line(line);
  }
  table.clear();
}

struct Round {
  ExitCode code;
  /// The first answer. That of a program's first request takes longer: DDS has to find its way.
  std::chrono::steady_clock::time_point begin;
};

/// Every parameter of every slave once, also when one fails; ends early at Ctrl-C.
Round read_round(Session& session, const std::vector<Readings>& slaves, Table& table, bool timed) {
  std::optional<std::chrono::steady_clock::time_point> begin;
  std::vector<unsigned> numbers;
  numbers.reserve(slaves.size());
  for (const Readings& readings : slaves) numbers.push_back(readings.front().job.slave);
  const ExitCode ended = session.for_each(
      numbers,
      [&](std::size_t index) {
        ExitCode first = ExitCode::done;
        for (const KnownRequest& request : slaves[index]) {
          const ExitCode code = read_one(session, request, table, timed);
          if (!begin) begin = std::chrono::steady_clock::now();
          if (first == ExitCode::done) first = code;
          if (interrupt_flag().load() || code == ExitCode::not_reachable) break;
        }
        return first;
      },
      Session::Lines::grouped);
  return {ended, begin.value_or(std::chrono::steady_clock::now())};
}

/// Rounds until there were `count` of them, or (0) Ctrl-C, which is their end and no failure.
ExitCode read_rounds(Session& session, const ReadOptions& options, std::vector<Readings> slaves,
                     std::chrono::nanoseconds every, std::int64_t count) {
  ExitCode first = ExitCode::done;
  std::chrono::steady_clock::time_point next;
  Table table(reading_columns(true));
  for (std::int64_t round = 1;; ++round) {
    constexpr std::chrono::milliseconds kLook(100);
    while (!session.follow_names([&] { slaves = parse_readings(session, options); }))
      if (wait_until(std::chrono::steady_clock::now() + kLook)) return first;
    const auto [code, begin] = read_round(session, slaves, table, true);
    if (round == 1) next = begin;
    show_round(session, table, round == 1);
    if (interrupt_flag().load()) return first;
    if (first == ExitCode::done) first = code;
    if (round == count || code == ExitCode::not_reachable) return first;
    next = std::max(next + every, std::chrono::steady_clock::now());
    if (wait_until(next)) return first;
  }
}

ExitCode read_verb(Session& session, const ReadOptions& options) {
  constexpr double kShortest = 0.1;     // seconds
  constexpr double kLongest = 86400.0;  // seconds
  const std::int64_t count = parse_integer(options.count, "--count", 0, 1'000'000'000);
  std::chrono::nanoseconds every(0);
  if (!options.every.empty()) {
    const double seconds = parse_real(options.every, "--every");
    if (seconds < kShortest || seconds > kLongest)
      throw UsageError(fmt::format("--every: found '{}'; allowed: {:g}..{:g} seconds", options.every,
                                   kShortest, kLongest));
    every = std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(seconds));
  }
  const std::vector<Readings> slaves = parse_readings(session, options);
  if (!options.every.empty()) return read_rounds(session, options, slaves, every, count);
  Table table(reading_columns(false));
  const ExitCode code = read_round(session, slaves, table, false).code;
  if (!table.lines().empty()) show_round(session, table, true);
  return code;
}

Width width_of(client::ParameterFormat format) {
  return format == client::ParameterFormat::word ? Width::word : Width::doubleword;
}

/// Takes value and format by the profile, which the parameter must be known to. Throws UsageError for what
/// the profile does not allow; nothing is sent then.
void take_known_value(KnownRequest& request, const std::string& text, client::ParameterFormat typed) {
  using Format = client::ParameterFormat;
  const profile::Parameter& known = *request.known;
  const Format own = known.format == profile::Format::word ? Format::word : Format::doubleword;
  if (typed != Format::as_slave_says && typed != own) {
    throw UsageError(fmt::format("--format: {} is a {} by its profile; allowed: {}, auto",
                                 profile::label(known), profile::name(known.format),
                                 profile::name(known.format)));
  }
  if (request.scaled) {
    const auto raw = profile::to_raw(known, text);
    if (const auto* refused = std::get_if<profile::Refused>(&raw))
      throw UsageError("VALUE: " + refused->text);
    request.job.value = std::get<std::uint32_t>(raw);
  } else {
    request.job.value = parse_raw(text, "VALUE", width_of(own));
  }
  if (const auto refused = profile::write_problem(known, request.job.value)) {
    throw UsageError("VALUE: " + refused->text);
  }
  request.job.format = own;
}

/// Writes to one slave; `request` is complete but for a value whose width only the slave knows.
ExitCode write_one(Session& session, KnownRequest request, const std::string& value) {
  using Format = client::ParameterFormat;
  if (has_known_value(request)) return run_job(session, request);
  if (request.job.format == Format::as_slave_says && value.starts_with('-')) {
    // The two's complement depends on the width.
    client::ParameterRequest ask = request.job;
    ask.write = false;
    const client::ParameterReply reply =
        session.ask(Effect::reads, [&] { return session.client().submit(ask); });
    if (!reply.ok()) return finish_parameter(session, request, reply);
    request.job.format = reply.doubleword ? Format::doubleword : Format::word;
  }
  request.job.value = parse_raw(value, "VALUE", width_of(request.job.format));
  return run_job(session, request);
}

ExitCode write_verb(Session& session, const ParameterOptions& options) {
  const std::string what =
      fmt::format("write {}: {} into parameter {} of ", options.slave, options.value, options.parameter);
  if (names_all(options.slave) && !options.consent.dry_run)
    ask_consent(session, options.consent, what + "every configured slave");
  const client::ParameterFormat typed = parse_format(options.format);
  // Told before anything is sent; with `auto` a doubleword is the widest the slave can have.
  if ((looks_like_number(options.parameter) && !options.scaled) || options.raw) {
    static_cast<void>(parse_raw(options.value, "VALUE", width_of(typed)));
  }
  const std::vector<KnownRequest> requests = parse_requests(session, options, [&](KnownRequest& request) {
    request.job.write = true;
    if (has_known_value(request)) take_known_value(request, options.value, typed);
  });
  if (options.consent.dry_run) {
    session.output().remark(
        fmt::format("{}{} would be sent; nothing was sent", what, text::counted(requests.size(), "slave")));
    return ExitCode::done;
  }
  return session.for_each(
      slaves_of(requests),
      [&](std::size_t index) { return write_one(session, requests[index], options.value); },
      Session::Lines::grouped);
}

constexpr const char* kParameterHelp = "parameter number 0..4095, or its name in the slave's drive profile";

}  // namespace

void add_parameter_verbs(CLI::App& app, Verb& chosen) {
  auto* read = app.add_subcommand("read", "read parameters of slaves");
  read->group(kParameterVerbs);
  auto read_options = std::make_shared<ReadOptions>();
  read->add_option("SLAVE", read_options->each.slave, kSlavesHelp)->required();
  read->add_option("PARAMETER", read_options->parameters, kParameterHelp)->required();
  add_parameter_options(*read, read_options->each);
  auto* every =
      read->add_option("--every", read_options->every,
                       "again and again, so many seconds from one round to the next, 0.1..86400, until "
                       "Ctrl-C")
          ->type_name("SECONDS");
  read->add_option("--count", read_options->count,
                   "with --every: end after N rounds; 0 = until Ctrl-C (default)")
      ->type_name("N")
      ->needs(every);
  read->footer("One row for each value of each slave; with --every the rows of each round.\n" +
               columns_help(reading_columns(true)));
  read->callback([read_options, &chosen] {
    chosen = [read_options](Session& session) { return read_verb(session, *read_options); };
  });

  auto* write = app.add_subcommand("write", "write a parameter of a slave");
  write->group(kParameterVerbs);
  auto write_options = std::make_shared<ParameterOptions>();
  write->add_option("SLAVE", write_options->slave, kSlavesHelp)->required();
  write->add_option("PARAMETER", write_options->parameter, kParameterHelp)->required();
  write
      ->add_option(
          "VALUE", write_options->value,
          "with a name: in its unit; with a number or --raw: raw, as on the bus, decimal, hexadecimal (0x..) "
          "or\nnegative")
      ->required();
  add_parameter_options(*write, *write_options);
  add_consent_options(*write, write_options->consent);
  write->footer(
      "Prints what was written: the value in its unit and raw. What the slave's profile does not allow (limits, format, "
      "access) is an\n"
      "error of the command line, and nothing is sent. Without a profile and with --format auto the "
      "parameter is read\n"
      "first, so that it is written in the slave's own format. `write all` is asked for on a terminal, and "
      "needs --yes elsewhere. Exit code 5 after `no_answer`: whether the "
      "slave took the\nvalue is not known.");
  write->callback([write_options, &chosen] {
    chosen = [write_options](Session& session) { return write_verb(session, *write_options); };
  });
}

}  // namespace cansync::cli
