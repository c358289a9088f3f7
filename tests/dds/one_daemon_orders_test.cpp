#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "dds/ask/daemon_choice.h"

/// Two computers with a daemon of one name each, which are started, stopped, killed and cut off in seeded
/// orders, and a program that asks. DDS is a model in virtual time; who takes a request and whom one is for
/// decides the code of the daemon and of the client library.
namespace gateway::dds {
namespace {

using std::chrono::milliseconds;
using View = DaemonChoice::View;

constexpr std::int64_t kLength = 40'000;  // ms of an order
constexpr std::int64_t kQuiet = 12'000;   // ms in which everything must have ended
constexpr std::int64_t kStep = 50;        // ms
constexpr std::int64_t kLease = 5'000;    // ms after which DDS knows of a death
constexpr std::int64_t kStatus = 1'000;   // ms between two statuses
constexpr unsigned kHosts = 2;

/// What a request became.
struct Asked {
  DaemonIdentity daemon = {};
  int carried_out = 0;
  bool ended = false;
};

/// A daemon, from its start to long after its end.
struct Daemon {
  DaemonIdentity identity = {};
  DaemonChoice::Place place = 0;
  unsigned host = 0;
  bool runs = true;
  bool said_goodbye = false;  ///< stopped, not killed
  bool matched = false;       ///< the client knows it
  std::int64_t next_status = 0;
  std::int64_t unheard_since = 0;     ///< the link is down, or it is dead
  std::int64_t both_heard_since = 0;  ///< in which it was matched and could be heard
  std::deque<std::uint64_t> inbox;    ///< requests on their way: reliable, so a short loss only delays them
  std::deque<std::uint64_t> outbox;   ///< replies likewise
};

class Order {
 public:
  explicit Order(std::uint32_t seed) : dice_(seed), only_one_starts_(seed % 2 == 0) {}

  void run() {
    start(0);
    for (now_ = 0; now_ < kLength + kQuiet; now_ += kStep) {
      if (now_ < kLength && chance(60)) disturb();
      if (now_ == kLength) link_up_.fill(true);
      serve();
      pass_of_client();
      if (now_ < kLength && chance(4)) ask();
    }
    for (std::size_t number = 0; number < asked_.size(); ++number) {
      if (!asked_[number].ended) fail("request " + std::to_string(number) + " has not ended");
      if (asked_[number].carried_out > 1)
        fail("request " + std::to_string(number) + " was carried out twice");
    }
  }

  std::uint64_t done() const { return done_; }
  std::uint64_t lost() const { return lost_; }
  std::uint64_t refused() const { return refused_; }
  const std::string& failure() const { return failure_; }

 private:
  bool chance(unsigned one_in) { return dice_() % one_in == 0; }
  void fail(const std::string& what) {
    if (failure_.empty()) failure_ = what + " at " + std::to_string(now_) + " ms";
  }

  Daemon* running(unsigned host) {
    for (Daemon& daemon : daemons_) {
      if (daemon.runs && daemon.host == host) return &daemon;
    }
    return nullptr;
  }

  void start(unsigned host) {
    if (running(host) != nullptr) return;
    // A daemon that finds its name in use does not start; it sees the other one unless the network is broken.
    if (only_one_starts_ && running(1 - host) != nullptr && between_up_) return;
    Daemon& daemon = daemons_.emplace_back();
    daemon.place = ++places_;
    daemon.identity[0] = static_cast<std::uint8_t>(places_ % 251 + 1);
    daemon.identity[1] = static_cast<std::uint8_t>(places_ / 251);
    daemon.host = host;
    daemon.next_status = now_ + 50;
    daemon.unheard_since = now_;
  }
  void end(unsigned host, bool in_order) {
    Daemon* daemon = running(host);
    if (daemon == nullptr) return;
    daemon->runs = false;
    daemon->said_goodbye = in_order && link_up_[host];
    daemon->unheard_since = now_;
    // What it had taken and not answered is lost with it.
    if (!daemon->said_goodbye) daemon->outbox.clear();
    daemon->inbox.clear();
  }

  void disturb() {
    const unsigned host = dice_() % kHosts;
    switch (dice_() % 8) {
      case 0:
      case 1:
        return start(host);
      case 2:
        return end(host, true);
      case 3:
        return end(host, false);
      case 4:  // killed, and started at once
        end(host, false);
        return start(host);
      case 5:
        link_up_[host] = !link_up_[host];
        return;
      case 6:
        link_up_[host] = true;
        return;
      default:
        between_up_ = !between_up_;
        return;
    }
  }

  bool heard_now(const Daemon& daemon) const { return daemon.runs && link_up_[daemon.host]; }

  /// What the daemons and DDS do in a step.
  void serve() {
    for (Daemon& daemon : daemons_) {
      if (heard_now(daemon)) {
        if (!daemon.matched && chance(3)) {
          daemon.matched = true;  // found: it tells its newest status
          daemon.both_heard_since = now_;
          choice_.heard(daemon.place, daemon.identity);
          hear_of(daemon);
        }
        daemon.unheard_since = now_;
      } else {
        daemon.both_heard_since = now_;
      }
      const bool goodbye = daemon.said_goodbye && daemon.outbox.empty() && link_up_[daemon.host];
      if (daemon.matched && (goodbye || now_ - daemon.unheard_since > kLease)) {
        daemon.matched = false;
        daemon.inbox.clear();  // nobody sends it again
        daemon.outbox.clear();
      }
      if (daemon.runs && now_ >= daemon.next_status) {
        daemon.next_status = now_ + kStatus;
        if (daemon.matched && heard_now(daemon)) {
          choice_.heard(daemon.place, daemon.identity);
          hear_of(daemon);
        }
      }
      if (heard_now(daemon)) carry_out(daemon);
      if (daemon.matched && link_up_[daemon.host]) deliver_replies(daemon);
    }
    std::erase_if(daemons_, [](const Daemon& daemon) { return !daemon.runs && !daemon.matched; });
  }

