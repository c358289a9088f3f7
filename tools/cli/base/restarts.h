#pragma once

#include <cansync/client.h>
#include <cansync/topics.h>

#include <atomic>
#include <chrono>
#include <string>
#include <string_view>
#include <utility>

#include "cli/base/interrupt.h"

namespace cansync::cli {

/// What is said when the daemon has another start than before.
inline constexpr std::string_view kStartedAnew =
    "the daemon was started anew: its intervals and events begin again, and settings that clients made are "
    "lost";

/// True when `client` has lost its daemon and none came within a second: while a bus is set up anew there is
/// none. A program that was just continued finds it again later. Waits so long, or until a signal came.
template <class Client>
bool stays_gone(const Client& client) {
  constexpr auto kComesBack = std::chrono::seconds(1);
  constexpr auto kLook = std::chrono::milliseconds(20);
  const auto end = std::chrono::steady_clock::now() + kComesBack;
  while (!client.daemon_present()) {
    const auto now = std::chrono::steady_clock::now();
    if ((now >= end && !just_continued()) || wait_until(now + kLook)) return true;
  }
  return false;
}

/// Notices that the daemon was started anew, however short it was away, for a verb that goes on with it. Main
/// thread only.
class Restarts {
 public:
  explicit Restarts(client::Client& client)
      : client_(client),
        subscription_(client.on_restart([this](const client::GatewayStatus&) { ++seen_; })) {}

  /// Throws client::SeveralDaemons while another daemon serves the bus besides: what comes is that of either.
  void expect_one() const {
    if (const std::string who = client_.several_daemons(); !who.empty()) throw client::SeveralDaemons(who);
  }

  /// As `stays_gone`.
  bool gone() const { return stays_gone(client_); }

  /// True when it was since the last call; however often.
  bool take() noexcept {
    const unsigned seen = seen_;
    return std::exchange(told_, seen) != seen;
  }

 private:
  client::Client& client_;
  std::atomic<unsigned> seen_ = 0;
  unsigned told_ = 0;
  client::Subscription subscription_;  // ends before what its callback needs
};

}  // namespace cansync::cli
