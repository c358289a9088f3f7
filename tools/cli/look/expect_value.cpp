#include "cli/look/expect_value.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <optional>
#include <utility>

#include "cli/base/interrupt.h"
#include "cli/cansync/profiles.h"
#include "cli/cansync/wait_value.h"
#include "profile/scaling.h"

namespace cansync::cli {
namespace {

using Clock = std::chrono::steady_clock;

/// What is expected, and for how long it may come.
struct Expectation {
  Wanted wanted;
  std::optional<double> within;  ///< seconds; nothing: it is looked at once
};

std::string wanted_text(const Expectation& expected) {
  const Wanted& wanted = expected.wanted;
  const std::string text = fmt::format("expected of slave {}: {} {} {:.10g}", wanted.slave, wanted.value,
                                       wanted.sign, wanted.number);
  return expected.within ? fmt::format("{} within {:g} s", text, *expected.within) : text;
}

Clock::time_point end_of(double seconds) {
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

/// The exit status of an expectation that was not met, which is said.
ExitCode unmet(Session& session, const Expectation& expected, std::string_view found, ExitCode code) {
  if (interrupt_flag().load()) return ExitCode::cancelled;
  session.output().remark(fmt::format("{}; found: {}", wanted_text(expected), found));
  return code;
}

ExitCode expect_actual(Session& session, const Expectation& expected) {
  constexpr double kTelegram = 1.0;  // seconds for one telegram to come
  static_cast<void>(session.client());
  const ValueSeen seen =
      look_at_value(session, expected.wanted, end_of(expected.within.value_or(kTelegram)), !expected.within);
  if (seen.reached) return ExitCode::done;
  const std::string old =
      seen.text + ", and no new telegram came; `cansync slaves` and `cansync poll` tell more";
  return unmet(session, expected, seen.fresh ? seen.text : old, ExitCode::failed);
}

/// The parameter of an expectation, in the unit that is compared.
struct Sought {
  client::ParameterRequest job;
  ProfilePointer profile;                     ///< keeps `known`
  const profile::Parameter* known = nullptr;  ///< null: no profile tells of it
};

Sought find_sought(Session& session, const Wanted& wanted) {
  Sought sought;
  sought.job.slave = session.slave(wanted.slave);
  sought.job.timeout_ms = session.monitoring_ms();
  const SlaveProfile profile = find_profile(session, sought.job.slave, "");
  const NamedParameter parameter = find_parameter(wanted.value, profile);
  sought.job.number = parameter.number;
  sought.profile = profile.profile;
  sought.known = parameter.known;
  if (sought.known != nullptr)
    if (const auto problem = profile::read_problem(*sought.known)) throw UsageError(problem->text);
  return sought;
}

/// The number that is compared, as text without its unit; what is compared is what is shown. Nothing: the
/// slave's format is not that of its profile, so that its unit is not known.
std::optional<std::string> number_text(const Sought& sought, const Wanted& wanted,
                                       const client::ParameterReply& reply) {
  const bool same =
      sought.known != nullptr && reply.doubleword == (sought.known->format == profile::Format::doubleword);
  if (!same) {
    const bool bare = sought.known == nullptr || wanted.raw;
    return bare ? std::optional(fmt::format("{}", reply.value)) : std::nullopt;
  }
  const std::int64_t number = profile::raw_number(*sought.known, reply.value);
  return wanted.raw ? fmt::format("{}", number) : profile::scaled_text(*sought.known, number);
}

/// What one read says to an expectation.
struct Judgement {
  bool met = false;
  bool for_good = false;  ///< another read says the same
  std::string found = {};
  ExitCode code = ExitCode::failed;
};

Judgement judge(const Sought& sought, const Wanted& wanted, const client::ParameterReply& reply) {
  if (!reply.ok()) return {.found = reply.reason, .code = exit_code(reply.code)};
  const auto number = number_text(sought, wanted, reply);
  if (!number) {
    const auto name = [](bool doubleword) { return doubleword ? "doubleword" : "word"; };
    return {.for_good = true,
            .found = fmt::format("{} as a {}, but its profile says {}: its unit is not known", reply.value,
                                 name(reply.doubleword), name(!reply.doubleword))};
  }
  const std::string unit = wanted.raw || sought.known == nullptr ? "" : sought.known->unit;
  return {.met = holds(std::strtod(number->c_str(), nullptr), wanted.comparison, wanted.number),
          .found = unit.empty() ? *number : *number + " " + unit};
}

ExitCode expect_parameter(Session& session, const Expectation& expected) {
  constexpr auto kPause = std::chrono::milliseconds(100);  // leaves the command channel to others
  Sought sought = find_sought(session, expected.wanted);
  const auto end = end_of(expected.within.value_or(0.0));
  while (true) {
    if (!session.follow_names([&] { sought = find_sought(session, expected.wanted); })) {
      if (wait_until(Clock::now() + kPause))
        return unmet(session, expected, "its name is being changed", ExitCode::failed);
      continue;
    }
    const client::ParameterReply reply =
        session.ask(Effect::reads, [&] { return session.client().submit(sought.job); });
    const Judgement judged = judge(sought, expected.wanted, reply);
    if (judged.met) return ExitCode::done;
    const bool again = !judged.for_good && Clock::now() < end;
    if (again && !wait_until(std::min(end, Clock::now() + kPause))) continue;
    return unmet(session, expected, judged.found, judged.code);
  }
}

}  // namespace

Verb expect_value_verb(std::vector<std::string> words) {
  constexpr double kLongest = 86400.0;  // seconds
  const std::string what = words.front();
  words.erase(words.begin());
  Expectation expected;
  if (words.size() > 2 && words[words.size() - 2] == "within") {
    const double seconds = parse_real(words.back(), "within SECONDS");
    if (seconds < 0.0 || seconds > kLongest)
      throw UsageError(fmt::format("within SECONDS: found '{}'; allowed: 0..{:g}", words.back(), kLongest));
    expected.within = seconds;
    words.resize(words.size() - 2);
  }
  expected.wanted = parse_wanted(words, what);
  if (what == "read") {
    if (expected.wanted.raw) static_cast<void>(find_parameter(expected.wanted.value, {}));
    return [expected](Session& session) { return expect_parameter(session, expected); };
  }
  return [expected](Session& session) { return expect_actual(session, expected); };
}

}  // namespace cansync::cli
