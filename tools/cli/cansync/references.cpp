#include <cansync/reference_repeater.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>

#include "cli/base/endings.h"
#include "cli/base/interrupt.h"
#include "cli/base/own_process.h"
#include "cli/base/verb_groups.h"
#include "cli/cansync/fault_words.h"
#include "cli/cansync/reference_effect.h"
#include "cli/cansync/verbs.h"
#include "cli/text/words.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint16_t kSettingUp = 0x0043;  // w_OPTION_STATUS: setting up as master

/// The arguments as they were typed; empty: not given.
struct SetTexts {
  std::vector<std::string> assignments;
  bool scaled = false;
  bool raw = false;
  std::string rate = "50";
  std::string release;
  std::string strength = "1";
  bool take_over = false;
  std::string seconds;
};

/// How the values are given.
struct Pace {
  std::chrono::nanoseconds period{};
  std::uint32_t release = 1;      ///< intervals
  std::optional<double> seconds;  ///< nothing: until Ctrl-C
};

/// A raw value of which the low word alone is sent: what 16 bits hold, with or without a sign.
std::int32_t parse_word(const Assignment& assignment) {
  return static_cast<std::int32_t>(
      parse_integer(assignment.number, assignment.value + " (its low word alone is mapped)",
                    std::numeric_limits<std::int16_t>::min(), std::numeric_limits<std::uint16_t>::max()));
}

/// Is the number in the value's unit? As in `read` and `write` when the value was named, not numbered.
bool in_unit(const SetTexts& texts, const Assignment& assignment, const cansync_ValueName& name) {
  if (texts.raw || texts.scaled) return texts.scaled;
  return std::string_view(name.name) == assignment.value;
}

std::int32_t parse_value(const Assignment& assignment, const cansync_ValueName& name, bool scaled) {
  const RawForm form = raw_form(name);
  // The bits count: what has no sign may need the highest one.
  if (scaled)
    return static_cast<std::int32_t>(unscale(parse_real(assignment.number, assignment.value), name.factor,
                                             name.offset, form, assignment.value));
  if (form.width == Width::word) return parse_word(assignment);
  return as_signed(parse_raw(assignment.number, assignment.value, Width::doubleword), Width::doubleword);
}

/// Number of a value; a name that is none of the line's is told with those there are.
unsigned parse_reference(std::string_view text, const client::MasterStatus& status) {
  try {
    return parse_value_number(text, value_lookup(status.reference_value));
  } catch (const UsageError& error) {
    std::vector<std::string> names;
    for (const cansync_ValueName& name : status.reference_value)
      if (!client::text(name.name).empty()) names.emplace_back(name.name);
    if (names.empty()) throw;
    throw UsageError(
        fmt::format("{}{}; configured: {}", error.what(), did_you_mean(text, names), fmt::join(names, ", ")));
  }
}

Telegrams parse_telegrams(const SetTexts& texts, const client::MasterStatus& status) {
  Telegrams telegrams{};
  for (const std::string& text : texts.assignments) {
    const Assignment assignment = parse_assignment(text);
    const unsigned value = parse_reference(assignment.value, status);
    const cansync_ValueName& name = status.reference_value[value];
    TelegramToSet& telegram = telegrams[value / 4];
    telegram.value[value % 4] = parse_value(assignment, name, in_unit(texts, assignment, name));
    telegram.valid = static_cast<std::uint8_t>(telegram.valid | (1u << (value % 4)));
  }
  return telegrams;
}

Pace parse_pace(const SetTexts& texts, const client::MasterStatus& status) {
  const double rate = parse_real(texts.rate, "--rate");
  if (!(rate >= 0.01 && rate <= 1000.0))
    throw UsageError(fmt::format("--rate: found '{}'; allowed: 0.01..1000 Hz", texts.rate));
  Pace pace;
  pace.period = std::chrono::nanoseconds(std::llround(1e9 / rate));
  if (!texts.seconds.empty()) {
    pace.seconds = parse_real(texts.seconds, "--seconds");
    if (!(*pace.seconds > 0.0 && *pace.seconds <= 1e6))
      throw UsageError(
          fmt::format("--seconds: found '{}'; allowed: over 0 and up to 1000000", texts.seconds));
  }
  if (!texts.release.empty()) {
    pace.release = static_cast<std::uint32_t>(parse_integer(texts.release, "--release", 1, 1'000'000));
    return pace;
  }
  const std::chrono::nanoseconds interval(std::max<std::uint64_t>(status.interval_length, 1));
  pace.release = client::release_intervals_for(pace.period, interval);
  if (pace.release > client::kMostReleaseIntervals) {
    const auto longest =
        static_cast<double>(std::chrono::nanoseconds(interval * client::kMostReleaseIntervals).count());
    const double periods = client::release_intervals_for(interval, interval);
    throw UsageError(fmt::format(
        "--rate: found '{}'; allowed without --release: {:.3g} Hz and more, so that a sample need not be "
        "released for over {} intervals",
        texts.rate, periods * 1e9 / longest, client::kMostReleaseIntervals));
  }
  return pace;
}

