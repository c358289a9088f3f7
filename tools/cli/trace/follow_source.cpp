#include "cli/trace/follow_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <variant>

#include "cli/base/interrupt.h"
#include "cli/text/progress.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

using Clock = std::chrono::steady_clock;

/// Places that were left out, and comments of a log, are shown up to this many times, then only counted.
constexpr std::uint64_t kMostNamed = 10;
constexpr auto kFlushEvery = std::chrono::milliseconds(100);
/// The clock of a file, which comes as fast as it is read, is read once in so many frames.
constexpr unsigned kFramesPerLook = 64;
constexpr std::uint64_t kLongFile = std::uint64_t{32} << 20;

class Follower {
 public:
  Follower(TraceSource& source, Output& output, const SourceUse& use)
      : source_(source),
        output_(output),
        use_(use),
        shows_progress_(source.progress().total >= kLongFile && !output.data_on_terminal()),
        frames_per_look_(source.progress().total != 0 ? kFramesPerLook : 1),
        bar_(stderr) {}

  ExitCode run() {
    while (!interrupt_flag().load() && !use_.enough()) {
      const TraceItem item = source_.next();
      if (const auto* line = std::get_if<can::CandumpLine>(&item)) {
        ++frames_;
        use_.frame(*line);
        if (frames_ % frames_per_look_ == 0) look();
      } else if (const auto* problem = std::get_if<TraceProblem>(&item)) {
        ++problems_;
        show(problem->text, problems_, "more of these are only counted");
      } else if (const auto* remark = std::get_if<TraceRemark>(&item)) {
        ++remarks_;
        show(remark->text, remarks_, "");
      } else if (std::holds_alternative<TraceEnd>(item)) {
        break;
      } else {
        use_.flush();
      }
    }
    use_.flush();
    bar_.clear();
    return end();
  }

 private:
  void show(const std::string& text, std::uint64_t number, std::string_view last) {
    // With --json everything that reads the remarks is a program.
    if (!output_.json() && number > kMostNamed) return;
    bar_.clear();
    output_.remark(text);
    if (!output_.json() && number == kMostNamed && !last.empty()) output_.remark(last);
  }

  void look() {
    const Clock::time_point now = Clock::now();
    if (now - looked_ < kFlushEvery) return;
    looked_ = now;
    use_.flush();
    const TraceProgress progress = source_.progress();
    if (shows_progress_) bar_.update(progress.done, progress.total);
  }

  ExitCode end() {
    if (source_.dropped() > 0)
      output_.remark(fmt::format("{} dropped by the kernel: this program was too slow",
                                 text::counted(source_.dropped(), "frame was", "frames were")));
    if (problems_ == 0) return ExitCode::done;
    output_.remark(
        fmt::format("{} {} not understood", problems_, problems_ == 1 ? "line was" : "lines were"));
    return frames_ > 0 ? ExitCode::in_part : ExitCode::failed;
  }

  TraceSource& source_;
  Output& output_;
  const SourceUse& use_;
  bool shows_progress_;
  unsigned frames_per_look_;
  ProgressBar bar_;
  Clock::time_point looked_ = Clock::now();
  std::uint64_t frames_ = 0;
  std::uint64_t problems_ = 0;
  std::uint64_t remarks_ = 0;
};

}  // namespace

ExitCode follow_source(TraceSource& source, Output& output, const SourceUse& use) {
  try {
    return Follower(source, output, use).run();
  } catch (...) {
    use.flush();
    throw;
  }
}

std::optional<std::uint32_t> RecordedInterfaces::take(const std::string& name) {
  if (name == last_ && !name.empty()) {
    if (!last_number_ && only_.empty()) ++left_out_;
    return last_number_;
  }
  last_ = name;
  last_number_ = std::nullopt;
  auto found = numbers_.find(name);
  if (found == numbers_.end() && numbers_.size() < kMost)
    found = numbers_.emplace(name, static_cast<std::uint32_t>(numbers_.size())).first;
  if (found == numbers_.end()) {
    ++left_out_;
  } else if (only_.empty() || name == only_) {
    last_number_ = found->second;
  }
  return last_number_;
}

ExitCode RecordedInterfaces::end(Output& output) const {
  constexpr std::size_t kMostListed = 8;
  std::string names;
  std::size_t listed = 0;
  for (const auto& [name, number] : numbers_)
    if (listed++ < kMostListed) names += (names.empty() ? "" : ", ") + name;
  if (numbers_.size() > kMostListed) names += " and others";
  if (only_.empty() && numbers_.size() > 1)
    output.remark(fmt::format("the recording has frames of {}: {}; --only-interface NAME shows one alone",
                              text::counted(numbers_.size(), "interface"), names));
  if (!only_.empty() && numbers_.find(only_) == numbers_.end())
    output.remark(fmt::format("--only-interface: the recording has no frame of '{}'; found: {}", only_,
                              names.empty() ? "no frame" : names));
  if (left_out_ == 0) return ExitCode::done;
  output.remark(fmt::format("{} of more than {} interfaces left out",
                            text::counted(left_out_, "frame was", "frames were"), kMost));
  return ExitCode::in_part;
}

}  // namespace cansync::cli
