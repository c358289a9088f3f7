#pragma once

#include <fmt/format.h>

#include <memory>
#include <span>
#include <string>
#include <utility>

#include "config/reload.h"
#include "daemon/bus/bus_choice.h"
#include "daemon/loop/deadline_loop.h"
#include "daemon/loop/sync_line.h"
#include "daemon/recorder/flight_desk.h"
#include "daemon/segment/protocol.h"
#include "daemon/segment/segment.h"
#include "daemon/segment/segment_threads.h"
#include "daemon/service/journal.h"
#include "daemon/service/service_log.h"
#include "dds/participant.h"

namespace cansyncd {

/// What most protocols have in common of `Parts`, below.
struct DeadlineParts {
  /// The SYNC line; null: none.
  template <class File>
  static std::unique_ptr<SyncLine> sync_line(const File& /*file*/) {
    return nullptr;
  }
  template <class Config>
  static FlightProtocol flight(const Config& /*config*/) {
    return {};
  }
};

/// A protocol on one bus whose machine `DeadlineLoop` drives: everything that runs, in the order it is built;
/// taken down the other way round. What differs from protocol to protocol `Parts` says, which derives from
/// `DeadlineParts`:
///
/// - the types `File` (LoadedFile), `Exchange`, `Gateway` (made with `given(file)`, the exchange, the
///   participant and the journal), `Machine` (made with its settings, a bus and the exchange);
/// - `load(source, overrides)`: reads and checks completely; `build(settings, path)`: makes a file of settings;
/// - `bus_plan(config)`, `exchange(config)`, `given(file)`;
/// - `machine_settings(config, tap, sync)`: `tap` is the flight recorder's, or null; `sync` are SyncSources;
/// - `words(config)`: what is served, in the words of the log; `check_text(config)`: in those of `--check`.
template <class Parts>
class DeadlineSegment final : public Segment {
 public:
  using File = typename Parts::File;

  /// `file` has no problems; `journal` must outlive the segment. Throws std::runtime_error, std::system_error
  /// or gateway::dds::SetupError for what cannot be had.
  DeadlineSegment(File file, JournalSink& journal, gateway::dds::Participant participant)
      : file_(std::move(file)),
        log_(file_.config.bus.name, journal),
        bus_(Parts::bus_plan(file_.config)),
        sync_line_(Parts::sync_line(file_)),
        exchange_(Parts::exchange(file_.config)),
        participant_(std::move(participant)),
        gateway_(Parts::given(file_), exchange_, participant_, journal),
        flight_(
            file_.config, Parts::flight(file_.config), bus_.bus(),
            [this](const EventText& event) { gateway_.post(event); }, journal),
        machine_(Parts::machine_settings(file_.config, flight_.tap(), {sync_line_.get(), bus_.sync_edges()}),
                 flight_.bus(), exchange_),
        loop_(machine_, flight_.bus()),
        threads_(log_, loop_, {log_, file_.config, bus_, flight_, gateway_, exchange_}) {}
  ~DeadlineSegment() override { stop(); }
  DeadlineSegment(const DeadlineSegment&) = delete;
  DeadlineSegment& operator=(const DeadlineSegment&) = delete;

  void start() override {
    if (sync_line_) sync_line_->start();
    threads_.start(file_.config.realtime);
    log_.say(LogPriority::notice, "daemon_running",
             fmt::format("running: bus {} ({}) at {} bit/s, {}, {}", file_.config.bus.name,
                         file_.config.bus.interface, file_.config.bus.bits_per_second,
                         Parts::words(file_.config), participant_.place()));
  }
  void end_realtime() noexcept override { threads_.end_realtime(); }
  void stop() noexcept override { threads_.stop(); }
  Heartbeat::Progress progress() const noexcept override { return {loop_.wake_ups(), gateway_.passes()}; }
  bool record() noexcept override { return flight_.request(); }
  void post(const EventText& event) override { gateway_.post(event); }
  void set_surroundings(const Surroundings& surroundings) override {
    gateway_.set_surroundings(surroundings);
  }
  bool in_run() const noexcept override { return gateway_.in_run(); }
  void set_pending_restart(const PendingRestart& pending) override { gateway_.set_pending_restart(pending); }

  /// Every option that can change does so by itself.
  ReloadPlan plan_reload(std::span<const std::string> overrides) override {
    File wanted = Parts::load(file_.path, overrides);
    if (auto wrong = refused_by_reload(wanted); !wrong.empty()) return {true, std::move(wrong), {}, {}, {}};
    config::Changes changes =
        config::compare(file_.settings, wanted.settings, [](const config::Setting&) { return true; });
    File merged = Parts::build(std::move(changes.merged), file_.path);
    if (!merged.problems.empty()) return {false, std::move(merged.problems), {}, {}, {}};
    const auto apply = [this, merged = std::move(merged)] {
      file_ = merged;
      gateway_.reload(file_.config);
    };
    return {false, {}, std::move(changes.applied), std::move(changes.needs_restart), apply};
  }

 private:
  using Loop = DeadlineLoop<typename Parts::Machine>;

  File file_;
  const ServiceLog log_;
  BusChoice bus_;
  std::unique_ptr<SyncLine> sync_line_;
  typename Parts::Exchange exchange_;
  gateway::dds::Participant participant_;
  typename Parts::Gateway gateway_;
  FlightDesk flight_;
  typename Parts::Machine machine_;
  Loop loop_;
  SegmentThreads<Loop, SegmentSide<typename Parts::Gateway, typename Parts::Exchange>> threads_;
};

/// `ProtocolInfo::load` of such a protocol.
template <class Parts>
LoadedConfig load_for_deadline_segment(const config::Source& source, std::span<const std::string> overrides) {
  const auto file = std::make_shared<typename Parts::File>(Parts::load(source, overrides));
  LoadedConfig loaded;
  loaded.problems = file->problems;
  loaded.script_problems = file->script_problems;
  loaded.daemon = file->config;
  if (!loaded.problems.empty()) return loaded;
  loaded.check_text = Parts::check_text(file->config);
  loaded.make_segment = [file](JournalSink& journal, std::span<gateway::dds::Participant> participants) {
    return std::make_unique<DeadlineSegment<Parts>>(std::move(*file), journal,
                                                    std::move(participants.front()));
  };
  return loaded;
}

}  // namespace cansyncd
