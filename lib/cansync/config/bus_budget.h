#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "cansync/config/config.h"
#include "cansync/settings/settings.h"
#include "cansync/settings/settings_check.h"

/// What an interval has room for, worked out from the settings before anything starts. Pure functions for
/// set-up code on a normal thread: they read no clock, file or bus, and allocate.
namespace cansyncd {

/// What the budget is worked out from.
struct BudgetInput {
  const cansync::MasterSettings& master;  ///< must have passed cansync::check
  /// Data bytes (0..8) of a software SYNC frame on the bus; nothing: SYNC is an edge on its own wire.
  std::optional<std::uint8_t> sync_frame_bytes;
};

/// The budget's input for a configuration. The configuration must outlive it.
BudgetInput budget_input(const Config& config) noexcept;

/// One telegram of the interval.
struct SlotBudget {
  std::string_view name;  ///< "SYNC", "RC", "WRC1", "RDC1", "WRC2", "RDC2", "CC"
  unsigned bytes = 0;     ///< most data bytes
  unsigned bits = 0;      ///< length with that many bytes and every stuff bit, interframe space included
  cansync::Duration planned{};  ///< when the master sends it, after SYNC; a slave's: its latest start
  cansync::Duration latest{};   ///< latest start, after SYNC (M 3.1.1.1)
  cansync::Duration end{};      ///< end of the longest telegram begun at the latest start
};

/// The budget of one bus.
struct BusBudget {
  std::uint32_t bits_per_second = 0;  ///< one of the four bit rates
  cansync::Duration interval{};
  unsigned capacity_bits = 0;     ///< bits of one interval
  std::vector<SlotBudget> slots;  ///< in the order of the wire

  /// Share of the bus's time, in permille. Idle: active operation without jobs, no stuff bits, status words
  /// read. Typical: the same and a parameter read in every interval. Worst: every telegram at its longest.
  unsigned idle = 0;
  unsigned typical = 0;  ///< 0..1000, or more where the bus has not the time
  unsigned worst = 0;    ///< likewise

  /// Intervals until a channel has asked every slave it asks once; 0: it asks nobody.
  std::array<unsigned, cansync::kChannels> polling_round = {};
  /// Most intervals until one of both channels asks a slave again; 0: the channels ask together or not in
  /// turn.
  unsigned polling_apart = 0;

  unsigned parameter_round = 1;  ///< intervals from one turn of a slave's parameter job to the next
  unsigned transfer_round = 1;   ///< likewise of its transfer
  /// Begin of the command to the end of the answer, shortest telegrams, a slave that answers at once.
  cansync::Duration parameter_least{};
  unsigned transfer_block = 0;      ///< bytes: the smallest block of all slaves
  unsigned transfer_intervals = 0;  ///< that `kTransferBytes` take at the least, nothing else waiting
  cansync::Duration transfer_least{};

  /// How late a software SYNC frame may start, because the longest command sent at its latest start still
  /// stands on the bus; 0 without a SYNC frame.
  cansync::Duration sync_delay{};
};

/// Size of the transfer whose time the budget tells.
inline constexpr unsigned kTransferBytes = 64 * 1024;

/// Works the budget out.
BusBudget bus_budget(const BudgetInput& input);

/// What of these settings cannot fit into the intervals; empty: everything does. Fields are named as
/// cansync::check names them, and "sync" for the software SYNC frame.
std::vector<cansync::SettingProblem> check_budget(const BudgetInput& input);

}  // namespace cansyncd
