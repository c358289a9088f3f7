#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cansync_slave/client/release_writer.h"
#include "cli/base/endings.h"
#include "cli/base/interrupt.h"
#include "cli/cansync_slave/verbs.h"
#include "cli/connect/bus_verb.h"
#include "cli/text/values.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

using Clock = std::chrono::steady_clock;

using cansync_slave::client::ReleaseWriter;
using cansync_slave::client::SlaveClient;

/// The arguments as they were typed; empty: not given.
struct ActualTexts {
  std::vector<std::string> assignments;
  std::string rate = "50";
  std::string wait;
  std::string strength = "1";
  std::string seconds;
};

/// The values of one telegram.
struct TelegramToRelease {
  std::array<std::uint32_t, 4> raw{};
  std::uint8_t valid = 0;
};

/// How the values are released.
struct ReleasePace {
  std::chrono::nanoseconds period{};
  std::uint32_t wait = 1;         ///< intervals
  std::optional<double> seconds;  ///< nothing: until Ctrl-C
};

std::array<TelegramToRelease, 2> parse_values(const ActualTexts& texts) {
  std::array<TelegramToRelease, 2> telegrams{};
  const ValueLookup no_names = [](std::string_view) { return std::nullopt; };
  for (const std::string& text : texts.assignments) {
    const Assignment assignment = parse_assignment(text);
    const unsigned value = parse_value_number(assignment.value, no_names);
    TelegramToRelease& telegram = telegrams[value / 4];
    telegram.raw[value % 4] = parse_raw(assignment.number, assignment.value, Width::doubleword);
    telegram.valid = static_cast<std::uint8_t>(telegram.valid | (1u << (value % 4)));
  }
  return telegrams;
}

ReleasePace parse_release_pace(const ActualTexts& texts, std::uint64_t interval_length) {
  constexpr std::int64_t kMostWait = 1000;
  constexpr double kPeriodsWaited = 3.0;  // so that two late samples leave no gap
  const double rate = parse_real(texts.rate, "--rate");
  if (!(rate >= 0.01 && rate <= 1000.0))
    throw UsageError(fmt::format("--rate: found '{}'; allowed: 0.01..1000 Hz", texts.rate));
  ReleasePace pace;
  pace.period = std::chrono::nanoseconds(std::llround(1e9 / rate));
  if (!texts.seconds.empty()) {
    pace.seconds = parse_real(texts.seconds, "--seconds");
    if (!(*pace.seconds > 0.0 && *pace.seconds <= 1e6))
      throw UsageError(
          fmt::format("--seconds: found '{}'; allowed: over 0 and up to 1000000", texts.seconds));
  }
  if (!texts.wait.empty()) {
    pace.wait = static_cast<std::uint32_t>(parse_integer(texts.wait, "--wait", 1, kMostWait));
  } else {
    const double interval = static_cast<double>(std::max<std::uint64_t>(interval_length, 1));
    const double wanted = std::ceil(kPeriodsWaited * 1e9 / rate / interval);
    pace.wait = static_cast<std::uint32_t>(std::clamp(wanted, 1.0, static_cast<double>(kMostWait)));
  }
  return pace;
}

/// What became of one release of each telegram.
struct Turn {
  std::string problem;  ///< what failed first, but for a telegram that another writer has
  std::string waits;    ///< who has one; empty: nobody
  bool released = false;
};

/// Releases the values of each telegram that has some, also when the other one fails.
Turn release_once(ReleaseWriter& writer, const std::array<TelegramToRelease, 2>& telegrams,
                  std::uint32_t wait) {
  Turn turn;
  for (const std::uint8_t number : {std::uint8_t{1}, std::uint8_t{2}}) {
    const TelegramToRelease& telegram = telegrams[number - 1u];
    if (telegram.valid == 0) continue;
    std::string problem = writer.write(number, telegram.raw, telegram.valid, wait);
    if (problem.empty()) {
      turn.released = true;
      continue;
    }
    std::string& first = writer.waits() ? turn.waits : turn.problem;
    if (first.empty()) first = std::move(problem);
  }
  return turn;
}