/// Says what will keep the values from having an effect.
void warn(Output& output, const Telegrams& telegrams, const client::MasterStatus& status) {
  if (status.option_status != kActiveMaster)
    output.remark(fmt::format("the master is not in run but in {}: nothing is sent until {}", status.state,
                              status.option_status == kSettingUp
                                  ? "`cansync mode run`"
                                  : "`cansync mode setup`, then `cansync mode run`"));
  const unsigned mapped = mapped_values(status.reference_mapping);
  for (unsigned value = 0; value < 8; ++value) {
    const bool given = ((telegrams[value / 4].valid >> (value % 4)) & 1u) != 0;
    if (given && ((mapped >> value) & 1u) == 0)
      output.remark(
          fmt::format("reference value {} is in no telegram, so it has no effect; see `cansync map`", value));
  }
}

/// Says which drives will not move, as far as their profiles tell.
void warn_of_faults(Session& session) {
  constexpr std::chrono::milliseconds kMost(500);  // values are waited for
  FaultWords faults(session);
  std::vector<std::string> names;
  for (const client::SlaveStatus& slave : session.client().slaves(kMost))
    if (slave.responds && !faults.of(slave).empty()) names.emplace_back(client::text(slave.name));
  if (names.empty()) return;
  constexpr std::size_t kShown = 5;
  if (names.size() > kShown + 1) {
    const std::string more = fmt::format("{} more", names.size() - kShown);
    names.resize(kShown);
    names.push_back(more);
  }
  session.output().remark(
      fmt::format("in fault: {}: a drive in fault follows no reference values until it is acknowledged; see "
                  "`cansync doctor`",
                  fmt::join(names, ", ")));
}

/// Collects warnings and errors that the daemon tells while values are given: it is the only answer there is.
class Complaints {
 public:
  Complaints(client::Client& client, ReferenceEffect& effect)
      : effect_(effect),
        since_(std::chrono::system_clock::now()),
        subscription_(client.on_event([this](const client::Event& event) { take(event); })) {}

  void tell(Output& output) {
    const std::lock_guard lock(mutex_);
    for (const std::string& text : texts_) output.remark(text);
    texts_.clear();
  }

 private:
  void take(const client::Event& event) {
    const auto since =
        std::chrono::duration_cast<std::chrono::nanoseconds>(since_.time_since_epoch()).count();
    if (event.time < since) return;
    effect_.take(event);
    if (event.severity == gateway_SEVERITY_INFO) return;
    const std::lock_guard lock(mutex_);
    texts_.push_back(fmt::format("{}: {}", event.code, event.text));
  }

  ReferenceEffect& effect_;
  std::chrono::system_clock::time_point since_;
  std::mutex mutex_;
  std::vector<std::string> texts_;
  client::Subscription subscription_;  // last: its callback uses what stands above
};

/// What became of one sample of each telegram.
struct Turn {
  std::string problem;       ///< what failed first, but for a telegram that another writer has
  bool waits = false;        ///< another writer has one
  std::uint64_t values = 0;  ///< that were written
};

/// Writes one sample of each telegram that has values, also when the other one fails.
Turn write_once(client::ReferenceWriter& writer, const Telegrams& telegrams, std::uint32_t release) {
  Turn turn;
  std::uint8_t number = 0;
  for (const TelegramToSet& telegram : telegrams) {
    ++number;
    if (telegram.valid == 0) continue;
    std::string problem = writer.write(number, telegram.value, telegram.valid, release);
    if (problem.empty()) {
      turn.values += static_cast<std::uint64_t>(std::popcount(telegram.valid));
    } else if (writer.waits()) {
      turn.waits = true;
    } else if (turn.problem.empty()) {
      turn.problem = std::move(problem);
    }
  }
  return turn;
}

