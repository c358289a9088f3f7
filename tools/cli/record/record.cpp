#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <mutex>
#include <system_error>

#include "cli/base/files.h"
#include "cli/base/interrupt.h"
#include "cli/base/restarts.h"
#include "cli/base/verb_groups.h"
#include "cli/record/recording.h"
#include "cli/record/verbs.h"
#include "cli/text/column_help.h"
#include "cli/text/progress.h"
#include "system/descriptor.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

using Clock = std::chrono::steady_clock;
constexpr auto kWritingPeriod = std::chrono::milliseconds(100);  // from one writing to the next
constexpr std::size_t kMostWaiting = 65536;                      // samples; 32 slaves fill that in some 30 s

/// The arguments as they were typed.
struct RecordTexts {
  std::string file;
  std::vector<std::string> slaves;
  std::vector<std::string> values;
  std::string every = "1";
  std::string duration;
  bool raw = false;
};

/// Samples on their way from the client's thread to this one; one for which there is no room is counted.
class Samples {
 public:
  explicit Samples(client::Client& client)
      : subscription_(client.on_actual_values([this](const client::ActualValues& sample) {
          const std::lock_guard lock(mutex_);
          if (waiting_.size() < kMostWaiting)
            waiting_.push_back(sample);
          else
            ++dropped_;
        })) {}

  std::vector<client::ActualValues> take_all() {
    const std::lock_guard lock(mutex_);
    return std::exchange(waiting_, {});
  }
  std::uint64_t dropped() {
    const std::lock_guard lock(mutex_);
    return dropped_;
  }

 private:
  std::mutex mutex_;
  std::vector<client::ActualValues> waiting_;
  std::uint64_t dropped_ = 0;
  client::Subscription subscription_;  // ends before what its callback needs
};

/// The file, written as rows come, so that what is there survives whatever ends this program.
class RecordFile {
 public:
  explicit RecordFile(std::string path) : path_(std::move(path)) {
    if (path_ == "-") return;
    file_.reset(::open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
    if (!file_.is_open()) throw std::system_error(errno, std::generic_category(), path_);
  }

  /// Whole lines.
  void write(std::string_view text) {
    if (file_.is_open())
      write_all(file_.number(), text, path_);
    else
      write_all(STDOUT_FILENO, text, "standard output");
  }

 private:
  std::string path_;
  sys::Descriptor file_;  ///< none: standard output
};

/// How the recording goes, in one line of a terminal that is redrawn; says nothing elsewhere.
class RecordProgress {
 public:
  RecordProgress() : terminal_(::isatty(STDERR_FILENO) == 1) {}
  ~RecordProgress() {
    if (drawn_) static_cast<void>(std::fputs("\r\x1b[K", stderr));
  }
  RecordProgress(const RecordProgress&) = delete;
  RecordProgress& operator=(const RecordProgress&) = delete;

  /// Makes room for a remark.
  void clear() {
    if (std::exchange(drawn_, false)) static_cast<void>(std::fputs("\r\x1b[K", stderr));
  }

  void update(double seconds, const RecordCounts& counts) {
    if (!terminal_) return;
    drawn_ = true;
    const std::string text = fmt::format("{:.1f} s  {}  {} missing  Ctrl-C ends", seconds,
                                         text::counted(counts.rows, "row"), counts.missing);
    static_cast<void>(std::fputs(("\r\x1b[K" + text.substr(0, terminal_width(stderr) - 1)).c_str(), stderr));
    static_cast<void>(std::fflush(stderr));
  }