  void carry_out(Daemon& daemon) {
    while (!daemon.inbox.empty()) {
      Asked& asked = asked_.at(daemon.inbox.front());
      if (addressee(asked.daemon, daemon.identity) == Addressee::this_daemon) {
        ++asked.carried_out;
        if (asked.daemon != daemon.identity) fail("carried out by the wrong one");
        daemon.outbox.push_back(daemon.inbox.front());
      }
      daemon.inbox.pop_front();
    }
  }

  void deliver_replies(Daemon& daemon) {
    if (!daemon.runs && !daemon.said_goodbye) return;
    for (; !daemon.outbox.empty(); daemon.outbox.pop_front()) {
      Asked& asked = asked_.at(daemon.outbox.front());
      if (asked.ended) continue;
      asked.ended = true;
      ++done_;
    }
  }

  /// A program that listens is told of another start as soon as it is heard.
  void hear_of(const Daemon& daemon) {
    if (!listens_ || std::find(heard_of_.begin(), heard_of_.end(), daemon.identity) != heard_of_.end())
      return;
    heard_of_.push_back(daemon.identity);
    if (heard_of_.size() == 1) return;
    known_ = daemon.identity;
    choice_.program_told_of(daemon.identity);
  }

  /// The receiver thread of the client.
  void pass_of_client() {
    std::vector<DaemonChoice::Place> matched;
    for (const Daemon& daemon : daemons_) {
      if (daemon.matched) matched.push_back(daemon.place);
    }
    choice_.look(DaemonChoice::Clock::time_point(milliseconds(now_)), matched);
    bool lost = false;
    std::erase_if(open_, [&](std::uint64_t number) {
      Asked& asked = asked_.at(number);
      if (asked.ended) return true;
      if (choice_.may_answer(asked.daemon)) return false;
      asked.ended = lost = true;
      ++lost_;
      return true;
    });
    if (lost) tell();
  }

  void tell() {
    told_ = true;
    choice_.program_told();
  }

  /// The program asks; the words of a refusal tell it.
  void ask() {
    if (choice_.view() != View::one || choice_.to_be_told()) {
      ++refused_;
      return tell();
    }
    const DaemonIdentity& daemon = choice_.daemon();
    if (known_ && *known_ != daemon && !told_) fail("asked another start, of which the program was not told");
    // Both have been heard again and again: there is no choice.
    constexpr std::int64_t kLong = 2 * kStatus + 200;
    const auto both = std::count_if(daemons_.begin(), daemons_.end(), [this](const Daemon& each) {
      return each.matched && heard_now(each) && now_ - each.both_heard_since > kLong;
    });
    if (both > 1) fail("asked one of two that live");
    known_ = daemon;
    told_ = false;
    const std::uint64_t number = asked_.size();
    Asked& asked = asked_.emplace_back();
    asked.daemon = daemon;
    open_.push_back(number);
    // DDS gives it to every one that is matched.
    for (Daemon& each : daemons_) {
      if (each.matched && (each.runs || !each.said_goodbye)) each.inbox.push_back(number);
    }
  }

  std::mt19937 dice_;
  const bool only_one_starts_;
  const bool listens_ = dice_() % 2 == 0;
  std::int64_t now_ = 0;
  std::uint32_t places_ = 0;
  std::array<bool, kHosts> link_up_ = {true, true};  ///< from the client to a computer
  bool between_up_ = true;
  std::vector<Daemon> daemons_;
  DaemonChoice choice_;
  std::vector<Asked> asked_;
  std::vector<std::uint64_t> open_;
  std::optional<DaemonIdentity> known_;  ///< the start that the program has asked, or heard of, last
  bool told_ = false;                    ///< since then
  std::vector<DaemonIdentity> heard_of_;
  std::uint64_t done_ = 0;
  std::uint64_t lost_ = 0;
  std::uint64_t refused_ = 0;
  std::string failure_;
};

unsigned orders() {
  const char* given = std::getenv("CANSYNC_DAEMON_ORDERS");  // NOLINT(concurrency-mt-unsafe): one thread
  return given == nullptr ? 10'000u : static_cast<unsigned>(std::strtoul(given, nullptr, 10));
}

TEST(OneDaemonOrders, NoRequestIsCarriedOutTwiceOrByTheWrongOneAndNoneIsLostWithoutWords) {
  std::uint64_t done = 0;
  std::uint64_t lost = 0;
  std::uint64_t refused = 0;
  for (unsigned seed = 0; seed < orders(); ++seed) {
    Order order(seed);
    order.run();
    ASSERT_EQ(order.failure(), "") << "seed " << seed;
    done += order.done();
    lost += order.lost();
    refused += order.refused();
  }
  // Each of the three must have come often, or nothing was tried.
  EXPECT_GT(done, 10u * orders());
  EXPECT_GT(lost, orders() / 10);
  EXPECT_GT(refused, 10u * orders());
  std::printf("done %lu, lost with words %lu, refused %lu\n", done, lost, refused);
}

}  // namespace
}  // namespace gateway::dds
