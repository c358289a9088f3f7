#include "daemon/daemon.h"

#include <fmt/format.h>

#include <chrono>
#include <csignal>
#include <exception>
#include <memory>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

#include "cansync/dds/topics.h"
#include "cansync/timing.h"
#include "daemon/bus/bus_choice.h"
#include "daemon/cansync/config/reload.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/gateway/gateway.h"
#include "daemon/cansync/realtime/realtime_loop.h"
#include "daemon/loop/realtime_text.h"
#include "daemon/loop/sync_line.h"
#include "daemon/recorder/flight_desk.h"
#include "daemon/service/heartbeat.h"
#include "daemon/service/journal_queue.h"
#include "daemon/service/service.h"
#include "daemon/service/service_log.h"
#include "daemon/service/signal_wait.h"
#include "dds/participant.h"
#include "dds/security.h"
#include "rt/kernel_type.h"
#include "rt/realtime_thread.h"
#include "rt/thread_stack.h"

namespace cansyncd {
namespace {

/// Of the threads of DDS and of our own; the deepest was seen to use under 100 KiB.
constexpr std::size_t kThreadStack = std::size_t{512} * 1024;

ExchangeSizes exchange_sizes(const Config& config) {
  return {config.realtime.request_queue,
          terminals_for(config.master.command_channel, config.realtime.request_queue),
          config.realtime.report_queue};
}

/// Nothing when neither output nor input is configured.
std::unique_ptr<SyncLine> make_sync_line(const ConfigFile& file) {
  const SyncConfig& sync = file.config.sync;
  if (sync.output == SyncOutput::none && sync.input == SyncInput::none) return nullptr;
  try {
    return std::make_unique<SyncLine>(file.config, sync_line::kernel());
  } catch (const sync_line::SetupError& error) {
    Problem problem{{file.path, 0, 0}, error.option(), error.text()};
    for (const Setting& setting : file.settings) {
      if (setting.option->key == error.option()) problem.where = setting.where;
    }
    throw std::runtime_error(to_string(problem));
  }
}

LoopSettings loop_settings(const Config& config, FlightTap* tap, sync_line::SyncWire* wire,
                           SyncLine* sync_line) {
  LoopSettings settings;
  settings.sync_wire = wire;
  settings.sync_line = sync_line;
  settings.target = config.startup.target;
  settings.report_intervals = config.dds.interval_topic;
  settings.tap = tap;
  // The simulated line costs no system call to look at.
  settings.look_at_every_slot = config.bus.kind == BusKind::simulated || config.bus.wake_on_frame;
  return settings;
}

rt::RealtimeSettings realtime_settings(const RealtimeConfig& config) {
  rt::RealtimeSettings settings;
  settings.enforce = config.mode == RealtimeMode::enforce;
  settings.priority = config.priority;
  settings.cpu = config.cpu;
  settings.lock_memory = config.lock_memory;
  return settings;
}

/// Everything that runs, in the order it is built; taken down the other way round.
class Daemon {
 public:
  /// Throws std::runtime_error (of the SYNC line), std::system_error or gateway::dds::SetupError for what
  /// cannot be had.
  Daemon(ConfigFile file, JournalSink& journal)
      : file_(std::move(file)),
        log_(file_.config.bus.name, journal),
        bus_(file_.config),
        sync_line_(make_sync_line(file_)),
        exchange_(exchange_sizes(file_.config)),
        participant_({file_.config.dds.domain, file_.config.dds.partition, file_.config.dds.interface,
                      file_.config.dds.xml, file_.config.dds.security, true}),
        gateway_(file_.config, exchange_, participant_, journal),
        flight_(
            file_.config, bus_.bus(), [this](const EventText& event) { gateway_.post(event); }, journal),
        loop_(file_.config.master,
              loop_settings(file_.config, flight_.tap(), bus_.sync_wire(), sync_line_.get()), flight_.bus(),
              exchange_) {}

  ~Daemon() { stop(); }
  Daemon(const Daemon&) = delete;
  Daemon& operator=(const Daemon&) = delete;

