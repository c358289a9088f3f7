#include "cli/scan/heard_line.h"

#include <fmt/format.h>

#include <memory>
#include <stdexcept>
#include <utility>

#include "can/adapter/adapters.h"
#include "can/adapter/link_remedy.h"
#include "can/link_kernel.h"
#include "cli/base/afterwards.h"
#include "cli/base/child_process.h"
#include "cli/base/interrupt.h"
#include "cli/base/person.h"
#include "cli/learn/learn_files.h"
#include "cli/scan/rate_trials.h"
#include "cli/text/values.h"
#include "cli/trace/trace_source.h"

namespace cansync::cli {
namespace {

/// Even at 125 kbit/s every slave of a full line has been asked some ten times by then.
constexpr std::chrono::seconds kListeningTime{3};

constexpr std::chrono::seconds kTrialTime{2};  ///< at each bit rate

class CensusSink final : public RecordingSink {
 public:
  void begin(observe::Stamps /*stamps*/, std::optional<BitRate> /*bit_rate*/) override {}
  void edge(Duration at, const can::Frame* frame) override { taker_.sync(at, frame); }
  void frame(Duration at, const can::Frame& frame) override { taker_.frame(at, frame); }
  void begin_anew() override { taker_.begin_anew(); }
  observe::Census census(std::optional<BitRate> bit_rate = std::nullopt) const {
    return taker_.census(bit_rate);
  }

 private:
  observe::CensusTaker taker_;
};

/// Says why nothing can be heard, with the remedy.
void expect_link_up(const std::string& name, const can::LinkFacts& link) {
  if (!link.present || link.up) return;
  const std::string remedy = can::link_remedy(name, link);
  // Only an adapter has a bit rate to be set and to be tried.
  if (remedy.find(" type can ") == std::string::npos)
    throw std::runtime_error(fmt::format("{} is down: nothing can be received. Remedy: {}", name, remedy));
  throw std::runtime_error(fmt::format(
      "{0} is down: nothing can be received. With its bit rate known: `ip link set {0} up type can bitrate 500000 "
      "listen-only on`; not known: `cansync scan {0} --try-rates` tries the four in turn",
      name));
}

void look_at_interface(const std::string& name, HeardLine& line) {
  line.link = can::make_link_kernel()->read(name);
  line.pin = can::pin_of(name, can::adapters_there());
}

/// What was typed, or the interface is set to.
void choose_rate(HeardLine& line, std::optional<BitRate> typed) {
  std::optional<SlotTimes> set;
  for (const SlotTimes& times : kSlotTimes)
    if (line.link.timing && can::keeps_bit_rate(*line.link.timing, times.bits_per_second)) set = times;
  if (typed) {
    line.bit_rate = typed;
    line.rate_source = RateSource::typed;
  } else if (set) {
    line.bit_rate = set->bit_rate;
    line.rate_source = RateSource::interface;
  }
}

}  // namespace

HeardLine hear_line(Output& output, const RecordingTexts& texts) {
  HeardLine line;
  const std::optional<BitRate> typed = given_bit_rate(texts.bit_rate);
  line.live = !is_trace_file(texts.source);
  if (line.live) {
    look_at_interface(texts.source, line);
    expect_link_up(texts.source, line.link);
  }
  CensusSink sink;
  const RecordingEnd end = read_recording(output, texts, sink, {kListeningTime});
  line.interface = line.live ? texts.source : usable_interface(end.interface);
  line.problems = end.problems;
  choose_rate(line, typed);
  line.census = sink.census(line.bit_rate);
  const auto& found = line.census;
  if (!line.bit_rate && found.interval.votes > 0 && found.evidence.kind() == observe::LineKind::cansync) {
    line.bit_rate = found.interval.bit_rate;
    line.rate_source = RateSource::interval;
    line.census = sink.census(line.bit_rate);
  }
  return line;
}

std::optional<HeardLine> hear_line_at_all_rates(Output& output, const RecordingTexts& texts, bool agreed) {
  HeardLine line;
  line.interface = texts.source;
  line.live = !is_trace_file(texts.source);
  if (line.live) look_at_interface(texts.source, line);
  if (!line.live || std::string_view(line.link.driver_kind.data()) != "can")
    throw UsageError(
        fmt::format("--try-rates: found '{}'; allowed: a CAN interface with a controller", texts.source));
  const std::string what = fmt::format(
      "{} is up. It is taken down, and set to four bit rates one after the other; who uses it loses the line meanwhile.",
      texts.source);
  if (line.link.up && !agreed && !person_agrees(what)) return std::nullopt;
  const RateTools tools{[](std::vector<std::string> words) {
                          words.insert(words.begin(), "ip");
                          return run_child(words, "");
                        },
                        [&] {
                          CensusSink sink;
                          read_recording(output, texts, sink, {kTrialTime});
                          return sink.census();
                        },
                        [] { return interrupt_flag().load(); },
                        [](std::vector<std::vector<std::string>> commands) {
                          for (auto& words : commands) words.insert(words.begin(), "ip");
                          return std::make_shared<Afterwards>(commands);
                        }};
  const auto trials = try_rates(texts.source, line.link, tools);
  if (const RateTrial* heard = heard_trial(trials)) {
    line.census = heard->census;
    line.bit_rate = heard->bit_rate;
    line.rate_source = RateSource::tried;
  }
  return line;
}

std::string identifier_text(std::uint32_t identifier, bool extended) {
  return extended ? fmt::format("0x{:08X}", identifier) : fmt::format("0x{:03X}", identifier);
}

}  // namespace cansync::cli
