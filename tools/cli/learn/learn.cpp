#include <fmt/format.h>

#include <memory>
#include <optional>
#include <stdexcept>

#include "cansync/observe/observer.h"
#include "cli/base/interrupt.h"
#include "cli/base/verb_groups.h"
#include "cli/cansync/trace_text.h"
#include "cli/learn/evidence_text.h"
#include "cli/learn/learn_compare.h"
#include "cli/learn/learn_files.h"
#include "cli/learn/learn_points.h"
#include "cli/learn/learn_report.h"
#include "cli/learn/recording.h"
#include "cli/learn/verbs.h"
#include "cli/text/column_help.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

struct LearnTexts {
  RecordingTexts recording;
  std::string write;
  std::string compare;
  bool steps = false;
};

void write_all_files(Session& session, const LearnTexts& texts, const RecordingEnd& end,
                     const observe::Observation& observation, const observe::Learned& learned) {
  if (!learned.bit_rate.known())
    throw UsageError("--write: the recording does not tell the bit rate; --bit-rate gives it");
  LearnedPlace place;
  place.source = texts.recording.source;
  place.interface = usable_interface(end.interface);
  place.bus = place.interface;
  const auto files = learned_files(observation, learned, place);
  write_learned_files(texts.write, files);
  session.output().remark(fmt::format("{} written below {}; next: cansyncd --check {}/{}",
                                      text::counted(files.size(), "file"), texts.write, texts.write,
                                      files.front().path));
}

ExitCode learn_verb(Session& session, const LearnTexts& texts) {
  Output& output = session.output();
  session.expect_input(texts.recording.source);
  // What is wrong with the configuration is said before anything is listened to.
  std::optional<MasterSettings> configured;
  if (!texts.compare.empty()) configured = settings_of_file(texts.compare);
  const auto [end, observation] = observe_recording(output, texts.recording);
  const observe::Learned learned = observe::learn(observation);
  const std::uint64_t received = observation.frames + observation.evidence.frames;
  if (received == 0)
    throw std::runtime_error(fmt::format("{}: no frame at all was found", texts.recording.source));
  if (is_other_protocol(observation.evidence, received)) {
    output.remark(other_protocol_text(observation.evidence));
    write_other_protocol(output, observation, learned);
    return ExitCode::not_cansync;
  }
  remark_on_stamps(output, observation.stamps);
  if (!texts.write.empty()) write_all_files(session, texts, end, observation, learned);
  if (configured) {
    const auto differences = learned_differences(*configured, learned);
    write_differences(output, differences, texts.compare);
    if (!differences.empty()) return ExitCode::different;
  } else {
    write_learn_report(output, observation, learned, {texts.steps});
  }
  return end.problems == 0 ? ExitCode::done : ExitCode::in_part;
}

}  // namespace

void add_learn_verb(CLI::App& app, Verb& chosen) {
  auto* learn = app.add_subcommand("learn", "what a recorded master does, as a report and a configuration");
  learn->group(kLookingVerbs);
  auto texts = std::make_shared<LearnTexts>();
  add_recording_options(*learn, texts->recording, "until Ctrl-C");
  learn
      ->add_option(
          "--write", texts->write,
          "write a configuration, a batch of the start-up, profile drafts and passports into this folder; "
          "nothing there is written over")
      ->type_name("FOLDER");
  learn
      ->add_option("--compare", texts->compare,
                   "say instead where this configuration of cansyncd differs from the recorded master")
      ->type_name("CONFIG");
  learn->add_flag("--steps", texts->steps, "every step of the master; the default is the first 20");
  learn->footer(
      "No daemon is needed, and nothing is sent. Exit code 9: --compare found a difference; 11: a file "
      "was read in part; 12: the frames do not look like CANsync, and nothing is written.\n"
      "Examples:\n"
      "  candump -L can0 > old.log; cansync learn old.log --write learned\n"
      "  cansync learn old.log --compare /etc/cansync/can0.toml\n" +
      columns_help(learned_columns()) + "\n\n" + report_tables_help() + "\n\n" + compare_table_help());
  learn->callback(
      [texts, &chosen] { chosen = [texts](Session& session) { return learn_verb(session, *texts); }; });
}

}  // namespace cansync::cli