  /// Throws rt::RealtimeError when realtime is enforced and not granted, std::system_error without threads.
  void start() {
    const rt::RealtimeSettings settings = realtime_settings(file_.config.realtime);
    if (sync_line_) sync_line_->start();
    thread_.emplace(settings, [this] { loop_.run(); });
    log_.say(LogPriority::notice, "realtime_granted",
             realtime_text(settings, thread_->grants(), rt::kernel_type()));
    for (const std::string& missing : thread_->grants().missing)
      log_.say(LogPriority::warning, "realtime_missing", missing);
    gateway_.set_realtime(settings, thread_->grants());
    if (const std::string advice = bus_.advice(); !advice.empty())
      log_.say(LogPriority::warning, "not_one_shot", advice);
    bus_.start(exchange_);
    gateway_.start();
    wait_until_running();
    const auto& times = cansync::slot_times(file_.config.master.bit_rate);
    log_.say(LogPriority::notice, "daemon_running",
             fmt::format("running: bus {} ({}) at {} bit/s, {} slaves, {}", file_.config.bus.name,
                         file_.config.bus.interface, times.bits_per_second,
                         __builtin_popcount(file_.config.master.configured().bits), participant_.place()));
    service::ready();
  }

  /// How far the threads have come, for the watchdog.
  Heartbeat::Progress progress() const noexcept { return {loop_.wake_ups(), gateway_.passes()}; }

  /// Open jobs are answered first by the realtime thread, then by the gateway.
  void stop() noexcept {
    if (!thread_) return;
    loop_.request_stop();
    thread_.reset();
    flight_.stop();
    bus_.stop();
    gateway_.stop();
    report_trace();
  }

  /// Saves what the flight recorder has.
  void record() noexcept {
    if (!flight_.request())
      log_.say(LogPriority::warning, "recorder_off", "no flight recording: the flight recorder is off");
  }

  void reload(const std::vector<std::string>& overrides) {
    service::reloading();
    ConfigFile wanted = load_checked(file_.path, overrides);
    if (!wanted.problems.empty()) {
      log_.say(LogPriority::error, "reload_refused",
               file_.path + " is wrong; the daemon keeps running as before", {{"CANSYNC_FILE", file_.path}});
      log_.problems(wanted.problems);
    } else {
      apply(plan_reload(file_, wanted));
    }
    service::ready();
  }

