#include "cansync/settings/settings.h"

namespace cansync {

SlaveMask MasterSettings::configured() const noexcept {
  SlaveMask mask;
  for (unsigned i = 0; i < kSlaves; ++i) {
    if (slaves[i].configured) mask.bits |= 1u << i;
  }
  return mask;
}

}  // namespace cansync