void give_up(client::ReferenceWriter& writer, const Telegrams& telegrams) {
  std::uint8_t number = 0;
  for (const TelegramToSet& telegram : telegrams) {
    ++number;
    if (telegram.valid != 0) writer.release(number);
  }
}

/// "telegram 1", "telegrams 1 and 2".
std::string_view telegrams_text(const Telegrams& telegrams) {
  if (telegrams[0].valid != 0 && telegrams[1].valid != 0) return "telegrams 1 and 2";
  return telegrams[0].valid != 0 ? "telegram 1" : "telegram 2";
}

/// Why the values are not given any more.
client::Reply ended(client::ReferenceStanding standing) {
  if (standing == client::ReferenceStanding::daemon_restarted)
    return {
        client::ReplyCode::no_reply,
        "the daemon was started anew: settings that clients had made are lost, and no value is given to it; "
        "look at the line, then call `cansync set` again"};
  return {client::ReplyCode::refused,
          "the mapping of the reference values was changed: no value is given under another one; look at "
          "`cansync map`, then call `cansync set` again",
          client::Speaker::client, client::RefusalCause::mapping_changed};
}

// After so long it has told whom it hears.
constexpr auto kWordOfDaemon = std::chrono::milliseconds(300);
constexpr auto kLookAgain = std::chrono::milliseconds(10);

/// What --json tells of values without effect.
JsonObject no_effect_object(std::uint64_t samples, std::uint32_t release, const std::string& reason) {
  return JsonObject()
      .add("samples", samples)
      .add("release_intervals", release)
      .add("result", "no_effect")
      .add("reason", reason)
      .add_null("cause");
}

/// Nothing is given, not one sample, while another writer has a telegram that is no weaker. Throws Ended.
void refuse_what_another_gives(Session& session, const Telegrams& telegrams,
                               const client::MasterStatus& status, std::int32_t strength,
                               std::uint32_t release) {
  for (unsigned telegram = 0; telegram < telegrams.size(); ++telegram) {
    if (telegrams[telegram].valid == 0) continue;
    const std::string another = given_by_another(telegram, status, strength,
                                                 fmt::format("nothing is given with strength {}", strength));
    if (another.empty()) continue;
    if (session.json()) session.output().object(no_effect_object(0, release, another));
    throw Ended(ExitCode::no_effect, "set: " + another);
  }
}

/// Says what is given to whom until when, on a terminal, where nothing else would be seen.
void announce(Output& output, const SetTexts& texts, const Pace& pace, std::int32_t strength) {
  if (output.json() || !output.data_on_terminal()) return;
  const std::string end = pace.seconds ? fmt::format("for {:g} s", *pace.seconds) : "until Ctrl-C";
  output.remark(
      fmt::format("giving {} {}, with strength {}", fmt::join(texts.assignments, " "), end, strength));
}

/// Gives the values until the time is over or Ctrl-C came; then gives the telegrams up.
ExitCode stream(Session& session, const Telegrams& telegrams, const client::Validity& meant_for,
                const Pace& pace, std::int32_t strength) {
  client::Client& client = session.client();
  ReferenceEffect effect(telegrams, strength, name_of_this_process());
  Complaints complaints(client, effect);
  const auto look = [&] {
    const auto status = client.master_status(std::chrono::milliseconds(0));
    if (!status) return;  // that the daemon has gone is told below
    if (const std::string told = effect.look(*status); !told.empty()) session.output().remark(told);
  };
  client::ReferenceWriter writer(client, strength);
  writer.take_up(meant_for);
  const auto start = Clock::now();
  const auto length = std::chrono::duration<double>(pace.seconds.value_or(0.0));
  const auto end =
      pace.seconds ? start + std::chrono::duration_cast<Clock::duration>(length) : Clock::time_point::max();
  client::Reply reply{client::ReplyCode::done, ""};
  std::uint64_t samples = 0;
  std::uint64_t values = 0;
  for (auto next = start; next < end;) {
    Turn turn = write_once(writer, telegrams, pace.release);
    if (const auto standing = writer.standing(); standing != client::ReferenceStanding::current) {
      const std::string several = client.several_daemons();
      reply = several.empty() ? ended(standing) : client::Reply{client::ReplyCode::no_reply, several};
      break;
    }
    // A stronger writer that has come may go again.
    if (turn.problem.empty() && !turn.waits && !client.daemon_present())
      turn.problem = "the daemon has gone (" + client.place() + ")";
    if (!turn.problem.empty() && !just_continued()) {
      reply = {client::ReplyCode::no_reply, turn.problem};
      break;
    }
    if (turn.values != 0) ++samples;
    values += turn.values;
    if (Clock::now() >= start + kWordOfDaemon) look();
    complaints.tell(session.output());
    // A late turn is not caught up.
    next = std::max(next + pace.period, Clock::now());
    if (wait_until(std::min(next, end))) break;
  }
  give_up(writer, telegrams);
  if (reply.ok()) {
    // The daemon's word of the first sample may still be on its way, also after Ctrl-C.
    for (const auto late = Clock::now() + kWordOfDaemon; !effect.heard() && Clock::now() < late;)
      std::this_thread::sleep_for(kLookAgain);
    look();
  }
  complaints.tell(session.output());
  if (const std::string reason = effect.without_effect(); reply.ok() && !reason.empty()) {
    if (session.json()) session.output().object(no_effect_object(samples, pace.release, reason));
    throw Ended(ExitCode::no_effect, fmt::format("set: the values had no effect: {}", reason));
  }
  return session.finish(reply, JsonObject().add("samples", samples).add("release_intervals", pace.release),
                        "set",
                        fmt::format("sent {} to {}; released", text::counted(values, "reference value"),
                                    telegrams_text(telegrams)));
}

