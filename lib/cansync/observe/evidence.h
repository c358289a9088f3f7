#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "can/frame.h"
#include "cansync/observe/interval_vote.h"
#include "cansync/telegram/telegram.h"

namespace cansync::observe {

/// What the frames of a bus look like.
enum class LineKind : std::uint8_t {
  silent,   ///< no frame was received
  cansync,  ///< the evidence reaches `kLeastConfidence`
  j1939,    ///< most frames have 29-bit identifiers of J1939, or of a protocol based on it
  canopen,  ///< heartbeats, or SDO requests with their answers
  unknown,  ///< none of these
};

/// Percent from which on frames are those of CANsync.
inline constexpr unsigned kLeastConfidence = 60;
/// With fewer telegrams no statement is made.
inline constexpr std::uint64_t kLeastTelegrams = 8;

/// Counts that say which protocol the frames of a bus belong to.
struct LineEvidence {
  std::uint64_t frames = 0;         ///< data and remote frames, SYNC frames included
  std::uint64_t telegrams = 0;      ///< of those, CANsync telegrams and SYNC frames
  std::uint64_t edges = 0;          ///< SYNC edges
  std::uint64_t references = 0;     ///< WRC1
  std::uint64_t commands = 0;       ///< telegrams that ask one slave
  std::uint64_t rated = 0;          ///< telegrams whose rate can be compared with SYNC or an interval
  std::uint64_t in_rate = 0;        ///< of those, not more than one in an interval
  std::uint64_t answers = 0;        ///< RDC1, RDC2, RC
  std::uint64_t expected = 0;       ///< of those, to the question before
  std::uint64_t replies = 0;        ///< of those, RC
  std::uint64_t actual = 0;         ///< RDC1, RDC2
  std::uint64_t extended = 0;       ///< frames with 29-bit identifiers
  std::uint64_t j1939 = 0;          ///< of those, with a parameter group that J1939 has
  std::uint64_t claims = 0;         ///< of those, address claims
  std::uint64_t heartbeats = 0;     ///< of CANopen
  std::uint64_t no_heartbeats = 0;  ///< frames with their identifiers that are none
  std::uint64_t sdo_pairs = 0;      ///< SDO request and its answer

  /// Percent of frames with identifier and length of CANsync, 0..100.
  unsigned identifiers_percent() const noexcept;
  /// Percent of `rated`, 0..100; 0 when nothing is.
  unsigned rate_percent() const noexcept;
  /// Percent of `answers`, 0..100; 0 when there is none.
  unsigned answers_percent() const noexcept;
  /// How sure it is that a CANsync master is on the bus, 0..100: the mean of the three; without answers the lesser of
  /// the other two. 0 without a telegram that a master alone sends, for actual values without WRC1, and below
  /// `kLeastTelegrams`.
  unsigned confidence() const noexcept;
  /// Which protocol it is.
  LineKind kind() const noexcept;
};

/// Collects the evidence. Looks at no time stamp. Memory is fixed. One thread; not for the realtime thread.
class EvidenceTaker {
 public:
  /// A SYNC edge, by this frame; null: by a wire of its own.
  void sync(const can::Frame* frame) noexcept;
  /// Any other frame; an error frame is ignored.
  void frame(const can::Frame& frame);
  /// What was found. `interval`: as the same frames tell it, for a bus without SYNC edges.
  LineEvidence evidence(const IntervalVote::Result& interval) const noexcept;

 private:
  static constexpr unsigned kNodes = 128;  ///< of CANopen
  struct Question {
    bool transfer = false;
    std::uint16_t number = 0;
  };

  void telegram(const Telegram& telegram);
  void extended(std::uint32_t identifier) noexcept;
  void canopen(const can::Frame& frame) noexcept;

  LineEvidence out_;
  bool reference_since_edge_ = false;
  bool command_since_edge_ = false;
  std::uint64_t references_in_rate_ = 0;
  std::uint64_t commands_in_rate_ = 0;
  std::array<std::optional<std::uint8_t>, kChannels> polled_{};
  std::array<std::optional<Question>, kSlaves> asked_{};
  std::array<std::optional<std::uint32_t>, kNodes> object_{};  ///< index and sub-index of an SDO request
};

/// Do time stamps lie as far apart as frames are long? An adapter without a clock has its frames stamped when the
/// computer receives several at once. Memory is fixed. One thread.
class StampCheck {
 public:
  /// The next frame. Times must not fall.
  void frame(Duration at, const can::Frame& frame) noexcept;
  /// What comes next has no relation in time to what came before.
  void begin_anew() noexcept { last_.reset(); }

  /// A clock that counts no finer, as of logs with three decimals, is coarse.
  static constexpr Duration kCoarseStep = std::chrono::microseconds(250);

  /// What was found so far.
  struct Result {
    std::uint64_t frames = 0;    ///< with another one before them
    std::uint64_t too_near = 0;  ///< of those, less than half a frame behind it
    Duration step{};             ///< every distance is a multiple of it; 0: all are 0
    /// Many are: times between frames say nothing.
    bool bunched() const noexcept { return too_near >= 8 && too_near * 8 > frames; }
    /// The clock has so few digits that the place of a telegram in its interval is not known.
    bool coarse() const noexcept { return frames >= 8 && step >= kCoarseStep; }
    /// They tell the place of a telegram in its interval.
    bool fine() const noexcept { return !bunched() && !coarse(); }
  };
  /// By the lengths that frames have at this bit rate.
  Result result(BitRate bit_rate) const noexcept;

 private:
  std::optional<Duration> last_;
  unsigned last_bits_ = 0;
  std::uint64_t frames_ = 0;
  Duration step_{};
  std::array<std::uint64_t, kSlotTimes.size()> too_near_{};  ///< by bit rate
};

}  // namespace cansync::observe
