#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "can/frame.h"
#include "cansync/observe/evidence.h"
#include "cansync/observe/interval_vote.h"
#include "cansync/telegram/numbers.h"

namespace cansync::observe {

/// Telegrams of one kind and one sender.
struct HeardTelegrams {
  std::uint64_t count = 0;    ///< telegrams
  std::uint16_t lengths = 0;  ///< bit n: one of them had n data bytes
};

/// What was heard of one slave number.
struct HeardSlave {
  std::uint64_t asked = 0;                         ///< commands to it
  HeardTelegrams answers;                          ///< RC
  std::array<std::uint64_t, kChannels> polled{};   ///< reference telegrams that asked it for actual values
  std::array<HeardTelegrams, kChannels> actual{};  ///< RDC1, RDC2
  /// True when it sent something itself.
  bool sends() const noexcept { return answers.count + actual[0].count + actual[1].count > 0; }
  /// True when anything concerned it.
  bool known() const noexcept { return sends() || asked + polled[0] + polled[1] > 0; }
};

/// Frames with an identifier, or of a form, that is none of CANsync.
struct ForeignFrames {
  std::uint32_t identifier = 0;  ///< 11 or 29 bits
  bool extended = false;
  bool remote = false;
  std::uint64_t count = 0;    ///< frames
  std::uint16_t lengths = 0;  ///< bit n: one of them had n data bytes
};

/// Who speaks on a line, and how much. Bounded whatever is heard.
struct Census {
  std::uint64_t frames = 0;        ///< of every kind, SYNC frames included
  std::uint64_t error_frames = 0;  ///< as the driver or the log has them
  std::uint64_t busy_bits = 0;     ///< of all frames, stuff bits included
  Duration length{};               ///< first to last frame
  std::uint64_t edges = 0;         ///< of SYNC
  IntervalVote::Result interval;   ///< nothing, when time stamps are bunched and do not repeat it
  LineEvidence evidence;
  StampCheck::Result stamps;
  std::array<HeardTelegrams, kChannels> reference{};  ///< WRC1, WRC2
  HeardTelegrams actions;
  HeardTelegrams commands;
  std::uint64_t reference_doubles = 0;  ///< WRC1 again before half an interval was over
  std::array<HeardSlave, kSlaves> slave{};
  std::vector<ForeignFrames> foreign;  ///< by the order in which they came first
  std::uint64_t foreign_over = 0;      ///< frames for which the list had no room

  /// True when somebody sends what a master alone sends.
  bool master() const noexcept {
    return edges + reference[0].count + reference[1].count + actions.count + commands.count > 0;
  }
  /// True when there seem to be two masters: many reference telegrams come twice in an interval. Nothing is
  /// known of it while the interval is unknown; of bunched time stamps the order alone counts.
  bool second_master() const noexcept {
    if (interval.votes == 0) return false;
    const std::uint64_t by_order = evidence.edges > 0 ? evidence.rated - evidence.in_rate : 0;
    return (stamps.bunched() ? by_order : reference_doubles) * 8 > reference[0].count;
  }
};

/// Most entries of `Census::foreign`.
inline constexpr std::size_t kMostForeign = 64;

/// Counts who sends what, of a recording or while it listens. Knows no configuration and keeps no frame.
/// Memory is bounded. One thread; not for the realtime thread (allocates).
class CensusTaker {
 public:
  /// A SYNC edge, by this frame; null: by a wire of its own. Times must not fall; what falls counts as at the
  /// time before.
  void sync(Duration at, const can::Frame* frame);
  /// Any other frame.
  void frame(Duration at, const can::Frame& frame);
  /// What comes next has no relation in time to what came before; it follows it at once.
  void begin_anew();
  /// What was heard until now. `bit_rate`: of the bus, when it is known otherwise than by its interval.
  Census census(std::optional<BitRate> bit_rate = std::nullopt) const;

 private:
  void pass(Duration at);
  void count(const can::Frame& frame);
  void telegram(Duration at, const can::Frame& frame);
  void reference(Duration at, unsigned channel, const can::Frame& frame);
  void foreign(const can::Frame& frame);

  Census heard_;
  IntervalVote vote_;
  EvidenceTaker evidence_;
  StampCheck stamps_;
  std::optional<Duration> first_;
  Duration last_{};
  std::optional<Duration> reference_at_;
  /// By bit rate: WRC1 that came before half an interval was over.
  std::array<std::uint64_t, kSlotTimes.size()> doubles_{};
};

}  // namespace cansync::observe
