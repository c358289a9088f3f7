#include "daemon/segment/segment_start.h"

#include <fmt/format.h>

#include <chrono>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <thread>

#include "daemon/bus/sim_bus.h"
#include "daemon/loop/realtime_text.h"
#include "dds/gateway_topics.h"
#include "dds/security.h"
#include "rt/kernel_type.h"
#include "sync/system.h"
#include "text/counts.h"

namespace cansyncd {
namespace {

/// Where an option was given; the file alone when it was not.
config::Position place_of(std::string_view key, const std::vector<config::Setting>& settings,
                          const std::string& path) {
  for (const config::Setting& setting : settings) {
    if (setting.option->key == key) return setting.where;
  }
  return {path, 0, 0};
}

/// What is wrong with the daemon's identity; nothing also without DDS Security.
std::optional<std::string> security_problem(const DdsConfig& config) {
  const std::string& folder = config.security;
  if (folder.empty()) return std::nullopt;
  if (auto problem = gateway::dds::security_problem(folder, config.partition)) return problem;
  if (gateway::dds::may_publish(folder, gateway::dds::topic_info<gateway_GatewayStatus>.name))
    return std::nullopt;
  return fmt::format(
      "{}: is an identity of a client, or older than data model 7 ({}); allowed: one made with --role daemon",
      folder, gateway::dds::security_subject(folder));
}

}  // namespace

void check_surroundings(const DaemonConfig& config, const std::vector<config::Setting>& settings,
                        const std::string& path, const sim::FaultProtocol& faults,
                        std::vector<config::Problem>& problems,
                        std::vector<config::Problem>& script_problems) {
  if (config.bus.kind != BusKind::simulated && !config.sim.trace.empty()) {
    problems.push_back({place_of("sim.trace", settings, path), "sim.trace",
                        fmt::format("found with bus.interface = \"{0}\"; allowed: with the simulated bus "
                                    "alone. A CAN interface is logged with: candump -L {0}",
                                    config.bus.interface)});
    return;
  }
  sim::FaultScript script = fault_script(config, faults);
  auto& taker = script.refused() ? problems : script_problems;
  taker.insert(taker.end(), script.errors.begin(), script.errors.end());
  if (auto wrong = security_problem(config.dds))
    problems.push_back({place_of("dds.security", settings, path), "dds.security", *std::move(wrong)});
}

rt::RealtimeSettings realtime_settings(const RealtimeConfig& config) {
  rt::RealtimeSettings settings;
  settings.enforce = config.mode == RealtimeMode::enforce;
  settings.priority = config.priority;
  settings.cpu = config.cpu;
  settings.lock_memory = config.lock_memory;
  return settings;
}

std::unique_ptr<SyncLine> make_sync_line(const DaemonConfig& config, can::Time interval,
                                         const std::vector<config::Setting>& settings,
                                         const std::string& path) {
  if (config.sync.output == SyncOutput::none && config.sync.input == SyncInput::none) return nullptr;
  try {
    return std::make_unique<SyncLine>(config, interval, sync_line::kernel());
  } catch (const sync_line::SetupError& error) {
    throw std::runtime_error(
        to_string(config::Problem{place_of(error.option(), settings, path), error.option(), error.text()}));
  }
}

void tell_grants(const ServiceLog& log, const rt::RealtimeSettings& wanted, const rt::Grants& granted) {
  log.say(LogPriority::notice, "realtime_granted", realtime_text(wanted, granted, rt::kernel_type()));
  for (const std::string& missing : granted.missing)
    log.say(LogPriority::warning, "realtime_missing", missing);
}

void wait_until_running(const std::function<std::uint64_t()>& wake_ups) {
  constexpr std::chrono::seconds kPatience{5};
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (wake_ups() == 0) {
    if (std::chrono::steady_clock::now() > end)
      throw std::runtime_error(
          fmt::format("the realtime thread has served no interval for {} s; another realtime program may "
                      "keep it from its processor: see realtime.priority and realtime.cpu",
                      kPatience.count()));
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

void tell_trace(const ServiceLog& log, const std::string& path,
                const std::optional<sim::TraceSummary>& summary) {
  if (!summary) return;
  if (summary->error != 0) {
    log.say(LogPriority::error, "trace_failed",
            fmt::format("trace {}: {}", path, std::generic_category().message(summary->error)));
  }
  log.say(LogPriority::info, "trace_ended",
          fmt::format("trace {}: {} written, {} lost", path, text::counted(summary->lines, "line"),
                      summary->lost));
}

}  // namespace cansyncd
