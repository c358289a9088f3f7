#include "daemon/daemon.h"

#include <fmt/format.h>

#include <csignal>
#include <cstddef>
#include <exception>
#include <memory>
#include <optional>

#include "daemon/segment/segment.h"
#include "daemon/service/heartbeat.h"
#include "daemon/service/journal_queue.h"
#include "daemon/service/service.h"
#include "daemon/service/service_log.h"
#include "daemon/service/signal_wait.h"
#include "rt/thread_stack.h"

namespace cansyncd {
namespace {

/// Of the threads of DDS and of our own; the deepest was seen to use under 100 KiB.
constexpr std::size_t kThreadStack = std::size_t{512} * 1024;

void tell_changes(const ReloadPlan& plan, const ServiceLog& log) {
  for (const std::string& key : plan.applied)
    log.say(LogPriority::notice, "setting_changed", "changed: " + key, {{"CANSYNC_OPTION", key}});
  for (const std::string& key : plan.needs_restart) {
    log.say(LogPriority::warning, "setting_needs_restart",
            fmt::format("not changed: {} takes effect after a restart", key), {{"CANSYNC_OPTION", key}});
  }
  if (plan.applied.empty() && plan.needs_restart.empty())
    log.say(LogPriority::notice, "reload_without_change", "nothing has changed");
}

void reload(Segment& segment, const std::string& path, std::span<const std::string> overrides,
            const ServiceLog& log) {
  service::reloading();
  const ReloadPlan plan = segment.plan_reload(overrides);
  if (!plan.problems.empty()) {
    log.say(LogPriority::error, "reload_refused",
            plan.file_wrong
                ? fmt::format("{} is wrong; the daemon keeps running as before", path)
                : fmt::format("the changes of {} need a restart; the daemon keeps running as before", path),
            {{"CANSYNC_FILE", path}});
    log.problems(plan.problems);
  } else {
    tell_changes(plan, log);
    plan.apply();
  }
  service::ready();
}

/// Until SIGTERM or SIGINT.
void serve(Segment& segment, const SignalWait& signals, const std::string& path,
           std::span<const std::string> overrides, const ServiceLog& log) {
  Heartbeat heartbeat(service::watchdog());
  while (true) {
    const std::optional<int> number = signals.wait(heartbeat.period());
    if (!number) {
      if (heartbeat.look(segment.progress())) service::alive();
      continue;
    }
    if (*number == SIGHUP) {
      reload(segment, path, overrides, log);
      continue;
    }
    if (*number == SIGUSR1) {
      if (!segment.record())
        log.say(LogPriority::warning, "recorder_off", "no flight recording: the flight recorder is off");
      continue;
    }
    log.say(LogPriority::notice, "daemon_stopping",
            *number == SIGTERM ? "stopping: SIGTERM" : "stopping: SIGINT");
    service::stopping();
    return;
  }
}

}  // namespace

int run_daemon(const LoadedConfig& config, const std::string& path, std::span<const std::string> overrides) {
  const SignalWait signals;
  const bool small_stacks = rt::set_default_stack_size(kThreadStack);
  JournalQueue journal(process_journal(), config.bus_name);
  const ServiceLog log(config.bus_name, journal);
  if (!small_stacks) {
    log.say(LogPriority::warning, "stack_size_kept",
            "thread stacks keep the system's size; locked memory will be larger");
  }
  try {
    const std::unique_ptr<Segment> segment = config.make_segment(journal);
    segment->start();
    service::ready();
    serve(*segment, signals, path, overrides, log);
    segment->stop();
  } catch (const std::exception& error) {
    log.say(LogPriority::error, "daemon_cannot_run", fmt::format("cannot run: {}", error.what()));
    return exit_code::cannot_start;
  }
  log.say(LogPriority::notice, "daemon_stopped", "stopped");
  return exit_code::done;
}

}  // namespace cansyncd
