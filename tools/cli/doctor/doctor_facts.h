#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

/// What this computer says of itself in /proc, /sys and /etc/cansync. `root` stands before them, so that a
/// made-up tree can be read; "/" is the computer. What cannot be read is left unknown; nothing throws for it.
namespace cansync::cli {

/// An idle state of a processor that is switched on.
struct IdleState {
  std::string name;
  std::uint32_t exit_latency = 0;  ///< us
};

/// Kernel and processors.
struct MachineFacts {
  std::string kernel;                  ///< release; empty: unknown
  std::string preemption;              ///< PREEMPT_RT, PREEMPT_DYNAMIC, PREEMPT, no preemption
  std::string isolated;                ///< isolated processors as the kernel lists them, "2-3"; empty: none
  std::vector<IdleState> idle_states;  ///< of the realtime thread's processor, deepest last; empty: none
};

/// `cpu`: the processor the realtime thread is bound to; below 0: processor 0 stands for all.
MachineFacts read_machine(const std::filesystem::path& root, int cpu);

/// The configuration of a bus in /etc/cansync.
struct ConfiguredBus {
  std::string unit;       ///< the instance of cansyncd@.service that reads it: the file's name without .toml
  std::string interface;  ///< bus.interface; empty: the file does not have it
};

/// The file in /etc/cansync whose bus.name is `bus`, or, without a name, whose bus.interface is; else the file
/// of that name. Nothing when there is none that can be read.
std::optional<ConfiguredBus> configured_bus(const std::filesystem::path& root, const std::string& bus);

/// Is processor `cpu` in a kernel list such as "1,4-7"? What is no such list names none.
bool in_processor_list(const std::string& list, int cpu) noexcept;

}  // namespace cansync::cli
