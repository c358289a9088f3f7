#include "daemon/daemon.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <future>
#include <list>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "daemon/host_watch.h"
#include "daemon/segment/bus_network.h"
#include "daemon/segment/bus_participants.h"
#include "daemon/segment/segment.h"
#include "daemon/service/bus_prefix.h"
#include "daemon/service/heartbeat.h"
#include "daemon/service/journal_queue.h"
#include "daemon/service/service.h"
#include "daemon/service/service_log.h"
#include "daemon/service/signal_wait.h"
#include "rt/thread_stack.h"
#include "text/counts.h"

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
  if (plan.applied.empty() && plan.needs_restart.empty() && plan.needs_set_up.empty())
    log.say(LogPriority::notice, "reload_without_change", "nothing has changed");
}

/// One bus of the process.
struct Bus {
  Bus(const LoadedConfig& from, JournalSink& to)
      : config(from), journal(to), log(from.daemon.bus.name, to), network(from.served()) {}
  const LoadedConfig& config;
  JournalSink& journal;
  const ServiceLog log;
  std::unique_ptr<Segment> segment;
  std::optional<ConfigurationWatch> watch;
  BusNetwork network;

  /// Tells the segment what is true around it.
  void tell_surroundings() {
    segment->set_surroundings({watch ? watch->reason() : std::string(), network.place(), network.taken_by()});
  }
};
/// None of them moves: a segment is made when its place is there.
using Buses = std::list<Bus>;

/// Makes a segment in the place of one that was stopped; empty, or why it cannot be had.
std::string make_segment(Bus& bus, const ReloadPlan::Maker& maker) {
  bus.segment.reset();
  service::at_work();  // stopping and starting take their time, and a start may have to be given up
  try {
    bus.segment = maker(bus.journal);
    bus.segment->start();
    return {};
  } catch (const std::exception& error) {
    bus.segment.reset();
    return error.what();
  }
}

/// Puts another segment into the place of one that was stopped. When it cannot be had, the one before is made
/// anew, and the plan says why; without that, too, the bus has none.
void replace(Bus& bus, ReloadPlan& plan) {
  const std::string failed = make_segment(bus, plan.anew);
  if (failed.empty()) return;
  bus.log.say(LogPriority::error, "reload_refused",
              fmt::format("the line cannot be set up with the changes: {}; it is set up as before", failed));
  plan.problems.push_back({{}, {}, "the line cannot be set up with the changes: " + failed});
  if (const std::string none = make_segment(bus, plan.as_before); !none.empty()) {
    bus.log.say(
        LogPriority::error, "reload_refused",
        fmt::format("the line cannot be set up as before: {}; this bus has ended, restart the daemon", none));
    const std::string& name = bus.config.daemon.bus.name;
    service::status(name, fmt::format("ended, restart the daemon; bus {}", name));
  }
}

/// Keys that keep their running value although the line could be set up anew for them.
void tell_active(const ReloadPlan& plan, const ServiceLog& log) {
  for (const std::string& key : plan.needs_set_up) {
    log.say(LogPriority::warning, "setting_needs_restart",
            fmt::format("not changed: {} takes effect when the line is set up anew, and it is in run: "
                        "cansync mode stop, then reload once more; or restart",
                        key),
            {{"CANSYNC_OPTION", key}});
  }
}

/// True when the line was set up anew for what has changed.
bool set_up_anew(Bus& bus, ReloadPlan& plan) {
  if (plan.needs_set_up.empty()) return false;
  std::erase_if(plan.needs_restart, [&](const std::string& key) {
    return std::find(plan.needs_set_up.begin(), plan.needs_set_up.end(), key) != plan.needs_set_up.end();
  });
  if (!bus.segment->stop_unless_active()) {
    tell_active(plan, bus.log);
    return false;
  }
  const std::vector<std::string> taken = std::exchange(plan.needs_set_up, {});
  replace(bus, plan);
  if (!plan.problems.empty()) return true;
  plan.applied.insert(plan.applied.end(), taken.begin(), taken.end());
  tell_changes(plan, bus.log);
  return true;
}

