#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "master_rig.h"

namespace cansync::test {

/// Answers reference telegrams with actual values that tell slave, channel and a counter.
inline std::optional<Telegram> actual_answer(const Telegram& telegram) {
  const auto* reference = std::get_if<ReferenceTelegram>(&telegram);
  if (reference == nullptr || reference->polled > 31) return MasterRig::status_only(telegram);
  return ActualTelegram{
      reference->channel, slave(reference->polled), 4, {reference->polled, 0, 0xFFFF, 0xFFFF}};
}

/// An active line whose slaves answer so, without status telegrams in between.
inline std::unique_ptr<MasterRig> active_line(MasterSettings settings) {
  settings.startup.status_period = Duration(0);
  auto rig = std::make_unique<MasterRig>(settings);
  rig->activate();
  rig->answer = actual_answer;
  return rig;
}

/// The reference telegrams of the newest interval.
inline std::vector<can::Frame> references(const MasterRig& rig) {
  std::vector<can::Frame> frames;
  for (const Telegram& telegram : rig.sent) {
    if (std::holds_alternative<ReferenceTelegram>(telegram)) frames.push_back(encode(telegram));
  }
  return frames;
}

}  // namespace cansync::test
