#include "cansync/observe/observer.h"

#include <algorithm>
#include <type_traits>
#include <utility>

#include "can/frame_length.h"
#include "cansync/observe/command_watch.h"
#include "cansync/observe/line_clock.h"
#include "cansync/observe/process_watch.h"

namespace cansync::observe {
namespace {

/// Frames and edges that are kept until the interval is told by them.
constexpr std::size_t kMostKept = 8192;

}  // namespace

struct Observer::Analysis {
  Analysis(Observation& to, bool sync_seen, bool by_count)
      : out(to),
        times(slot_times(to.bit_rate)),
        clock(to.bit_rate, sync_seen, by_count),
        process(to),
        commands(to, times) {}

  Observation& out;
  const SlotTimes& times;
  LineClock clock;
  SlotHistogram slots;
  ProcessWatch process;
  CommandWatch commands;
  std::optional<Duration> first;
  Duration last{};
  std::optional<IntervalNumber> first_interval;
  IntervalNumber last_interval = 0;

  void place(Place place, const OnBus& when) {
    if (when.at.known) slots.add(place, when.at.after_edge);
  }
  void frame(const can::Frame& frame, OnBus when);
  void telegram(const Telegram& telegram, const OnBus& when);
  void reference(const ReferenceTelegram& telegram, const OnBus& when);
};

Observer::Observer(const ObserverSettings& settings) : settings_(settings) {}
Observer::~Observer() = default;

void Observer::sync(Duration at, const can::Frame* frame) {
  evidence_.sync(frame);
  if (frame != nullptr) stamps_.frame(at, *frame);
  keep({at, std::nullopt, std::exchange(anew_, false)});
}

void Observer::frame(Duration at, const can::Frame& frame) {
  evidence_.frame(frame);
  stamps_.frame(at, frame);
  keep({at, frame, std::exchange(anew_, false)});
}

void Observer::begin_anew() {
  vote_.begin_anew();
  stamps_.begin_anew();
  anew_ = true;
}

void Observer::keep(const Kept& kept) {
  kept.frame ? vote_.frame(kept.at, *kept.frame) : vote_.sync(kept.at);
  if (analysis_) return take(kept);
  kept_.push_back(kept);
  if (kept_.size() >= kMostKept) begin();
}

void Observer::begin() {
  const IntervalVote::Result result = vote_.result();
  out_.bit_rate = settings_.bit_rate.value_or(result.bit_rate);
  out_.bit_rate_given = settings_.bit_rate.has_value();
  const bool by_count = stamps(std::nullopt).bunched() && !result.steady();
  out_.sync_seen = result.by_sync || (by_count && evidence_.evidence(result).edges > 0);
  analysis_ = std::make_unique<Analysis>(out_, out_.sync_seen, by_count);
  for (const Kept& kept : kept_) take(kept);
  kept_ = {};
}

void Observer::take(const Kept& kept) {
  Analysis& analysis = *analysis_;
  const Duration at = std::max(kept.at, analysis.last);
  if (kept.anew) analysis.clock.begin_anew();
  if (!kept.frame) {
    ++out_.edges;
    analysis.clock.sync(at);
    return;
  }
  const can::Frame& frame = *kept.frame;
  const unsigned bits = can::frame_bits(frame);
  out_.busy_bits += bits;
  // The interframe space is no part of what a stamp tells.
  const Duration length = (bits - can::kInterframeBits) * analysis.times.bit_time();
  OnBus when;
  when.start = settings_.stamps == Stamps::start ? at : at - length;
  when.end = when.start + length;
  analysis.last = at;
  analysis.frame(frame, when);
}

void Observer::Analysis::frame(const can::Frame& frame, OnBus when) {
  if (!first) first = when.start;
  when.since_first = when.start - *first;
  ++out.frames;
  out.length = when.since_first;
  if (frame.error) {
    ++out.error_frames;
    return;
  }
  const Decoded decoded = decode(frame);
  if (const auto* error = std::get_if<DecodeError>(&decoded)) {
    ++out.no_telegram[static_cast<unsigned>(*error)];
    return;
  }
  const auto& told = std::get<Telegram>(decoded);
  const auto* wrc = std::get_if<ReferenceTelegram>(&told);
  if (wrc != nullptr && wrc->channel == Channel::one) clock.reference_one(when.start);
  when.at = clock.instant(when.start);
  if (when.at.known) {
    if (!first_interval) first_interval = when.at.interval;
    last_interval = std::max(last_interval, when.at.interval);
  }
  telegram(told, when);
}

void Observer::Analysis::reference(const ReferenceTelegram& telegram, const OnBus& when) {
  if (!out.first_reference) out.first_reference = when.since_first;
  place(telegram.channel == Channel::one ? Place::reference_one : Place::reference_two, when);
  process.reference(telegram, when.at);
}

void Observer::Analysis::telegram(const Telegram& telegram, const OnBus& when) {
  const bool operation = out.first_reference.has_value();
  const Place command = operation ? Place::command : Place::set_up_command;
  const Place response = operation ? Place::response : Place::set_up_response;
  std::visit(
      [&](const auto& told) {
        using T = std::decay_t<decltype(told)>;
        if constexpr (std::is_same_v<T, ReferenceTelegram>) {
          reference(told, when);
        } else if constexpr (std::is_same_v<T, ActualTelegram>) {
          place(told.channel == Channel::one ? Place::actual_one : Place::actual_two, when);
          process.actual(told);
        } else if constexpr (std::is_same_v<T, ActionCommand>) {
          place(command, when);
          commands.action(told, when);
        } else if constexpr (std::is_same_v<T, ParameterReply> || std::is_same_v<T, TransferReply>) {
          place(response, when);
          commands.reply(told, when);
        } else {
          place(command, when);
          commands.command(told.slave, telegram, when);
        }
      },
      telegram);
}

/// By the shortest frames there are, when no bit rate is known.
StampCheck::Result Observer::stamps(std::optional<BitRate> by_interval) const noexcept {
  return stamps_.result(settings_.bit_rate.value_or(by_interval.value_or(BitRate::mbit1)));
}

Observation Observer::finish() {
  if (!analysis_) begin();
  const IntervalVote::Result result = vote_.result();
  out_.evidence = evidence_.evidence(result);
  const bool known = result.votes > 0 && (result.steady() || !stamps(std::nullopt).bunched());
  out_.stamps = stamps(known ? std::optional(result.bit_rate) : std::nullopt);
  const bool bunched = out_.stamps.bunched();
  const bool same = result.bit_rate == out_.bit_rate && (!bunched || result.steady());
  out_.interval_votes = same ? result.votes : 0;
  out_.interval_votes_against = same ? result.against : result.votes;
  out_.interval = same ? result.mean : Duration{0};
  for (unsigned i = 0; i < kPlaces && out_.stamps.fine(); ++i)
    out_.slot[i] = analysis_->slots.use(static_cast<Place>(i));
  if (analysis_->first_interval) out_.intervals = analysis_->last_interval - *analysis_->first_interval + 1;
  analysis_->commands.finish();
  for (SlaveUse& slave : out_.slave)
    if (!out_.stamps.fine()) slave.response = {};
  analysis_.reset();
  return std::move(out_);
}

}  // namespace cansync::observe
