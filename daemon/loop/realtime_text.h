#pragma once

#include <string>
#include <string_view>

#include "rt/realtime_thread.h"

namespace cansyncd {

/// What the realtime thread got, in one line for the journal: policy, priority, processor, memory,
/// cpu_dma_latency, kernel. `kernel` is `rt::kernel_type`'s text. Allocates; not for the realtime thread.
std::string realtime_text(const rt::RealtimeSettings& settings, const rt::Grants& grants,
                          std::string_view kernel);

}  // namespace cansyncd
