#include "cli/trace/frame_twins.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <exception>
#include <utility>
#include <variant>

#include "can/frame_length.h"

namespace cansync::cli {
namespace {

constexpr std::size_t kFramesLookedAt = 256;
constexpr std::size_t kItemsLookedAt = 1024;  ///< with lines that are no frames
constexpr std::size_t kFewestFrames = 8;      ///< that tell it
/// Of a recording that was cut or lost some, not every frame has its twin.
constexpr double kMostInPairs = 0.9;
constexpr std::chrono::milliseconds kCoarse(1);  ///< stamps of such steps tell nothing of single frames

/// How long the frame takes at 1 Mbit/s.
std::chrono::microseconds shortest_time(const can::Frame& frame) {
  return std::chrono::microseconds(can::frame_bits(frame));
}

class OnceSource final : public TraceSource {
 public:
  OnceSource(std::unique_ptr<TraceSource> log, std::string name)
      : log_(std::move(log)), name_(std::move(name)) {}

  TraceItem next() override {
    if (!std::exchange(looked_, true)) look_ahead();
    for (;;) {
      Placed placed = following();
      place_ = std::move(placed.place);
      const auto* line = std::get_if<can::CandumpLine>(&placed.item);
      if (!doubled_ || line == nullptr || !twins_.take(*line)) return std::move(placed.item);
    }
  }

  std::string place() const override { return place_; }
  TraceProgress progress() const noexcept override { return log_->progress(); }
  bool endless() const noexcept override { return log_->endless(); }
  std::uint64_t dropped() const noexcept override { return log_->dropped(); }

 private:
  struct Placed {
    TraceItem item;
    std::string place;
  };

  /// Holds back the beginning until it tells.
  void look_ahead() {
    FrameTwins twins;
    const auto is_more = [&](const TraceItem& item) {
      if (const auto* line = std::get_if<can::CandumpLine>(&item)) twins.take(*line);
      return !std::holds_alternative<TraceEnd>(item) && twins.frames() < kFramesLookedAt &&
             ahead_.size() < kItemsLookedAt;
    };
    try {
      do {
        TraceItem item = log_->next();
        ahead_.push_back({std::move(item), log_->place()});
      } while (is_more(ahead_.back().item));
    } catch (...) {
      failure_ = std::current_exception();
    }
    doubled_ = twins.are_doubled();
    if (doubled_)
      ahead_.push_front(
          {TraceRemark{fmt::format(
               "{}: each frame stands there twice, sooner than a bus could carry it again, as in recordings "
               "of what this computer itself sends; each is taken once",
               name_)},
           {}});
  }

  /// What was held back, then what follows it.
  Placed following() {
    if (ahead_.empty()) {
      if (failure_) std::rethrow_exception(failure_);
      TraceItem item = log_->next();
      return {std::move(item), log_->place()};
    }
    Placed first = std::move(ahead_.front());
    ahead_.pop_front();
    return first;
  }

  std::unique_ptr<TraceSource> log_;
  std::string name_;
  std::deque<Placed> ahead_;
  std::exception_ptr failure_;  ///< of the log, behind what is held back
  FrameTwins twins_;
  std::string place_;
  bool looked_ = false;
  bool doubled_ = false;
};

}  // namespace

bool FrameTwins::take(const can::CandumpLine& line) {
  if (line.time == std::chrono::microseconds(0) || line.frame.error) return false;
  if (frames_++ == 0) begin_ = last_ = line.time;
  const auto step = std::chrono::abs(line.time - last_);
  if (step != step.zero() && (closest_ == step.zero() || step < closest_)) closest_ = step;
  last_ = line.time;
  const auto is_twin = [&line](const First& first) {
    const auto after = line.time - first.line.time;
    return first.line.frame == line.frame && first.line.interface == line.interface &&
           after >= after.zero() && after < shortest_time(line.frame);
  };
  const auto twin = std::find_if(firsts_.begin(), firsts_.end(), is_twin);
  if (twin != firsts_.end() && !twin->has_twin) {
    twin->has_twin = true;
    ++pairs_;
    return true;
  }
  thrice_ = thrice_ || twin != firsts_.end();
  shortest_ += shortest_time(line.frame);
  if (firsts_.size() == kBeside) firsts_.pop_front();
  firsts_.push_back({line});
  return false;
}

bool FrameTwins::are_doubled() const noexcept {
  return frames_ >= kFewestFrames && !thrice_ && closest_ != closest_.zero() && closest_ < kCoarse &&
         last_ - begin_ > shortest_ / 2 &&
         2.0 * static_cast<double>(pairs_) >= kMostInPairs * static_cast<double>(frames_);
}

std::unique_ptr<TraceSource> each_frame_once(std::unique_ptr<TraceSource> log, std::string name) {
  return std::make_unique<OnceSource>(std::move(log), std::move(name));
}

}  // namespace cansync::cli
