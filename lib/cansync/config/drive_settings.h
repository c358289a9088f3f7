#pragma once

#include "cansync/config/config.h"
#include "cansync/sim/drive.h"
#include "cansync/telegram/numbers.h"

namespace cansyncd {

/// What a simulated drive of slave `number` is: numbers, mappings and limits as the configuration says, so
/// that master and drive agree from the start. Main thread.
sim::DriveSettings drive_settings(const Config& config, cansync::SlaveNumber number);

}  // namespace cansyncd
