#pragma once

#include "layer2/config/config.h"
#include "layer2/module.h"

namespace cansyncd {

/// What the module needs of a configuration. Allocates; not for the realtime thread.
layer2::ModuleSettings module_settings(const Layer2Config& config);

}  // namespace cansyncd
