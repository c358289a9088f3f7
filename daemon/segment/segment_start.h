#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/settings.h"
#include "daemon/loop/sync_line.h"
#include "daemon/service/service_log.h"
#include "daemon_config/daemon_config.h"
#include "rt/realtime_thread.h"
#include "sim/fault_protocol.h"
#include "sim/trace_file.h"

/// The steps that the segments of all protocols share: checks before a start, and what is begun and told
/// alike. Main thread.
namespace cansyncd {

/// Checks what a file says of the system around it: a trace of a bus that is not simulated, the fault script
/// (`faults`: what scripts know of the protocol), the daemon's identity for DDS Security, which must be allowed
/// to write GatewayStatus. What is wrong is added to `problems`, what only costs a fault to `script_problems`.
void check_surroundings(const DaemonConfig& config, const std::vector<config::Setting>& settings,
                        const std::string& path, const sim::FaultProtocol& faults,
                        std::vector<config::Problem>& problems,
                        std::vector<config::Problem>& script_problems);

/// A file as it was read, with that checked, too, unless something is wrong already.
template <class File>
File checked(File file, const sim::FaultProtocol& faults) {
  if (file.problems.empty())
    check_surroundings(file.config, file.settings, file.path, faults, file.problems, file.script_problems);
  return file;
}

/// What the realtime thread asks of the system.
rt::RealtimeSettings realtime_settings(const RealtimeConfig& config);

/// The SYNC line that [sync] describes, for edges `interval` apart; null when it has neither output nor
/// input. Throws std::runtime_error, which names the place in the file `path`.
std::unique_ptr<SyncLine> make_sync_line(const DaemonConfig& config, can::Time interval,
                                         const std::vector<config::Setting>& settings,
                                         const std::string& path);

/// Tells the journal what the realtime thread was granted, and what is missing.
void tell_grants(const ServiceLog& log, const rt::RealtimeSettings& wanted, const rt::Grants& granted);

/// Waits until `wake_ups` is over 0: a service is ready when its bus is served, not when a thread was asked
/// for. Throws std::runtime_error when that takes more than 5 s, half of what the watchdog waits.
void wait_until_running(const std::function<std::uint64_t()>& wake_ups);

/// Tells the journal how the trace of a simulated line ended; `path`: its file. Nothing: there was none.
void tell_trace(const ServiceLog& log, const std::string& path,
                const std::optional<sim::TraceSummary>& summary);

}  // namespace cansyncd
