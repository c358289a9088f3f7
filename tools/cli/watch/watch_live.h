#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cli/base/exit_codes.h"
#include "cli/base/session.h"
#include "cli/watch/live_screen.h"
#include "cli/watch/watched_parameters.h"

/// `watch` as a full-screen view.
namespace cansync::cli {

/// What is looked at, and how.
struct LiveSettings {
  std::uint32_t slaves = 0;                   ///< bit n: slave n
  bool every_slave = true;                    ///< those that are configured at the time, instead of `slaves`
  std::chrono::milliseconds interval{500};    ///< from one look to the next
  bool raw = false;                           ///< numbers as on the bus at first
  std::vector<WatchedSlave> parameters = {};  ///< read in turn
};

/// Shows the line until q or a signal; nothing: names mean something else now. When the daemon goes away it says so and goes on looking; ended then,
/// the result is `not_reachable`. Throws std::runtime_error when the terminal goes away.
std::optional<ExitCode> watch_live(Session& session, LiveScreen& screen, const LiveSettings& settings);

}  // namespace cansync::cli
