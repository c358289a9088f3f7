#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

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
  std::string who;            ///< as far as known; empty: nobody
  std::int32_t strength = 0;  ///< of its ownership
  Loss loss = Loss::none;
  bool operator==(const ReferenceGiver&) const = default;
};

/// Why values are held or stopped, as a stable word: writer_lost, given_up, deadline_missed, too_old,
/// mapping_changed, used_up, withdrawn, none_given; empty when they are released.
std::string_view release_cause(const cansync::ReleaseStatus& release, Loss loss) noexcept;

/// Fills the members `reference_release`; `lead_axis`: the telegrams that the lead axis of a cluster gives.
void fill_references(const std::array<cansync::ReleaseStatus, cansync::kChannels>& release,
                     const std::array<bool, cansync::kChannels>& lead_axis,
                     const std::array<ReferenceGiver, cansync::kChannels>& givers,
                     cansync_MasterStatus& sample);

}  // namespace cansyncd
