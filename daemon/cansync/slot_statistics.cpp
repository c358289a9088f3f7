#include "daemon/cansync/slot_statistics.h"

#include <algorithm>

#include "can/frame_length.h"
#include "cansync/telegram/telegram.h"

namespace cansyncd {

std::optional<TelegramClass> telegram_class(const can::Frame& frame) noexcept {
  namespace identifier = cansync::identifier;
  if (!frame.is_standard_data()) return std::nullopt;
  if (frame.id == identifier::action) return TelegramClass::command;
  switch (identifier::channel_of(frame.id)) {
    case identifier::response:
      return TelegramClass::response;
    case identifier::reference_one:
      return TelegramClass::reference_one;
    case identifier::actual_one:
      return TelegramClass::actual_one;
    case identifier::reference_two:
      return TelegramClass::reference_two;
    case identifier::actual_two:
      return TelegramClass::actual_two;
    case identifier::command:
      return TelegramClass::command;
    default:
      return std::nullopt;
  }
}

cansync::Duration latest_start(const cansync::SlotTimes& times, TelegramClass slot) noexcept {
  switch (slot) {
    case TelegramClass::response:
      return times.response;
    case TelegramClass::reference_one:
      return times.reference_one;
    case TelegramClass::actual_one:
      return times.actual_one;
    case TelegramClass::reference_two:
      return times.reference_two;
    case TelegramClass::actual_two:
      return times.actual_two;
    case TelegramClass::command:
      return times.command;
  }
  return times.interval;
}

void SlotStatistics::add(const can::Frame& frame, unsigned bits, can::Time end, can::Time sync) noexcept {
  const auto slot = telegram_class(frame);
  if (!slot) return;
  const can::Time length = (bits - can::kInterframeBits) * times_.bit_time();
  const can::Time start = end - length;
  can::Time edge = sync;
  if (*slot == TelegramClass::command) {
    last_command_ = start;
    if (start < sync) edge -= times_.interval;
  }
  const bool answers_this_interval = last_command_ >= sync && last_command_ < start;
  if (*slot == TelegramClass::response && answers_this_interval) edge += times_.interval;

  const cansync::Duration after = start - edge;
  Gathered& gathered = classes_[static_cast<unsigned>(*slot)];
  SlotSummary& summary = gathered.summary;
  summary.earliest = summary.count == 0 ? after : std::min(summary.earliest, after);
  summary.latest = summary.count == 0 ? after : std::max(summary.latest, after);
  gathered.sum += after;
  ++summary.count;
  if (after > latest_start(times_, *slot)) ++summary.late;
}

SlotSummaries SlotStatistics::take() noexcept {
  SlotSummaries taken;
  for (unsigned i = 0; i < kTelegramClasses; ++i) {
    taken[i] = classes_[i].summary;
    if (taken[i].count > 0) taken[i].mean = classes_[i].sum / static_cast<can::Time::rep>(taken[i].count);
    classes_[i] = {};
    classes_[i].summary.late = taken[i].late;
  }
  return taken;
}

}  // namespace cansyncd
