#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "daemon/desk/gateway_events.h"
#include "dds/participant.h"

namespace cansyncd {

/// Tells of programs whose readers or writers are on the bus's topics and do not match the daemon's: event
/// `dds_incompatible`, once for each program and policy. Gateway thread only.
class IncompatiblePeers {
 public:
  /// From what DDS tells to the look: the other endpoints of that program have come by then.
  static constexpr std::chrono::milliseconds kSettle{500};
  /// As long as there are some: how soon it is noticed that they have gone.
  static constexpr std::chrono::seconds kAgain{10};
  /// Most endpoints that are looked at; what there is beyond is neither told nor counted.
  static constexpr std::size_t kMost = 256;

  IncompatiblePeers(const gateway::dds::Participant& participant, EventPublisher& events)
      : participant_(participant), events_(events) {}

  /// Looks when it is time to. Returns when to call again at the latest; nothing: no need.
  std::optional<SteadyTime> step(SteadyTime now);

  /// Programs that do not match, as of the last look.
  std::uint32_t count() const noexcept { return count_; }

 private:
  void look(SteadyTime now);

  const gateway::dds::Participant& participant_;
  EventPublisher& events_;
  std::uint64_t seen_ = 0;
  std::uint64_t types_seen_ = 0;  ///< of them, because of the type
  bool types_differ_ = false;     ///< some did in the last look
  std::optional<SteadyTime> due_;
  std::set<std::pair<std::string, std::string>> told_;  ///< participant and policy
  std::uint32_t count_ = 0;
};

}  // namespace cansyncd
