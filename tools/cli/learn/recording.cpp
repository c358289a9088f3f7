#include "cli/learn/recording.h"

#include <fmt/format.h>

#include <chrono>
#include <optional>
#include <vector>

#include "cansync/observe/observer.h"
#include "cli/base/interrupt.h"
#include "cli/cansync/sync_identifier.h"
#include "cli/cansync/trace_text.h"
#include "cli/text/values.h"
#include "cli/trace/trace_source.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

using ListeningClock = std::chrono::steady_clock;

/// Lines that are no frames are named up to this many times, then only counted.
constexpr std::uint64_t kMostProblemsNamed = 10;
/// Time stamps that go back by more were not made by one clock that runs; by less frames of several interfaces do.
constexpr std::chrono::microseconds kMostBack = std::chrono::milliseconds(1);
/// A file in which nothing stands for so long is not one recording of a line that runs.
constexpr std::chrono::microseconds kLongestPause = std::chrono::seconds(2);
/// Lines that are looked at to see which kind of log it is.
constexpr std::size_t kLinesLookedAt = 256;
/// Nanoseconds of a later one would not fit 64 bits.
constexpr std::chrono::microseconds kLatestStamp = std::chrono::hours(24) * 365 * 140;
/// The simulated line writes SYNC edges as frames of an interface of this name, and the start of frames.
constexpr std::string_view kSyncInterface = "sync";

/// What `learn` makes of a recording.
class ObserverSink final : public RecordingSink {
 public:
  void begin(observe::Stamps stamps, std::optional<BitRate> bit_rate) override {
    observer_.emplace(observe::ObserverSettings{stamps, bit_rate});
  }
  void edge(Duration at, const can::Frame* frame) override { observer_->sync(at, frame); }
  void frame(Duration at, const can::Frame& frame) override { observer_->frame(at, frame); }
  void begin_anew() override { observer_->begin_anew(); }
  observe::Observation finish() { return observer_->finish(); }

 private:
  std::optional<observe::Observer> observer_;
};

/// Puts the lines of a recording into a sink.
class RecordingReader {
 public:
  RecordingReader(Output& output, const RecordingTexts& texts, RecordingSink& sink)
      : output_(output),
        texts_(texts),
        sink_(sink),
        sync_(parse_sync_identifier(texts.sync, output)),
        bit_rate_(given_bit_rate(texts.bit_rate)) {
    if (!texts.stamps.empty() && texts.stamps != "start" && texts.stamps != "end")
      throw UsageError(fmt::format("--stamps: found '{}'; allowed: start or end", texts.stamps));
  }

  std::uint32_t sync() const noexcept { return sync_; }

  /// `place`: where it is in a file; empty: it comes from an interface.
  void take(can::CandumpLine line, const std::string& place) {
    if (!wanted(line)) return;
    const bool anew = to_one_time(line, place);
    if (begun_) return hand_over(line, anew);
    first_.push_back({std::move(line), anew});
    if (first_.size() >= kLinesLookedAt) begin();
  }

  void problem(const TraceProblem& problem) {
    ++end_.problems;
    if (end_.problems <= kMostProblemsNamed) output_.remark(problem.text);
    if (end_.problems == kMostProblemsNamed) output_.remark("more of these are only counted");
  }

  RecordingEnd end(std::uint64_t dropped) {
    if (!begun_) begin();
    if (end_.interface.empty() && !other_interface_.empty())
      throw UsageError(fmt::format("--from: found '{}'; allowed: an interface of {}, such as {}", texts_.from,
                                   texts_.source, other_interface_));
    if (end_.breaks > kMostProblemsNamed)
      output_.remark(fmt::format("time begins anew {}", text::counted(end_.breaks, "time")));
    end_.dropped = dropped;
    if (dropped > 0)
      output_.remark(fmt::format("{} dropped by the kernel and are missing here",
                                 text::counted(dropped, "frame was", "frames were")));
    return std::move(end_);
  }

 private:
  void begin() {
    bool starts = texts_.stamps == "start";
    if (texts_.stamps.empty())
      for (const First& first : first_) starts = starts || first.line.interface == kSyncInterface;
    begun_ = true;
    sink_.begin(starts ? observe::Stamps::start : observe::Stamps::end, bit_rate_);
    for (const First& first : first_) hand_over(first.line, first.anew);
    first_ = {};
  }

  bool is_edge(const can::CandumpLine& line) const noexcept {
    return line.frame.is_standard_data() && line.frame.id == sync_;
  }

  /// Is the frame of the line that is looked at? Throws UsageError when it is not said which that is.
  bool wanted(const can::CandumpLine& line) {
    if (line.time < std::chrono::microseconds(0) || line.time > kLatestStamp) {
      problem({fmt::format("a time stamp of {} s is no time", line.time.count() / 1'000'000)});
      return false;
    }
    if (line.interface == kSyncInterface) return is_edge(line);
    if (!texts_.from.empty() && line.interface != texts_.from) {
      other_interface_ = line.interface;
      return false;
    }
    if (end_.interface.empty()) end_.interface = line.interface;
    if (line.interface != end_.interface)
      throw UsageError(fmt::format("{}: found frames of the interfaces {} and {}; name one with --from",
                                   texts_.source, end_.interface, line.interface));
    return true;
  }

