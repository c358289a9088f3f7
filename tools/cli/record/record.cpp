#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <variant>
#include <vector>

#include "cli/base/files.h"
#include "cli/base/interrupt.h"
#include "cli/base/restarts.h"
#include "cli/base/verb_groups.h"
#include "cli/record/record_file.h"
#include "cli/record/record_time.h"
#include "cli/record/recording.h"
#include "cli/record/verbs.h"
#include "cli/text/column_help.h"
#include "cli/text/progress.h"
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
  std::string size;   ///< of a file; empty: no bound
  std::string older;  ///< how many full files are kept; empty: none
  bool raw = false;
  bool force = false;
};

/// Values, and what they are, in the order they came, on their way from the client's thread to this one; what finds no
/// room is counted.
class Samples {
 public:
  using Status = std::shared_ptr<const client::SlaveStatus>;
  using Sample = std::variant<client::ActualValues, Status>;

  explicit Samples(client::Client& client)
      : statuses_(client.on_slave_status([this](const client::SlaveStatus& status) { note(status); })),
        values_(client.on_actual_values([this](const client::ActualValues& sample) { (void)put(sample); })) {}

  std::vector<Sample> take_all() {
    const std::lock_guard lock(mutex_);
    return std::exchange(waiting_, {});
  }
  std::uint64_t dropped() {
    const std::lock_guard lock(mutex_);
    return dropped_;
  }

 private:
  /// Statuses come all the time: one that says the same of the values is of no use.
  void note(const client::SlaveStatus& status) {
    Status& last = last_[status.slave];
    if (last && same_values(*last, status)) return;
    Status now = std::make_shared<const client::SlaveStatus>(status);
    if (put(now)) last = std::move(now);
  }
  /// False: there is no room.
  bool put(Sample sample) {
    const std::lock_guard lock(mutex_);
    if (waiting_.size() == kMostWaiting) {
      ++dropped_;
      return false;
    }
    waiting_.push_back(std::move(sample));
    return true;
  }

  std::mutex mutex_;
  std::vector<Sample> waiting_;
  std::uint64_t dropped_ = 0;
  std::map<unsigned, Status> last_;  ///< client's thread
  client::Subscription statuses_;    // both end before what their callbacks need
  client::Subscription values_;
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
  std::string_view ended;  ///< duration, full, signal or daemon_gone
};

/// What is recorded, and how.
struct Recording {
  RecordPlan& plan;
  std::uint32_t slaves;  ///< that are wanted, also those that come later
  std::uint64_t every;
  double duration;  ///< s
};

/// Takes what has come; what a reload of the daemon has changed is said.
void take(const std::vector<Samples::Sample>& samples, std::uint32_t wanted, RecordRows& rows,
          const std::function<void(const std::string&)>& say) {
  for (const Samples::Sample& sample : samples) {
    if (const auto* values = std::get_if<client::ActualValues>(&sample)) {
      rows.take(*values);
    } else if (const auto& status = *std::get<Samples::Status>(sample);
               ((wanted >> status.slave) & 1u) != 0) {
      for (const std::string& change : rows.update(status, wall_clock())) say(change);
    }
  }
}

