#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "can/frame.h"
#include "cansync/observe/evidence.h"
#include "cansync/observe/interval_vote.h"
#include "cansync/observe/observation.h"

namespace cansync::observe {

/// What a frame's time stamp tells.
enum class Stamps : std::uint8_t {
  start,  ///< its first bit, as in the trace of a simulated line
  end,    ///< its last bit, as candump and captures have it
};

/// How a recording is to be read.
struct ObserverSettings {
  Stamps stamps = Stamps::end;
  std::optional<BitRate> bit_rate;  ///< nothing: told by the interval
};

/// Reads a recording once, from its first frame to its last, and says what was on the line. Knows nothing of
/// any configuration. The first frames are kept until the interval is known. Memory is bounded. One thread.
class Observer {
 public:
  /// A recording of this kind.
  explicit Observer(const ObserverSettings& settings);
  ~Observer();
  Observer(const Observer&) = delete;
  Observer& operator=(const Observer&) = delete;

  /// A SYNC edge, by this frame; null: by a wire of its own. Times must not fall; what falls counts as at the time
  /// before.
  void sync(Duration at, const can::Frame* frame = nullptr);
  /// Any frame, also one that is no telegram.
  void frame(Duration at, const can::Frame& frame);
  /// What comes next has no relation in time to what came before; it follows it at once.
  void begin_anew();
  /// The recording is over, nothing may follow.
  Observation finish();

 private:
  struct Kept {
    Duration at{};
    std::optional<can::Frame> frame;  ///< nothing: a SYNC edge
    bool anew = false;                ///< time begins anew with it
  };
  struct Analysis;

  void keep(const Kept& kept);
  void begin();
  void take(const Kept& kept);
  StampCheck::Result stamps(std::optional<BitRate> by_interval) const noexcept;

  ObserverSettings settings_;
  IntervalVote vote_;
  EvidenceTaker evidence_;
  StampCheck stamps_;
  std::vector<Kept> kept_;
  bool anew_ = false;  ///< time begins anew with what comes next
  Observation out_;
  std::unique_ptr<Analysis> analysis_;
};

}  // namespace cansync::observe