/// Releases until the time is over or Ctrl-C came; waits, and says so once, while another writer has a telegram.
client::Reply stream_actual(Output& output, SlaveClient& client, ReleaseWriter& writer,
                            const std::array<TelegramToRelease, 2>& telegrams, const ReleasePace& pace,
                            std::uint64_t& samples) {
  const auto start = Clock::now();
  const auto length = std::chrono::duration<double>(pace.seconds.value_or(0.0));
  const auto end =
      pace.seconds ? start + std::chrono::duration_cast<Clock::duration>(length) : Clock::time_point::max();
  std::string told;
  for (auto next = start; next < end;) {
    (void)client.receive(std::chrono::milliseconds(0), {});
    if (writer.daemon_restarted())
      return {client::ReplyCode::no_reply,
              "the daemon was started anew: no value is released to it; look at the line, then call `cansync "
              "actual` again"};
    Turn turn = client.daemon_present() ? release_once(writer, telegrams, pace.wait)
                                        : Turn{"the daemon has gone (" + client.place() + ")", "", false};
    if (!turn.problem.empty() && !just_continued())
      return {client::ReplyCode::no_reply, std::move(turn.problem)};
    if (turn.waits != told && !turn.waits.empty()) output.remark(turn.waits);
    told = std::move(turn.waits);
    if (turn.released) ++samples;
    next = std::max(next + pace.period, Clock::now());  // a late turn is not caught up
    if (wait_until(std::min(next, end))) break;
  }
  return {client::ReplyCode::done, ""};
}

ExitCode actual_verb(Session& session, const ActualTexts& texts) {
  constexpr std::int64_t kStrongest = 2'147'483'647;
  const auto strength = static_cast<std::int32_t>(parse_integer(texts.strength, "--strength", 0, kStrongest));
  const std::array<TelegramToRelease, 2> telegrams = parse_values(texts);
  auto client = connect_bus<SlaveClient>(session);
  const auto status = client.status(session.search_time());
  const ReleasePace pace = parse_release_pace(texts, status ? status->interval_length : 1'000'000);
  if (status && !status->synchronized)
    session.output().remark("the slave is not synchronized: nothing is sent until it is");
  std::uint64_t samples = 0;
  ReleaseWriter writer(client, strength);
  const client::Reply reply = stream_actual(session.output(), client, writer, telegrams, pace, samples);
  if (reply.ok() && samples == 0) {
    constexpr std::string_view kNothing = "not one value was released: another program has the telegrams";
    if (session.json())
      session.output().object(JsonObject()
                                  .add("samples", samples)
                                  .add("wait_intervals", pace.wait)
                                  .add("result", "no_effect")
                                  .add("reason", kNothing)
                                  .add_null("cause"));
    throw Ended(ExitCode::no_effect, fmt::format("actual: {}", kNothing));
  }
  return session.finish(
      reply, JsonObject().add("samples", samples).add("wait_intervals", pace.wait), "actual",
      fmt::format("values were released {} and are given up", text::counted(samples, "time")));
}

}  // namespace

void add_actual_verb(CLI::App& app, Verb& chosen) {
  auto* actual = app.add_subcommand("actual", "release actual values until Ctrl-C, or for --seconds");
  actual->group("The daemon as a slave");
  auto texts = std::make_shared<ActualTexts>();
  actual
      ->add_option(
          "VALUE=NUMBER", texts->assignments,
          "actual value 0..7 (or value0..value7) and its raw number: -2147483648..4294967295, decimal or "
          "0x..")
      ->required();
  actual->add_option("--rate", texts->rate, "releases a second, 0.01..1000 (default 50)")->type_name("HZ");
  actual
      ->add_option("--wait", texts->wait,
                   "intervals for which each release waits for the master to ask, 1..1000 (default: three "
                   "periods of the rate)")
      ->type_name("N");
  actual
      ->add_option(
          "--strength", texts->strength,
          "a telegram that another writer has is taken over by a stronger one alone; 0 and more (default 1)")
      ->type_name("N");
  actual->add_option("--seconds", texts->seconds, "end after this time (default: Ctrl-C ends)")
      ->type_name("S");
  actual->footer(
      "Of a bus with bus.protocol = \"cansync-slave\". Values 0..3 go out in RDC1, 4..7 in RDC2, when the master asks "
      "for\nthem; one release is good for one telegram.\nExample: cansync slave actual 0=1000 4=50 --seconds 10");
  run_when_named(*actual, chosen, texts, actual_verb);
}

}  // namespace cansync::cli
