#pragma once

#include "cansync/sim/drive.h"
#include "cansync/telegram/numbers.h"
#include "daemon/cansync/config/config.h"

namespace cansyncd {

/// What a simulated drive of slave `number` is: numbers, mappings and limits as the configuration says, so
/// that master and drive agree from the start. Main thread.
sim::DriveSettings drive_settings(const Config& config, cansync::SlaveNumber number);

}  // namespace cansyncd
