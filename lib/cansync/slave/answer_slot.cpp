#include "cansync/slave/answer_slot.h"

#include <algorithm>

namespace cansync {

StartWindow start_window(AnswerSlot slot, bool process_data, const SlotTimes& times,
                         Duration asked_until) noexcept {
  Duration within = asked_until % times.interval;
  if (within.count() < 0) within += times.interval;
  const Duration edge = asked_until - within;
  const Duration seen = std::min(edge, Duration{});
  switch (slot) {
    case AnswerSlot::actual_one:
      return {asked_until, seen + times.actual_one};
    case AnswerSlot::actual_two:
      return {asked_until, seen + times.actual_two};
    case AnswerSlot::response:
      break;
  }
  // One that came so late that not all of tRSPTO is left until tCC is none of a line that is set up.
  const Duration until = process_data ? times.response : times.command - times.response_timeout;
  if (within <= until)
    return {asked_until, process_data ? edge + times.response : asked_until + times.response_timeout};
  return {edge + times.interval, edge + times.interval + times.response};
}

}  // namespace cansync