ExitCode set_verb(Session& session, const SetTexts& texts) {
  constexpr std::int64_t kStrongest = 2'147'483'647;
  auto strength = static_cast<std::int32_t>(parse_integer(texts.strength, "--strength", 0, kStrongest));
  for (const std::string& text : texts.assignments) static_cast<void>(parse_assignment(text));
  const client::MasterStatus status = session.client().master_status();
  const Telegrams telegrams = parse_telegrams(texts, status);
  const Pace pace = parse_pace(texts, status);
  if (texts.take_over) strength = strength_to_take_over(telegrams, status, strength);
  refuse_what_another_gives(session, telegrams, status, strength, pace.release);
  warn(session.output(), telegrams, status);
  if (status.option_status == kActiveMaster) warn_of_faults(session);
  announce(session.output(), texts, pace, strength);
  // Names and units are those of this status, whatever has come since.
  client::Validity meant_for{.mapping_number = status.mapping_number};
  std::copy(std::begin(status.daemon), std::end(status.daemon), meant_for.daemon.begin());
  return stream(session, telegrams, meant_for, pace, strength);
}

}  // namespace

void add_reference_verb(CLI::App& app, Verb& chosen) {
  auto* set = app.add_subcommand("set", "give reference values until Ctrl-C, or for --seconds");
  set->group(kValueVerbs);
  auto texts = std::make_shared<SetTexts>();
  set->add_option(
         "VALUE=NUMBER", texts->assignments,
         "reference value 0..7 or value0..value7 and its raw number (-2147483648..4294967295, decimal or "
         "0x..), or its configured name and the number in its unit")
      ->required();
  auto* scaled = set->add_flag("--scaled", texts->scaled,
                               "also with value numbers: in the units of the configuration, e.g. 0=12.5");
  set->add_flag("--raw", texts->raw, "also with names: raw numbers")->excludes(scaled);
  set->add_option("--rate", texts->rate, "samples a second, 0.01..1000 (default 50)")->type_name("HZ");
  set->add_option("--release", texts->release,
                  "intervals in a row in which each sample is sent (default: three periods of the rate)")
      ->type_name("N");
  set->add_option(
         "--strength", texts->strength,
         "a telegram that another writer gives is taken over by a stronger one alone; 0 and more (default 1)")
      ->type_name("N");
  set->add_flag("--take-over", texts->take_over,
                "with a strength that takes the telegrams over from who gives them");
  set->add_option("--seconds", texts->seconds, "end after this time (default: Ctrl-C ends)")->type_name("S");
  set->footer(
      "Values 0..3 go out in telegram WRC1, 4..7 in WRC2; other values of the same telegram keep what they "
      "had. They\n"
      "are for every slave of the line; which follow, their control words decide. When the command ends, the "
      "telegrams are\n"
      "given up: a writer that waits takes over, or they are sent no more, and drives that had values fault.\n"
      "Example: cansync set 0=1000 4=50 --seconds 10");
  set->callback(
      [texts, &chosen] { chosen = [texts](Session& session) { return set_verb(session, *texts); }; });
}

}  // namespace cansync::cli