  /// Puts the line's time behind those before it. True: it has no relation to them, for the clock was set back or
  /// the recording has a gap; both are said.
  bool to_one_time(can::CandumpLine& line, const std::string& place) {
    const std::chrono::microseconds stamp = line.time;
    bool anew = false;
    if (newest_) {
      const auto step = stamp - *newest_;
      anew = step < -kMostBack || (!place.empty() && step > kLongestPause);
      if (anew) {
        ++end_.breaks;
        shift_ -= step;
        tell_break(step, place);
      }
    }
    newest_ = anew || !newest_ ? stamp : std::max(*newest_, stamp);
    line.time = stamp + shift_;
    return anew;
  }

  void tell_break(std::chrono::microseconds step, const std::string& place) {
    if (end_.breaks > kMostProblemsNamed) return;
    const std::string where = place.empty() ? texts_.source : place;
    const auto length = text::duration_text(step < std::chrono::microseconds(0) ? -step : step);
    output_.remark(
        step < std::chrono::microseconds(0)
            ? fmt::format("{}: the clock goes back by {}; nothing is derived across this place", where,
                          length)
            : fmt::format("{}: no frame for {}; nothing is derived across this gap", where, length));
    if (end_.breaks == kMostProblemsNamed) output_.remark("more of these are only counted");
  }

  void hand_over(const can::CandumpLine& line, bool anew) {
    if (anew) sink_.begin_anew();
    if (is_edge(line))
      sink_.edge(line.time, line.interface == kSyncInterface ? nullptr : &line.frame);
    else
      sink_.frame(line.time, line.frame);
  }

  Output& output_;
  const RecordingTexts& texts_;
  RecordingSink& sink_;
  std::uint32_t sync_;
  std::optional<BitRate> bit_rate_;
  struct First {
    can::CandumpLine line;
    bool anew;
  };
  std::vector<First> first_;
  std::optional<std::chrono::microseconds> newest_;  ///< stamp, as the recording has it
  std::chrono::microseconds shift_{0};               ///< from stamps to a time that does not go back
  bool begun_ = false;
  RecordingEnd end_;
  std::string other_interface_;  ///< whose frames are not looked at
};

}  // namespace

std::optional<BitRate> given_bit_rate(const std::string& text) {
  if (text.empty()) return std::nullopt;
  const auto rate = parse_integer(text, "--bit-rate", 0, 1'000'000);
  const auto times = slot_times_for(static_cast<std::uint32_t>(rate));
  if (!times)
    throw UsageError(fmt::format("--bit-rate: found '{}'; allowed: 125000, 250000, 500000 or 1000000", text));
  return times->bit_rate;
}

void add_recording_options(CLI::App& verb, RecordingTexts& texts, std::string_view seconds_default) {
  verb.add_option(
          "SOURCE", texts.source,
          "a candump text log (candump -L, or the trace of the simulated line) or a pcapng capture, - for "
          "standard input, or a SocketCAN interface, which is only listened to")
      ->required();
  verb.add_option("--seconds", texts.seconds,
                  fmt::format("of an interface: listen for so long, 1..86400 (default: {})", seconds_default))
      ->type_name("N");
  verb.add_option("--from", texts.from, "of a log of several interfaces: the one to look at")
      ->type_name("NAME");
  verb.add_option("--sync", texts.sync,
                  "identifier of the frame that marks SYNC, hexadecimal, 000..7FF (default 080)")
      ->type_name("ID");
  verb.add_option("--bit-rate", texts.bit_rate,
                  "of the line, when the recording is too short to tell its interval")
      ->type_name("RATE");
  verb.add_option("--stamps", texts.stamps,
                  "what time stamps tell of a frame: its start or end (default: end; start for traces of the "
                  "simulated line)")
      ->type_name("start|end");
}

RecordingEnd read_recording(Output& output, const RecordingTexts& texts, RecordingSink& sink,
                            const Listening& listening) {
  RecordingReader reader(output, texts, sink);
  const auto source = open_trace_source(texts.source, reader.sync(), HeardFrames::all);
  std::chrono::seconds seconds = source->endless() ? listening.seconds : kWithoutEnd;
  if (!texts.seconds.empty())
    seconds = std::chrono::seconds(parse_integer(texts.seconds, "--seconds", 1, 86400));
  const auto begin = ListeningClock::now();
  if (source->endless() && seconds == kWithoutEnd)
    output.remark(fmt::format("listening to {}; Ctrl-C ends it", texts.source));
  while (!interrupt_flag().load()) {
    if (seconds != kWithoutEnd && ListeningClock::now() - begin >= seconds) break;
    const TraceItem item = source->next();
    if (std::holds_alternative<TraceEnd>(item)) break;
    if (const auto* line = std::get_if<can::CandumpLine>(&item)) reader.take(*line, source->place());
    if (const auto* problem = std::get_if<TraceProblem>(&item)) reader.problem(*problem);
    if (const auto* remark = std::get_if<TraceRemark>(&item)) output.remark(remark->text);
  }
  return reader.end(source->dropped());
}

ObservedRecording observe_recording(Output& output, const RecordingTexts& texts) {
  ObserverSink sink;
  RecordingEnd end = read_recording(output, texts, sink, {});
  return {std::move(end), sink.finish()};
}

}  // namespace cansync::cli
