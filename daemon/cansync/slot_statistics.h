#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "can/bus.h"
#include "can/frame.h"
#include "cansync/settings/timing.h"

namespace cansyncd {

/// The six telegrams of an interval, in the order of their slots (M 3.1.1.1).
enum class TelegramClass : std::uint8_t {
  response,       ///< RC
  reference_one,  ///< WRC1
  actual_one,     ///< RDC1
  reference_two,  ///< WRC2
  actual_two,     ///< RDC2
  command,        ///< CC, and the action command
};
inline constexpr unsigned kTelegramClasses = 6;

/// The class of a frame by its identifier; nothing for a frame that is no CANsync telegram. Realtime safe.
std::optional<TelegramClass> telegram_class(const can::Frame& frame) noexcept;

/// When the telegrams of one class were started.
struct SlotSummary {
  std::uint32_t count = 0;       ///< telegrams seen since the previous `take`
  cansync::Duration earliest{};  ///< start after SYNC; 0 when none was seen
  cansync::Duration mean{};      ///< likewise
  cansync::Duration latest{};    ///< likewise
  std::uint64_t late = 0;        ///< telegrams that started after the slot's latest start, since the start
};
using SlotSummaries = std::array<SlotSummary, kTelegramClasses>;

/// Latest start of a class's telegram after SYNC. Realtime safe.
cansync::Duration latest_start(const cansync::SlotTimes& times, TelegramClass slot) noexcept;

/// When each class of telegram was started on the bus, counted from the SYNC edge of the interval it belongs
/// to. A start is the frame's end less its length in bits. For active operation, where the slots hold: in
/// set-up a command goes out at another instant. One thread; realtime safe.
class SlotStatistics {
 public:
  /// `times` must be one of `cansync::kSlotTimes`.
  explicit SlotStatistics(const cansync::SlotTimes& times) noexcept : times_(times) {}

  /// A frame of `bits` (as `can::frame_bits` counts them) ended at `end`, after the edge `sync` of the newest
  /// interval (both by the clock of the bus). A command that began before that edge belongs to the interval
  /// before; a response that began after this interval's command belongs to the next, and counts as started
  /// before its edge.
  void add(const can::Frame& frame, unsigned bits, can::Time end, can::Time sync) noexcept;

  /// Summaries since the previous call, which begins new ones.
  SlotSummaries take() noexcept;

 private:
  struct Gathered {
    SlotSummary summary;
    cansync::Duration sum{0};
  };

  cansync::SlotTimes times_;
  can::Time last_command_ = can::Time::min();  ///< start of the newest command on the bus
  std::array<Gathered, kTelegramClasses> classes_ = {};
};

}  // namespace cansyncd