 private:
  /// The service is ready when SYNC edges are served, not when a thread was asked for. Throws
  /// std::runtime_error.
  void wait_until_running() const {
    constexpr std::chrono::seconds kPatience{10};
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (loop_.wake_ups() == 0) {
      if (std::chrono::steady_clock::now() > end)
        throw std::runtime_error(
            fmt::format("the realtime thread has served no interval for {} s; another realtime program may "
                        "keep it from its processor: see realtime.priority and realtime.cpu",
                        kPatience.count()));
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }

  void apply(ReloadPlan plan) {
    if (!plan.merged.problems.empty()) {
      log_.say(
          LogPriority::error, "reload_refused",
          fmt::format("the changes of {} need a restart; the daemon keeps running as before", file_.path),
          {{"CANSYNC_FILE", file_.path}});
      log_.problems(plan.merged.problems);
      return;
    }
    for (const std::string& key : plan.applied)
      log_.say(LogPriority::notice, "setting_changed", "changed: " + key, {{"CANSYNC_OPTION", key}});
    for (const std::string& key : plan.needs_restart) {
      log_.say(LogPriority::warning, "setting_needs_restart",
               fmt::format("not changed: {} takes effect after a restart", key), {{"CANSYNC_OPTION", key}});
    }
    if (plan.applied.empty() && plan.needs_restart.empty())
      log_.say(LogPriority::notice, "reload_without_change", "nothing has changed");
    file_ = std::move(plan.merged);
    gateway_.reload(file_.config);
  }

  void report_trace() noexcept {
    const std::optional<sim::TraceSummary> summary = bus_.close_trace();
    if (!summary) return;
    const std::string& path = file_.config.sim.trace;
    if (summary->error != 0) {
      log_.say(LogPriority::error, "trace_failed",
               fmt::format("trace {}: {}", path, std::generic_category().message(summary->error)));
    }
    log_.say(LogPriority::info, "trace_ended",
             fmt::format("trace {}: {} lines written, {} lost", path, summary->lines, summary->lost));
  }

  ConfigFile file_;
  const ServiceLog log_;
  BusChoice bus_;
  std::unique_ptr<SyncLine> sync_line_;
  Exchange exchange_;
  gateway::dds::Participant participant_;
  Gateway gateway_;
  FlightDesk flight_;
  RealtimeLoop loop_;
  std::optional<rt::RealtimeThread> thread_;
};

/// Until SIGTERM or SIGINT.
void serve(Daemon& daemon, const SignalWait& signals, const std::vector<std::string>& overrides,
           const ServiceLog& log) {
  Heartbeat heartbeat(service::watchdog());
  while (true) {
    const std::optional<int> number = signals.wait(heartbeat.period());
    if (!number) {
      if (heartbeat.look(daemon.progress())) service::alive();
      continue;
    }
    if (*number == SIGHUP) {
      daemon.reload(overrides);
      continue;
    }
    if (*number == SIGUSR1) {
      daemon.record();
      continue;
    }
    log.say(LogPriority::notice, "daemon_stopping",
            *number == SIGTERM ? "stopping: SIGTERM" : "stopping: SIGINT");
    service::stopping();
    return;
  }
}

/// What is wrong with the daemon's identity; nothing also without DDS Security.
std::optional<std::string> security_problem(const Config& config) {
  const std::string& folder = config.dds.security;
  if (folder.empty()) return std::nullopt;
  if (auto problem = gateway::dds::security_problem(folder, config.dds.partition)) return problem;
  if (gateway::dds::may_publish(folder, gateway::dds::topic_info<cansync_MasterStatus>.name))
    return std::nullopt;
  return fmt::format("{}: is an identity of a client ({}); allowed: one made with --role daemon", folder,
                     gateway::dds::security_subject(folder));
}

}  // namespace

ConfigFile load_checked(const std::string& path, const std::vector<std::string>& overrides) {
  ConfigFile file = load_config(path, overrides);
  if (!file.problems.empty()) return file;
  if (file.config.bus.kind != BusKind::simulated && !file.config.sim.trace.empty()) {
    Position where{path, 0, 0};
    for (const Setting& setting : file.settings) {
      if (setting.option->key == "sim.trace") where = setting.where;
    }
    file.problems.push_back(
        {where, "sim.trace",
         fmt::format("found with bus.interface = \"{0}\"; allowed: with the simulated bus alone. A CAN "
                     "interface is logged with: candump -L {0}",
                     file.config.bus.interface)});
    return file;
  }
  file.problems = check_fault_script(file.config);
  if (const auto wrong = security_problem(file.config)) {
    Position where{path, 0, 0};
    for (const Setting& setting : file.settings) {
      if (setting.option->key == "dds.security") where = setting.where;
    }
    file.problems.push_back({where, "dds.security", *wrong});
  }
  return file;
}

int run_daemon(ConfigFile file, const std::vector<std::string>& overrides) {
  const SignalWait signals;
  const bool small_stacks = rt::set_default_stack_size(kThreadStack);
  JournalQueue journal(process_journal(), file.config.bus.name);
  const ServiceLog log(file.config.bus.name, journal);
  if (!small_stacks) {
    log.say(LogPriority::warning, "stack_size_kept",
            "thread stacks keep the system's size; locked memory will be larger");
  }
  try {
    Daemon daemon(std::move(file), journal);
    daemon.start();
    serve(daemon, signals, overrides, log);
    daemon.stop();
  } catch (const std::exception& error) {
    log.say(LogPriority::error, "daemon_cannot_run", fmt::format("cannot run: {}", error.what()));
    return exit_code::cannot_start;
  }
  log.say(LogPriority::notice, "daemon_stopped", "stopped");
  return exit_code::done;
}

}  // namespace cansyncd
