#include <fmt/format.h>

#include <memory>
#include <span>
#include <utility>

#include "cli/base/files.h"
#include "cli/base/interrupt.h"
#include "cli/base/restarts.h"
#include "cli/base/verb_groups.h"
#include "cli/cansync/timing_report.h"
#include "cli/cansync/timing_samples.h"
#include "cli/cansync/timing_svg.h"
#include "cli/cansync/verbs.h"
#include "cli/text/column_help.h"
#include "cli/text/progress.h"

namespace cansync::cli {
namespace {

constexpr std::int64_t kLongest = 3600;  // seconds that are gathered at most

struct TimingTexts {
  std::string seconds;
  std::string svg;
  bool follow = false;
};

/// `first`: of this run; a picture of an earlier one is kept.
void write_svg(Output& output, const std::string& path, const TimingReport& report, bool first) {
  const std::string text = timing_svg(report, date_text());
  const std::span data(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  ReplacementFile file(path);
  if (!first) return file.commit(data);
  const std::string kept = file.commit_and_keep(data);
  if (!kept.empty()) output.remark(path + " had other contents; they are in " + kept);
}

void show(Output& output, const TimingReport& report, bool in_place) {
  if (output.json()) {
    output.object(report_object(report));
    return;
  }
  const auto lines = report_lines(report, output.data_width());
  if (in_place) {
    output.redraw(lines);
    return;
  }
  for (const std::string& line : lines) output.line(line);
}

/// No sample came: by Ctrl-C, because the daemon has gone, or for no reason known.
ExitCode no_sample(Session& session, bool following) {
  client::Client& client = session.client();
  if (interrupt_flag().load()) {
    if (following) return ExitCode::done;
    throw Interrupted();
  }
  if (!client.daemon_present()) {
    session.output().remark("the daemon has gone (" + client.place() + ")");
    return ExitCode::not_reachable;
  }
  session.output().remark("no timing figures came within 3 s (" + client.place() + ")");
  return ExitCode::failed;
}

/// The daemon was started anew between both.
bool counts_begin_again(const client::Timing& sample, const client::Timing& before) {
  return sample.intervals < before.intervals;
}

ExitCode timing_verb(Session& session, const TimingTexts& texts) {
  session.look_only();
  const bool gathers = !texts.seconds.empty();
  const std::int64_t seconds = gathers ? parse_integer(texts.seconds, "--seconds", 1, kLongest) : 1;
  client::Client& client = session.client();
  Restarts restarts(client);
  SampleQueue queue(client);
  std::optional<client::Timing> before;
  if (gathers && !(before = queue.next())) return no_sample(session, false);
  const bool in_place = texts.follow && session.output().data_on_terminal();
  bool first = true;
  do {
    std::vector<client::Timing> samples;
    while (samples.size() < static_cast<std::size_t>(seconds)) {
      const auto sample = queue.next();
      if (!sample) return no_sample(session, texts.follow);
      restarts.expect_one();
      const bool anew = restarts.take();
      if (anew) session.output().remark(kStartedAnew);
      // One of the start before may still have been on its way when the restart was known.
      if (gathers && (anew || counts_begin_again(*sample, samples.empty() ? *before : samples.back()))) {
        samples.clear();
        before = sample;
      } else {
        samples.push_back(*sample);
      }
    }
    const TimingReport report = timing_report(samples, before ? &*before : nullptr, line_facts(client));
    show(session.output(), report, in_place);
    if (!texts.svg.empty()) write_svg(session.output(), texts.svg, report, std::exchange(first, false));
    if (before) before = samples.back();
  } while (texts.follow);
  return ExitCode::done;
}

}  // namespace

void add_timing_verb(CLI::App& app, Verb& chosen) {
  auto* timing = app.add_subcommand("timing", "how punctual SYNC and the telegrams are");
  timing->group(kLookingVerbs);
  auto texts = std::make_shared<TimingTexts>();
  timing
      ->add_option("--seconds", texts->seconds,
                   "gather for 1..3600 seconds and tell of these alone (default: starts of the last second, "
                   "counts since the daemon started)")
      ->type_name("N");
  timing->add_flag("--follow", texts->follow, "again and again until Ctrl-C");
  timing
      ->add_option("--svg", texts->svg,
                   "also draw the interval as a diagram into FILE; other contents of it are kept as FILE.1")
      ->type_name("FILE");
  timing->footer(
      "First the lateness of the realtime thread's wake-up for SYNC: for each class its upper bound, how "
      "many\n"
      "wake-ups, their share, and a bar; then p50, p90, p99 and max, the bounds under which 50, 90, 99 and "
      "100 %\n"
      "lie. Then one line for each slot, starts in us after SYNC; \"instants by\" names the source of the "
      "time\n"
      "stamps. The last line has the share of time the bus is in use, SYNC edges that were skipped, and the\n"
      "intervals that were counted.\n" +
      columns_help(slot_columns()));
  timing->callback(
      [texts, &chosen] { chosen = [texts](Session& session) { return timing_verb(session, *texts); }; });
}

}  // namespace cansync::cli