std::int64_t wall_seconds() {
  return std::chrono::duration_cast<std::chrono::seconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

void keep(const Bus& bus, const KeptConfigurations& kept, const std::string& text) {
  if (const auto failed = kept.keep(bus.config.path, text)) {
    bus.log.say(LogPriority::warning, "configuration_not_kept",
                fmt::format("the configuration is not kept for a start with a wrong file: {}", *failed));
  }
}

/// Says what is left out of a file that the configuration names, and what that costs.
void tell_left_out(const Bus& bus, const std::vector<config::Problem>& problems, EventCode code,
                   std::string_view cost) {
  const std::size_t shown = std::min(problems.size(), config::kProblemsShown);
  for (std::size_t i = 0; i < shown; ++i)
    bus.segment->post({gateway_SEVERITY_ERROR, code, -1, fmt::format("{}: {}", cost, to_string(problems[i])),
                       std::nullopt});
  if (problems.size() > shown)
    bus.segment->post(
        {gateway_SEVERITY_ERROR, code, -1,
         fmt::format("{}: and {}", cost, text::counted(problems.size() - shown, "more problem")),
         std::nullopt});
}

/// Compares the file with what runs from the start on, and says with what the bus has started.
void watch_from_start(Bus& bus, const Continuity& continuity) {
  if (!continuity.load) return;
  const LoadedConfig& file = bus.config;
  if (file.kept_since.empty()) keep(bus, continuity.kept, file.text.value_or(""));
  bus.watch.emplace(file, continuity.load, wall_seconds());
  (void)bus.watch->look();
  tell_left_out(bus, file.profile_problems, "profile_unusable",
                "no names of parameters and no limits for writes");
  tell_left_out(bus, file.script_problems, "fault_left_out", "a fault of the script is left out");
  if (!file.kept_since.empty())
    bus.segment->post(
        {gateway_SEVERITY_ERROR, "configuration_last_good", -1, bus.watch->reason(), std::nullopt});
}

/// Says so when the file on disk has become another than the one that runs, or the same.
void look_at_file(Bus& bus) {
  if (!bus.watch || !bus.watch->look()) return;
  bus.tell_surroundings();
  if (!bus.watch->differs()) {
    bus.segment->post({gateway_SEVERITY_INFO, "configuration_agrees", -1,
                       bus.config.path + " is the configuration that runs", std::nullopt});
  } else {
    bus.segment->post({bus.watch->wrong() ? gateway_SEVERITY_ERROR : gateway_SEVERITY_WARNING,
                       "configuration_differs", -1, bus.watch->reason(), std::nullopt});
  }
}

/// What a reload has made of the file, `text` before it.
void reloaded(Bus& bus, const ReloadPlan& plan, const std::string& text, const Continuity& continuity) {
  if (!bus.segment) return;
  bus.tell_surroundings();  // it may be another segment
  if (!bus.watch) return;
  if (plan.problems.empty()) {
    const bool completely = plan.needs_restart.empty() && plan.needs_set_up.empty();
    bus.watch->taken(text, completely ? "" : not_taken(plan), wall_seconds());
    if (completely) {
      service::at_work();  // what follows waits for the disk
      keep(bus, continuity.kept, text);
    }
  }
  look_at_file(bus);
  bus.tell_surroundings();
}

void reload(Bus& bus, std::span<const std::string> overrides, const Continuity& continuity) {
  const std::string& path = bus.config.path;
  const std::string text = config::read_source(path).text.value_or("");
  ReloadPlan plan = bus.segment->plan_reload(overrides);
  if (!plan.problems.empty()) {
    bus.log.say(
        LogPriority::error, "reload_refused",
        plan.file_wrong
            ? fmt::format("{} is wrong; the daemon keeps running as before", path)
            : fmt::format("the changes of {} need a restart; the daemon keeps running as before", path),
        {{"CANSYNC_FILE", path}});
    bus.log.problems(plan.problems);
  } else if (!set_up_anew(bus, plan)) {
    tell_changes(plan, bus.log);
    plan.apply();
  }
  if (bus.segment) bus.segment->tell_reload(plan);
  reloaded(bus, plan, text, continuity);
}

/// All of them; one that cannot be had any more ends, and the others go on. Throws when that was the last.
void reload(Buses& buses, std::span<const std::string> overrides, const Continuity& continuity) {
  service::reloading();
  for (Bus& bus : buses) reload(bus, overrides, continuity);
  buses.remove_if([](const Bus& bus) { return bus.segment == nullptr; });
  if (buses.empty()) throw std::runtime_error("no bus is left after the reload");
  service::ready();
}

/// Of each bus, in their order.
std::vector<Heartbeat::Progress> progress(const Buses& buses) {
  std::vector<Heartbeat::Progress> all;
  for (const Bus& bus : buses) all.push_back(bus.segment->progress());
  return all;
}

std::vector<Segment*> segments_of(const Buses& buses) {
  std::vector<Segment*> all;
  for (const Bus& bus : buses) all.push_back(bus.segment.get());
  return all;
}

void record(const Buses& buses) {
  for (const Bus& bus : buses) {
    if (!bus.segment->record())
      bus.log.say(LogPriority::warning, "recorder_off", "no flight recording: the flight recorder is off");
  }
}

/// Until SIGTERM or SIGINT.
void serve(Buses& buses, const SignalWait& signals, std::span<const std::string> overrides, HostWatch& host,
           const ServiceLog& log, const Continuity& continuity) {
  using std::chrono::microseconds;
  using std::chrono::steady_clock;
  Heartbeat heartbeat(service::watchdog());
  const microseconds period =
      std::min<microseconds>(heartbeat.period().value_or(HostWatch::kPeriod), HostWatch::kPeriod);
  steady_clock::time_point next = steady_clock::now() + period;
  while (true) {
    const auto left = std::chrono::ceil<microseconds>(next - steady_clock::now());
    const std::optional<int> number = signals.wait(std::max(left, microseconds(0)));
    if (number && (*number == SIGTERM || *number == SIGINT)) {
      log.say(LogPriority::notice, "daemon_stopping",
              host.shuts_down()    ? "stopping: the computer shuts down"
              : *number == SIGTERM ? "stopping: SIGTERM"
                                   : "stopping: SIGINT");
      return;
    }
    if (number == SIGHUP) {
      reload(buses, overrides, continuity);
      host.look_again(segments_of(buses));
    } else if (number == SIGUSR1) {
      record(buses);
    }
    // However often signals come, this has its turn.
    if (steady_clock::now() < next) continue;
    if (heartbeat.look(progress(buses))) service::alive();
    for (Bus& bus : buses) {
      look_at_file(bus);
      if (bus.network.look()) bus.tell_surroundings();
    }
    host.step(segments_of(buses));
    next = steady_clock::now() + period;
  }
}

/// Every line stands still before the first client is waited for; and a client that hangs holds up its bus alone.
void stop(Buses& buses) {
  service::stopping();
  for (const Bus& bus : buses) bus.segment->end_realtime();
  std::vector<std::future<void>> ends;
  for (Bus& bus : buses)
    ends.push_back(std::async(std::launch::async, [&segment = bus.segment] {
      segment->stop();
      segment.reset();
    }));
  for (const std::future<void>& end : ends) end.wait();
}

/// Does something for one of several buses; what cannot be had names the bus's file then.
template <class Step>
void for_bus(const Buses& buses, const Bus& bus, const Step& step) {
  if (buses.size() == 1) return step();
  try {
    step();
  } catch (const std::exception& error) {
    throw std::runtime_error(bus.config.path + ": " + error.what());
  }
}

/// Everything that buses need is taken before any of them runs; should the start of one fail all the same,
/// those that run already end with it.
void start(Buses& buses) {
  std::vector<const DaemonConfig*> configs;
  std::vector<NetworkPlace> places;
  for (const Bus& bus : buses) {
    for (const DaemonConfig& served : bus.config.served()) {
      configs.push_back(&served);
      places.push_back(bus.network.place());
    }
  }
  std::vector<BusParticipant> participants = bus_participants(configs, places);
  auto next = participants.begin();
  for (Bus& bus : buses) {
    std::vector<gateway::dds::Participant> own;
    for (std::size_t i = 0; i < bus.config.served().size(); ++i, ++next) {
      if (!next->taken_by.empty()) bus.network.set_taken_by(next->taken_by);
      own.push_back(std::move(next->participant));
    }
    for_bus(buses, bus, [&] { bus.segment = bus.config.make_segment(bus.journal, own); });
  }
  for (const Bus& bus : buses) for_bus(buses, bus, [&] { bus.segment->start(); });
}

std::string names_of(std::span<const LoadedConfig> files) {
  std::string names;
  for (const LoadedConfig& file : files) names += (names.empty() ? "" : ",") + file.daemon.bus.name;
  return names;
}

}  // namespace

