#include "cli/watch/watch_live.h"

#include <algorithm>
#include <deque>
#include <mutex>
#include <utility>

#include "cli/base/interrupt.h"
#include "cli/base/restarts.h"
#include "cli/watch/live_layout.h"
#include "cli/watch/live_model.h"
#include "cli/watch/parameter_turns.h"

namespace cansync::cli {
namespace {

using Clock = std::chrono::steady_clock;
constexpr auto kLook = std::chrono::milliseconds(50);  // a signal is noticed within this time

/// What comes by itself, on its way from the client's thread to this one; the oldest goes when it is full.
class Arrivals {
 public:
  explicit Arrivals(client::Client& client)
      : timing_subscription_(client.on_timing([this](const client::Timing& timing) {
          const std::lock_guard lock(mutex_);
          timings_.push_back(timing);
          if (timings_.size() > kTimingSeconds) timings_.pop_front();
        })),
        event_subscription_(client.on_event([this](const client::Event& event) {
          const std::lock_guard lock(mutex_);
          events_.push_back(event);
          if (events_.size() > kLiveEvents) events_.pop_front();
        })) {}

  void give_to(LiveModel& model) {
    const std::lock_guard lock(mutex_);
    for (const client::Timing& timing : std::exchange(timings_, {})) model.take(timing);
    for (const client::Event& event : std::exchange(events_, {})) model.take(event);
  }

 private:
  std::mutex mutex_;
  std::deque<client::Timing> timings_;
  std::deque<client::Event> events_;
  client::Subscription timing_subscription_;  // end before what their callbacks need
  client::Subscription event_subscription_;
};

/// The view while it runs.
class LiveView {
 public:
  LiveView(Session& session, client::Client& client, LiveScreen& screen, const LiveSettings& settings)
      : client_(client),
        screen_(screen),
        settings_(settings),
        faults_(session),
        turns_(client, settings.parameters, session.monitoring_ms()),
        arrivals_(client),
        restarts_(client) {
    state_.raw = settings.raw;
    if (!settings.parameters.empty()) state_.value = kSlaveValues;
  }

  bool quit() const noexcept { return state_.quit; }
  bool daemon_present() const noexcept { return model_.daemon_present(); }

  void look() {
    const bool present = take_newest();
    model_.set_daemon(present, client_.place());
    if (frozen_) frozen_->set_daemon(present, client_.place());
    for (WatchRow& row : rows_) row.parameters = turns_.of(row.status.slave);
    if (present) turns_.begin_round();
    model_.look(facts_, status_, rows_, wall_clock());
    if (restarts_.take()) model_.tell(wall_clock(), "daemon_restarted", std::string(kStartedAnew));
    restarts_.expect_one();
    arrivals_.give_to(model_);
    for (std::string& problem : turns_.take_problems())
      model_.tell(wall_clock(), "parameter_not_read", std::move(problem));
  }

  void show() {
    screen_.show(live_lines(shown(), state_, screen_.size(), screen_.symbols()), state_.redraw);
    state_.redraw = false;
  }

  /// Waits for a key until `instant`; true when the screen may look different now.
  bool wait(Clock::time_point instant) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(instant - Clock::now());
    const LiveScreen::Input input =
        screen_.input(std::clamp(left, std::chrono::milliseconds(0), std::chrono::milliseconds(kLook)));
    if (!input.key) return input.resized;
    state_ = after_key(state_, *input.key, view_facts(shown(), state_, screen_.size()));
    if (!state_.paused)
      frozen_.reset();
    else if (!frozen_)
      frozen_ = model_;
    return true;
  }

 private:
  /// False: no daemon is there, and what it told last stays.
  bool take_newest() {
    try {
      if (!client_.daemon_present()) return false;
      status_ = client_.master_status();
      facts_ = line_facts(client_);
      rows_ =
          watch_rows(client_, settings_.every_slave ? status_.slaves_configured : settings_.slaves, faults_);
      return true;
    } catch (const client::NoDaemon&) {  // it went meanwhile
      return false;
    }
  }

  const LiveModel& shown() const { return frozen_ ? *frozen_ : model_; }

  client::Client& client_;
  LiveScreen& screen_;
  LiveSettings settings_;
  FaultWords faults_;
  ParameterTurns turns_;
  LiveModel model_;
  std::optional<LiveModel> frozen_;  ///< what is shown while paused
  // The newest from a living daemon.
  client::MasterStatus status_{};
  LineFacts facts_;
  std::vector<WatchRow> rows_;
  ViewState state_;
  Arrivals arrivals_;
  Restarts restarts_;
};

}  // namespace

std::optional<ExitCode> watch_live(Session& session, LiveScreen& screen, const LiveSettings& settings) {
  LiveView view(session, session.client(), screen, settings);
  auto next = Clock::now();
  bool changed = true;
  while (!view.quit() && !interrupt_flag().load()) {
    if (Clock::now() >= next) {
      if (!session.names_changed().empty()) return std::nullopt;
      view.look();
      next = std::max(next + settings.interval, Clock::now());
      changed = true;
    }
    if (changed) view.show();
    changed = view.wait(next);
  }
  return view.daemon_present() ? ExitCode::done : ExitCode::not_reachable;
}

}  // namespace cansync::cli
