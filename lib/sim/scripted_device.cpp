#include "sim/scripted_device.h"

#include <algorithm>
#include <utility>

namespace sim {
namespace {

/// Identifier and flags are those that the answer is for.
bool is_for(const ScriptedAnswer& answer, const can::Frame& frame) noexcept {
  return frame.extended == answer.to.extended && frame.remote == answer.to.remote && !frame.error &&
         ((frame.id ^ answer.to.id) & answer.mask) == 0;
}

bool data_fits(const ScriptedAnswer& answer, const can::Frame& frame) noexcept {
  for (std::size_t i = 0; i < frame.data.size(); ++i) {
    if (answer.data_mask[i] == 0) continue;
    if (i >= frame.dlc || ((frame.data[i] ^ answer.to.data[i]) & answer.data_mask[i]) != 0) return false;
  }
  return true;
}

}  // namespace

ScriptedDevice::ScriptedDevice(DeviceSettings settings)
    : settings_(std::move(settings)), due_(settings_.periods.size(), can::Time::max()) {}

bool ScriptedDevice::accepts(const can::Frame& frame) const noexcept {
  return std::any_of(settings_.answers.begin(), settings_.answers.end(),
                     [&frame](const ScriptedAnswer& answer) { return is_for(answer, frame); });
}

std::optional<Transmission> ScriptedDevice::on_frame(const can::Frame& frame, can::Time end) noexcept {
  for (ScriptedAnswer& answer : settings_.answers) {
    if (answer.count == 0 || !is_for(answer, frame) || !data_fits(answer, frame)) continue;
    if (answer.count != UINT64_MAX) --answer.count;
    can::Frame sent = answer.frame;
    if (answer.copy_data) {
      sent.dlc = frame.dlc;
      sent.data = frame.data;
    }
    return Transmission{sent, end + answer.after};
  }
  return std::nullopt;
}

std::optional<Transmission> ScriptedDevice::on_join(can::Time now) noexcept {
  for (std::size_t i = 0; i < due_.size(); ++i) due_[i] = now + settings_.periods[i].phase;
  return std::nullopt;
}

std::optional<can::Time> ScriptedDevice::next_time() const noexcept {
  const auto first = std::min_element(due_.begin(), due_.end());
  if (first == due_.end()) return std::nullopt;
  return *first;
}

Deed ScriptedDevice::on_time(can::Time now) noexcept {
  const auto first = std::min_element(due_.begin(), due_.end());
  if (first == due_.end() || *first > now) return {};
  ScriptedPeriod& period = settings_.periods[static_cast<std::size_t>(first - due_.begin())];
  Deed deed;
  deed.transmission = Transmission{period.frame, *first};
  if (period.counting) ++period.frame.data[*period.counting];
  *first += period.every;
  if (*first <= now) *first += (now - *first) / period.every * period.every + period.every;
  return deed;
}

}  // namespace sim