int run_daemon(std::span<const LoadedConfig> files, std::span<const std::string> overrides,
               const Continuity& continuity) {
  const SignalWait signals;
  const bool small_stacks = rt::set_default_stack_size(kThreadStack);
  BusPrefix with_names(process_journal());
  const bool several = files.size() > 1 || files.front().served().size() > 1;
  JournalSink& sink = several ? with_names : process_journal();
  JournalQueue journal(sink, names_of(files));
  const ServiceLog log(names_of(files), journal);
  if (!small_stacks) {
    log.say(LogPriority::warning, "stack_size_kept",
            "thread stacks keep the system's size; locked memory will be larger");
  }
  try {
    Buses buses;
    for (const LoadedConfig& file : files) buses.emplace_back(file, journal);
    start(buses);
    for (Bus& bus : buses) {
      watch_from_start(bus, continuity);
      bus.tell_surroundings();
    }
    service::ready();
    HostWatch host;  // a shutdown waits for it, that is until every line is stopped
    serve(buses, signals, overrides, host, log, continuity);
    stop(buses);
  } catch (const std::exception& error) {
    log.cannot_run(error.what());
    return exit_code::cannot_start;
  }
  log.say(LogPriority::notice, "daemon_stopped", "stopped");
  return exit_code::done;
}

}  // namespace cansyncd
