#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <tuple>

#include "cansync.h"
#include "cansync/process_data/release_status.h"
#include "cansync/telegram/numbers.h"

namespace cansyncd {

/// What was lost of the reference values of a telegram, so that they are no longer released as their writer
/// wants it.
enum class Loss : std::uint8_t {
  none,
  writer_lost,      ///< it has left or died
  given_up,         ///< by its writer
  deadline_missed,  ///< it lives and gives nothing new
  too_old,          ///< nothing new came within failsafe.reference_max_intervals
  mapping_changed,  ///< they were given for another mapping than the one in force
};

/// Who gives the reference values of a telegram.
struct ReferenceGiver {
  std::string who;                         ///< as far as known; empty: nobody
  std::int32_t strength = 0;               ///< of its ownership
  std::array<std::uint8_t, 16> guid = {};  ///< of its writer
  Loss loss = Loss::none;
  std::string waiting;         ///< a writer that waits for the telegram; empty: none
  std::uint64_t refused = 0;   ///< samples of writers that wait, since the start
  std::string refused_reason;  ///< of the newest sample that was refused, for its writer or a limit
  /// What is to be told at once. Refused samples rise with each of them, and are told once a second.
  friend bool operator==(const ReferenceGiver& a, const ReferenceGiver& b) noexcept {
    return std::tie(a.who, a.strength, a.guid, a.loss, a.waiting) ==
           std::tie(b.who, b.strength, b.guid, b.loss, b.waiting);
  }
};

/// Why values are held or stopped, as a stable word: writer_lost, given_up, deadline_missed, too_old,
/// mapping_changed, bus_lost, used_up, withdrawn, none_given; empty when they are released.
std::string_view release_cause(const cansync::ReleaseStatus& release, Loss loss) noexcept;

/// Fills the members `reference_release`; `lead_axis`: the telegrams that the lead axis of a cluster gives.
void fill_references(const std::array<cansync::ReleaseStatus, cansync::kChannels>& release,
                     const std::array<bool, cansync::kChannels>& lead_axis,
                     const std::array<ReferenceGiver, cansync::kChannels>& givers,
                     cansync_MasterStatus& sample);

}  // namespace cansyncd
