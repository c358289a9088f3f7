#include "cli/learn/recording.h"

#include <fmt/format.h>

#include <chrono>
#include <optional>
#include <vector>

#include "cansync/observe/observer.h"
#include "cli/base/interrupt.h"
#include "cli/cansync/trace_text.h"
#include "cli/text/values.h"
#include "cli/trace/trace_source.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

using ListeningClock = std::chrono::steady_clock;

/// Lines that are no frames are named up to this many times, then only counted.
constexpr std::uint64_t kMostProblemsNamed = 10;
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
  void edge(Duration at, const can::Frame* /*frame*/) override { observer_->sync(at); }
  void frame(Duration at, const can::Frame& frame) override { observer_->frame(at, frame); }
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
        sync_(texts.sync.empty() ? kSyncIdentifier
                                 : static_cast<std::uint32_t>(parse_integer(texts.sync, "--sync", 0, 0x7FF))),
        bit_rate_(given_bit_rate(texts.bit_rate)) {
    if (!texts.stamps.empty() && texts.stamps != "start" && texts.stamps != "end")
      throw UsageError(fmt::format("--stamps: found '{}'; allowed: start or end", texts.stamps));
  }

  std::uint32_t sync() const noexcept { return sync_; }

  void take(const can::CandumpLine& line) {
    if (begun_) return hand_over(line);
    first_.push_back(line);
    if (first_.size() >= kLinesLookedAt) begin();
  }

  void problem(const TraceProblem& problem) {
    ++end_.problems;
    if (end_.problems <= kMostProblemsNamed) output_.remark(problem.text);
    if (end_.problems == kMostProblemsNamed) output_.remark("more of these are only counted");
  }

  RecordingEnd end(std::uint64_t dropped) {
    if (!begun_) begin();
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
      for (const can::CandumpLine& line : first_) starts = starts || line.interface == kSyncInterface;
    begun_ = true;
    sink_.begin(starts ? observe::Stamps::start : observe::Stamps::end, bit_rate_);
    for (const can::CandumpLine& line : first_) hand_over(line);
    first_ = {};
  }

  void hand_over(const can::CandumpLine& line) {
    if (line.time < std::chrono::microseconds(0) || line.time > kLatestStamp)
      return problem({fmt::format("a time stamp of {} s is no time", line.time.count() / 1'000'000)});
    const bool edge = line.frame.is_standard_data() && line.frame.id == sync_;
    if (line.interface == kSyncInterface || edge) {
      if (edge) sink_.edge(line.time, line.interface == kSyncInterface ? nullptr : &line.frame);
      return;
    }
    if (!texts_.from.empty() && line.interface != texts_.from) return;
    if (end_.interface.empty()) end_.interface = line.interface;
    if (line.interface != end_.interface)
      throw UsageError(fmt::format("{}: found frames of the interfaces {} and {}; name one with --from",
                                   texts_.source, end_.interface, line.interface));
    sink_.frame(line.time, line.frame);
  }

  Output& output_;
  const RecordingTexts& texts_;
  RecordingSink& sink_;
  std::uint32_t sync_;
  std::optional<BitRate> bit_rate_;
  std::vector<can::CandumpLine> first_;
  bool begun_ = false;
  RecordingEnd end_;
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
  verb.add_option("--sync", texts.sync, "identifier of the frame that marks SYNC, 0..0x7FF (default 0x080)")
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
  const auto source = open_trace_source(texts.source, reader.sync(), listening.frames);
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
    if (const auto* line = std::get_if<can::CandumpLine>(&item)) reader.take(*line);
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
