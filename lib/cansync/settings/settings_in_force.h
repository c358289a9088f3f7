#pragma once

#include <array>

#include "cansync/settings/settings.h"
#include "cansync/telegram/mapping.h"
#include "cansync/telegram/numbers.h"

namespace cansync {

/// What of the master's settings may change while it runs: what requests and a reload set, what is published
/// as in force, and what the audit trail remembers. Plain values.
struct SettingsInForce {
  ProcessMapping reference_mapping = {};
  std::array<ProcessMapping, kSlaves> actual_mapping = {};
  std::array<Cursor, kChannels> polling = {};
  SlaveNumber maximum_slave;
  Cursor control_word;
  Cursor parameter;
  Cursor transfer;
  AllReferenceLimits reference_limits = {};
  friend constexpr bool operator==(const SettingsInForce&, const SettingsInForce&) = default;
};

/// Takes them out of all settings. Allocates nothing; any thread.
SettingsInForce in_force(const MasterSettings& settings) noexcept;

/// Puts them into `settings`; everything else stays. Allocates nothing; any thread.
void put_in_force(const SettingsInForce& from, MasterSettings& settings) noexcept;

}  // namespace cansync
