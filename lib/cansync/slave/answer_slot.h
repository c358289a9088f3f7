#pragma once

#include <cstdint>

#include "can/frame.h"
#include "cansync/settings/timing.h"
#include "cansync/telegram/numbers.h"

/// When a slave's answer may start (M 3.1.1.1, 3.2.3.5). Pure; realtime safe.
namespace cansync {

/// The slots in which a slave sends.
enum class AnswerSlot : std::uint8_t { actual_one, actual_two, response };
inline constexpr unsigned kAnswerSlots = 3;
/// Place of a slot in arrays of `kAnswerSlots`.
constexpr unsigned index(AnswerSlot slot) noexcept {
  return static_cast<unsigned>(slot);
}
/// The slot of a channel's actual values.
constexpr AnswerSlot actual_slot(Channel channel) noexcept {
  return channel == Channel::one ? AnswerSlot::actual_one : AnswerSlot::actual_two;
}

/// When an answer may start, both ends included. After the running interval's edge; over the interval: in the
/// next one.
struct StartWindow {
  Duration earliest{};
  Duration latest{};
  friend constexpr bool operator==(const StartWindow&, const StartWindow&) = default;
};

/// Of the answer to a telegram that ended at `asked_until`. Actual values: until tRDC1 or tRDC2 after an edge
/// that was seen, else left out (O 7.2). A response with process data on the bus: until tRC, of the running
/// interval for a command that ended by then, else of the next. Without: for tRSPTO when all of it is left
/// until tCC of the running interval (the line is set up), else until tRC of the next (nobody gives reference
/// values). The interval of an edge that stayed away is counted from where it was due. A telegram that ended
/// before the edge belongs to the interval before.
StartWindow start_window(AnswerSlot slot, bool process_data, const SlotTimes& times,
                         Duration asked_until) noexcept;

/// What a slave puts on the bus, and when.
struct SlaveAnswer {
  can::Frame frame;
  AnswerSlot slot = AnswerSlot::response;
  StartWindow window;
};

}  // namespace cansync
