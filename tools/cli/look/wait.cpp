#include <fmt/format.h>

#include <algorithm>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>

#include "cli/base/interrupt.h"
#include "cli/base/restarts.h"
#include "cli/base/verb_groups.h"
#include "cli/cansync/wait_states.h"
#include "cli/cansync/wait_value.h"
#include "cli/look/verbs.h"
#include "cli/text/column_help.h"
#include "cli/text/slave_list.h"
#include "cli/text/values.h"

namespace cansync::cli {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kLook = std::chrono::milliseconds(50);  // for Ctrl-C
// A shorter search would take a daemon that answers late for gone.
constexpr auto kNobodyThere = std::chrono::milliseconds(3000);
constexpr auto kSearch = std::chrono::milliseconds(2000);  // for the daemon, at a time

/// The arguments as they were typed.
struct WaitTexts {
  std::string state;
  std::vector<std::string> slaves;
};

/// Wakes the waiting thread at each status that comes. Outlives the subscriptions it makes.
class Changes {
 public:
  Changes(client::Client& client, WaitState::Of of) {
    if (of == WaitState::Of::master)
      subscription_ = client.on_master_status([this](const client::MasterStatus&) { raise(); });
    if (of == WaitState::Of::slaves)
      subscription_ = client.on_slave_status([this](const client::SlaveStatus&) { raise(); });
  }

  void wait_until(Clock::time_point instant) {
    std::unique_lock lock(mutex_);
    changed_.wait_until(lock, instant, [this] { return raised_; });
    raised_ = false;
  }

 private:
  void raise() {
    {
      const std::lock_guard lock(mutex_);
      raised_ = true;
    }
    changed_.notify_one();
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  bool raised_ = false;
  client::Subscription subscription_;  // ended before what it uses
};

/// One run of the verb.
class Wait {
 public:
  Wait(Session& session, const WaitTexts& texts, const WaitState& state)
      : session_(session), texts_(texts), state_(state), start_(Clock::now()) {
    if (const auto seconds = session.globals().timeout)
      end_ = start_ + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(*seconds));
  }

  ExitCode run() {
    bool reached = false;
    do {
      reached = look();
    } while (!reached && !over());
    const double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
    client::Reply reply{client::ReplyCode::done, ""};
    if (!reached) {
      const bool stopped = interrupt_flag().load();
      reply.code = stopped ? client::ReplyCode::cancelled : client::ReplyCode::timeout;
      reply.reason = fmt::format("{} {:.1f} s; seen last: {}",
                                 stopped ? "cancelled after" : "not reached within", seconds, seen_);
    }
    JsonObject object;
    object.add("state", texts_.state);
    if (state_.of == WaitState::Of::slaves && mask_ != 0) {
      object.add("slave_mask", mask_);
    } else {
      object.add_null("slave_mask");
    }
    object.add("reached", reached).add("seconds", seconds);
    return session_.finish(reply, object, "wait " + texts_.state,
                           fmt::format("{} is reached after {:.1f} s", texts_.state, seconds));
  }

 private:
  bool over() const { return interrupt_flag().load() || Clock::now() >= end_; }

  /// Looks for the daemon, then at it, until the state is reached, the daemon goes or the time is over.
  bool look() {
    const bool wants_none = state_.of == WaitState::Of::nobody;
    client::Client* client = session_.look_for_daemon(std::min(wants_none ? kNobodyThere : kSearch, left()));
    if (client == nullptr) {
      seen_ = "no daemon";
      return wants_none && !interrupt_flag().load();
    }
    if (state_.of == WaitState::Of::daemon) return true;
    Changes changes(*client, state_.of);
    Restarts restarts(*client);
    for (;;) {
      if (restarts.gone()) {
        seen_ = "no daemon";
        return wants_none && !interrupt_flag().load();
      }
      if (restarts.take()) session_.output().remark(kStartedAnew);
      restarts.expect_one();
      if (const auto now = look_at(*client)) {
        seen_ = seen(state_, *now);
        if (is_reached(state_, *now)) return true;
      }
      if (over()) return false;
      changes.wait_until(std::min(end_, Clock::now() + kLook));
    }
  }

