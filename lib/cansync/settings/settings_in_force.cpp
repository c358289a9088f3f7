#include "cansync/settings/settings_in_force.h"

namespace cansync {

SlaveMask MasterSettings::configured() const noexcept {
  SlaveMask mask;
  for (unsigned i = 0; i < kSlaves; ++i) {
    if (slaves[i].configured) mask.bits |= 1u << i;
  }
  return mask;
}

SettingsInForce in_force(const MasterSettings& settings) noexcept {
  SettingsInForce out;
  out.reference_mapping = settings.process.reference_mapping;
  for (unsigned i = 0; i < kSlaves; ++i) out.actual_mapping[i] = settings.slaves[i].actual_mapping;
  out.polling = settings.process.polling;
  out.maximum_slave = settings.process.maximum_slave;
  out.control_word = settings.command_channel.control_word;
  out.parameter = settings.command_channel.parameter;
  out.transfer = settings.command_channel.transfer;
  out.reference_limits = settings.process.reference_limits;
  return out;
}

void put_in_force(const SettingsInForce& from, MasterSettings& settings) noexcept {
  settings.process.reference_mapping = from.reference_mapping;
  for (unsigned i = 0; i < kSlaves; ++i) settings.slaves[i].actual_mapping = from.actual_mapping[i];
  settings.process.polling = from.polling;
  settings.process.maximum_slave = from.maximum_slave;
  settings.command_channel.control_word = from.control_word;
  settings.command_channel.parameter = from.parameter;
  settings.command_channel.transfer = from.transfer;
  settings.process.reference_limits = from.reference_limits;
}

}  // namespace cansync