 private:
  bool terminal_;
  bool drawn_ = false;
};

/// What a recording came to.
struct Recorded {
  RecordCounts counts;
  std::uint64_t dropped = 0;
  double seconds = 0;
  std::string_view ended;  ///< duration, signal or daemon_gone
};

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

Recorded record(Session& session, const RecordPlan& plan, RecordFile& file, std::uint64_t every,
                double duration) {
  client::Client& client = session.client();
  Recorded recorded;
  RecordRows rows(plan, every);
  file.write(plan.header());
  RecordProgress progress;
  const auto start = Clock::now();
  Samples samples(client);
  Restarts restarts(client);
  while (recorded.ended.empty()) {
    const auto left = std::chrono::duration<double>(duration - seconds_since(start));
    const auto next =
        Clock::now() + std::min<Clock::duration>(kWritingPeriod, std::chrono::ceil<Clock::duration>(left));
    if (wait_until(next))
      recorded.ended = "signal";
    else if (seconds_since(start) >= duration)
      recorded.ended = "duration";
    else if (restarts.gone() || !client.several_daemons().empty())
      recorded.ended = "daemon_gone";
    if (restarts.take()) {
      progress.clear();
      session.output().remark(kStartedAnew);
      file.write(rows.restarted(wall_clock()));
    }
    rows.set_polling(client.master_status());
    for (const client::ActualValues& sample : samples.take_all()) rows.take(sample);
    file.write(rows.lines(!recorded.ended.empty()));
    progress.update(seconds_since(start), rows.counts());
  }
  recorded.counts = rows.counts();
  recorded.dropped = samples.dropped();
  recorded.seconds = seconds_since(start);
  return recorded;
}

ExitCode tell(Session& session, const RecordTexts& texts, const RecordPlan& plan, const Recorded& recorded) {
  if (session.json()) {
    JsonArray slaves;
    for (const unsigned slave : plan.slaves()) slaves.add(slave);
    JsonArray values;
    for (const std::string& heading : plan.headings()) values.add(heading);
    session.output().object(JsonObject()
                                .add("file", texts.file)
                                .add("slaves", slaves)
                                .add("values", values)
                                .add("rows", recorded.counts.rows)
                                .add("seconds", recorded.seconds)
                                .add("missing", recorded.counts.missing)
                                .add("dropped", recorded.dropped)
                                .add("ended", recorded.ended));
  } else {
    session.output().remark(fmt::format(
        "{} in {:.1f} s, {} missing{}", text::counted(recorded.counts.rows, "row"), recorded.seconds,
        text::counted(recorded.counts.missing, "turn"),
        recorded.dropped > 0 ? fmt::format(", {} dropped", text::counted(recorded.dropped, "sample")) : ""));
  }
  if (recorded.ended != "daemon_gone") return ExitCode::done;
  const std::string several = session.client().several_daemons();
  session.output().remark(several.empty() ? "the daemon has gone (" + session.client().place() +
                                                "); the recording ends here"
                                          : several + "; the recording ends here");
  return ExitCode::not_reachable;
}

ExitCode record_verb(Session& session, const RecordTexts& texts) {
  session.look_only();
  constexpr double kLongest = 31'536'000;  // a year
  const auto every = static_cast<std::uint64_t>(parse_integer(texts.every, "--every", 1, 1'000'000));
  const double duration = texts.duration.empty() ? kLongest : parse_real(texts.duration, "--duration");
  if (!(duration > 0 && duration <= kLongest))
    throw UsageError(fmt::format("--duration: found '{}'; allowed: over 0 and up to {} seconds",
                                 texts.duration, kLongest));
  if (session.json() && texts.file == "-")
    throw UsageError(
        "--json: found with FILE '-'; allowed: one of them, because both write to standard output");
  const std::uint32_t wanted = session.configured_slaves(texts.slaves);
  client::Client& client = session.client();
  std::vector<client::SlaveStatus> slaves = client.slaves();
  std::erase_if(slaves,
                [wanted](const client::SlaveStatus& slave) { return ((wanted >> slave.slave) & 1u) == 0; });
  const RecordPlan plan(slaves, texts.values, texts.raw);
  RecordFile file(texts.file);
  return tell(session, texts, plan, record(session, plan, file, every, duration));
}

}  // namespace

void add_record_verb(CLI::App& app, Verb& chosen) {
  auto* verb = app.add_subcommand("record", "the actual values of the slaves as a CSV file");
  verb->group(kLookingVerbs);
  auto texts = std::make_shared<RecordTexts>();
  verb->add_option("FILE", texts->file, "is overwritten; - = standard output")->required();
  verb->add_option("SLAVE", texts->slaves, "numbers or names (default: every configured slave)");
  verb->add_option("--values", texts->values,
                   "these alone, by name or number, with commas (default: all that are mapped)")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("NAMES");
  verb->add_option("--every", texts->every, "each Nth row of a slave, 1..1000000 (default 1)")
      ->type_name("N");
  verb->add_option("--duration", texts->duration, "how long (default: until Ctrl-C)")->type_name("SECONDS");
  verb->add_flag("--raw", texts->raw, "numbers as on the bus instead of scaled ones");
  verb->footer(
      "A row holds what came from one slave in one interval. Rows are written as they come: a line with its\n"
      "end is complete, whatever happens to the program. Missing are turns of a slave without a row.\n" +
      explanation("In the file", {{"time", "when the newest telegram of the row was received, UTC"},
                                  {"seconds", "the same, since the first row"},
                                  {"receive_time_ns", "the same, in ns since 1970"},
                                  {"interval", "number of the interval the telegrams belong to"},
                                  {"slave, name", "number and configured name of the slave"},
                                  {"NAME [UNIT]", "a value; empty: not in this row's telegrams"}}));
  verb->callback(
      [texts, &chosen] { chosen = [texts](Session& session) { return record_verb(session, *texts); }; });
}

}  // namespace cansync::cli