Recorded record(Session& session, const Recording& recording, RecordFile& file) {
  client::Client& client = session.client();
  Recorded recorded;
  RecordRows rows(recording.plan, recording.every);
  RecordProgress progress;
  RecordTime time(std::chrono::duration<double>(recording.duration), Clock::now());
  Samples samples(client);
  Restarts restarts(client);
  const auto say = [&](const std::string& remark) {
    progress.clear();
    session.output().remark(remark);
  };
  while (recorded.ended.empty()) {
    const auto left = std::chrono::ceil<Clock::duration>(time.left(Clock::now()));
    if (wait_until(Clock::now() + std::min<Clock::duration>(kWritingPeriod, left)))
      recorded.ended = "signal";
    else if (time.left(Clock::now()).count() <= 0)
      recorded.ended = "duration";
    else if (restarts.gone() || !client.several_daemons().empty())
      recorded.ended = "daemon_gone";
    const bool anew = restarts.take();
    if (const auto status = client.master_status(std::chrono::milliseconds(0))) rows.set_polling(*status);
    // Samples of the start before may be among them.
    take(samples.take_all(), recording.slaves, rows, say);
    if (anew) {
      say(std::string(kStartedAnew));
      rows.restarted(wall_clock());
    }
    if (!file.write(rows.lines(!recorded.ended.empty()))) recorded.ended = "full";
    if (rows.counts().rows > 0) time.rows_are_there(Clock::now());
    progress.update(time.seconds(Clock::now()), rows.counts());
  }
  recorded.counts = rows.counts();
  recorded.dropped = samples.dropped();
  recorded.seconds = time.seconds(Clock::now());
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
    session.output().remark(
        fmt::format("{} in {:.1f} s, {} missing{}", text::counted(recorded.counts.rows, "row"),
                    recorded.seconds, text::counted(recorded.counts.missing, "turn"),
                    recorded.dropped > 0
                        ? fmt::format(", {} dropped", text::counted(recorded.dropped, "sample"))
                        : "") +
        (recorded.ended == "full" ? "; the file has the size of --max-size" : ""));
  }
  if (recorded.ended != "daemon_gone") return ExitCode::done;
  const std::string several = session.client().several_daemons();
  session.output().remark(several.empty() ? "the daemon has gone (" + session.client().place() +
                                                "); the recording ends here"
                                          : several + "; the recording ends here");
  return ExitCode::not_reachable;
}

RecordBounds parse_bounds(const RecordTexts& texts) {
  constexpr std::int64_t kMostFiles = 999;
  RecordBounds bounds;
  if (!texts.size.empty()) bounds.bytes = parse_size(texts.size, "--max-size");
  if (!texts.older.empty())
    bounds.older = static_cast<unsigned>(parse_integer(texts.older, "--rotate", 1, kMostFiles));
  if (bounds.older != 0 && texts.file == "-")
    throw UsageError("--rotate: found with FILE '-'; allowed: with a file, whose older ones get a number");
  return bounds;
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
  const RecordBounds bounds = parse_bounds(texts);
  const std::uint32_t wanted = session.configured_slaves(texts.slaves);
  client::Client& client = session.client();
  std::vector<client::SlaveStatus> slaves = client.slaves();
  std::erase_if(slaves,
                [wanted](const client::SlaveStatus& slave) { return ((wanted >> slave.slave) & 1u) == 0; });
  RecordPlan plan(slaves, texts.values, texts.raw);
  expect_new_files(texts.file, bounds, texts.force);
  RecordFile file(texts.file, plan.header(), bounds);
  const Recording recording{plan, texts.slaves.empty() ? ~std::uint32_t{0} : wanted, every, duration};
  return tell(session, texts, plan, record(session, recording, file));
}

}  // namespace

void add_record_verb(CLI::App& app, Verb& chosen) {
  auto* verb = app.add_subcommand("record", "the actual values of the slaves as a CSV file");
  verb->group(kLookingVerbs);
  auto texts = std::make_shared<RecordTexts>();
  verb->add_option("FILE", texts->file, "- = standard output")->required();
  verb->add_option("SLAVE", texts->slaves, "numbers or names (default: every configured slave)");
  verb->add_option("--values", texts->values,
                   "these alone, by name or number, with commas (default: all that are mapped)")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("NAMES");
  verb->add_option("--every", texts->every, "each Nth row of a slave, 1..1000000 (default 1)")
      ->type_name("N");
  verb->add_option("--duration", texts->duration, "how long, from the first row on (default: until Ctrl-C)")
      ->type_name("SECONDS");
  auto* size = verb->add_option("--max-size", texts->size,
                                "end when the file has so many bytes, such as 64K, 100M or 2G, from 4096 on")
                   ->type_name("SIZE");
  verb->add_option("--rotate", texts->older,
                   "go on in a new file instead, and keep N older ones as FILE.1 to FILE.N, 1..999")
      ->type_name("N")
      ->needs(size);
  verb->add_flag("--force", texts->force,
                 "replace FILE, and FILE.1 to FILE.N of --rotate, when they are there already");
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