  /// Nothing: the daemon has just gone, or names are being exchanged.
  std::optional<WaitLook> look_at(const client::Client& client) {
    WaitLook now{};
    try {
      now.wanted = slaves_meant();
      if (state_.of == WaitState::Of::master || state_.of == WaitState::Of::slaves)
        now.master = client.master_status();
      if (state_.of == WaitState::Of::slaves) now.slaves = client.slaves(std::chrono::milliseconds(0));
      if (state_.of == WaitState::Of::controller)
        now.controller = client::text(client.bus_status().controller_state);
    } catch (const client::OtherProtocol&) {
      throw;
    } catch (const client::NoDaemon&) {
      return std::nullopt;
    } catch (const UsageError& error) {
      constexpr std::chrono::seconds kExchange(2);
      if (mask_ == 0 || Clock::now() >= named_ + kExchange) throw;
      seen_ = error.what();
      return std::nullopt;
    }
    return now;
  }

  /// Those that bear the names now: a reload gives them to others. Throws UsageError for a name that none or two bear.
  std::uint32_t slaves_meant() {
    if (state_.of != WaitState::Of::slaves) return 0;
    const std::uint32_t mask = session_.configured_slaves(texts_.slaves);
    if (mask_ != 0 && mask != mask_ && !texts_.slaves.empty())
      session_.output().remark("the names mean other slaves now: " + format_slave_set(mask));
    mask_ = mask;
    named_ = Clock::now();
    return mask_;
  }

  std::chrono::milliseconds left() const {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end_ - Clock::now());
    return std::max(left, std::chrono::milliseconds(1));
  }

  Session& session_;
  const WaitTexts& texts_;
  const WaitState& state_;
  Clock::time_point start_;
  Clock::time_point end_ = Clock::time_point::max();
  std::uint32_t mask_ = 0;   ///< 0: not looked up yet
  Clock::time_point named_;  ///< when it was looked up last
  std::string seen_ = "nothing";
};

ExitCode wait_verb(Session& session, const WaitTexts& texts) {
  session.look_only();
  if (texts.state == "value") return wait_value(session, texts.slaves);
  const WaitState& state = find_wait_state(texts.state);
  if (!texts.slaves.empty() && state.of != WaitState::Of::slaves)
    throw UsageError(fmt::format("SLAVE: found '{}'; {} is no state of a slave; allowed: nothing",
                                 texts.slaves.front(), texts.state));
  for (const std::string& list : texts.slaves)
    if (is_number_list(list)) check_slave_list(list);
  return Wait(session, texts, state).run();
}

}  // namespace

void add_wait_verb(CLI::App& app, Verb& chosen) {
  auto* wait = app.add_subcommand("wait", "wait until the daemon, the master or slaves are in a state");
  wait->group(kLookingVerbs);
  auto texts = std::make_shared<WaitTexts>();
  wait->add_option("STATE", texts->state, "what to wait for")
      ->type_name(wait_state_words() + "|value")
      ->required();
  wait->add_option(
      "SLAVE", texts->slaves,
      "for states of slaves: numbers, names, or lists such as 1,3,5-9; all of them must be in the state "
      "(default: every configured slave); for value: SLAVE VALUE COMPARISON NUMBER");
  wait->footer(
      "--timeout is how long to wait in all, also for the daemon (default: until Ctrl-C). Exit code 0: "
      "reached, 5: not within\nthe time, 7: Ctrl-C. What was seen last is said.\n" +
      wait_states_help() +
      "\n  value           an actual value: SLAVE VALUE '>' 10, also < <= = != >=; in its unit when VALUE is a "
      "name, raw when it\n                  is a number; of what comes from now on");
  wait->callback(
      [texts, &chosen] { chosen = [texts](Session& session) { return wait_verb(session, *texts); }; });
}

}  // namespace cansync::cli
