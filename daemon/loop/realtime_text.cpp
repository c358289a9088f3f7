#include "daemon/loop/realtime_text.h"

#include <fmt/format.h>

namespace cansyncd {
namespace {

std::string scheduling(const rt::RealtimeSettings& settings, const rt::Grants& grants) {
  if (settings.priority == 0) return "SCHED_OTHER as configured";
  if (!grants.scheduling) return fmt::format("SCHED_OTHER (priority {} not granted)", settings.priority);
  return fmt::format("SCHED_FIFO priority {}", settings.priority);
}

std::string processor(const rt::RealtimeSettings& settings, const rt::Grants& grants) {
  if (settings.cpu < 0) return "any processor";
  if (!grants.affinity) return fmt::format("any processor ({} not granted)", settings.cpu);
  return fmt::format("processor {}", settings.cpu);
}

std::string_view memory(const rt::RealtimeSettings& settings, const rt::Grants& grants) noexcept {
  if (!settings.lock_memory) return "memory not locked as configured";
  return grants.memory_locked ? "memory locked" : "memory not locked (not granted)";
}

std::string_view latency(const rt::RealtimeSettings& settings, const rt::Grants& grants) noexcept {
  if (!settings.hold_cpu_awake) return "cpu_dma_latency not asked for";
  return grants.cpu_held_awake ? "cpu_dma_latency held at 0 us" : "cpu_dma_latency not held (not granted)";
}

}  // namespace

std::string realtime_text(const rt::RealtimeSettings& settings, const rt::Grants& grants,
                          std::string_view kernel) {
  return fmt::format("realtime thread: {}, {}, {}, {}, kernel {}", scheduling(settings, grants),
                     processor(settings, grants), memory(settings, grants), latency(settings, grants),
                     kernel);
}

}  // namespace cansyncd
