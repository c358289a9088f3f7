#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "dds/daemon_identity.h"
#include "dds/endpoint.h"
#include "dds/gateway_topics.h"
#include "dds/participant.h"
#include "dds/signal.h"

namespace gateway::dds {

/// A daemon that serves the same bus in the same domain, whatever its protocol.
struct OtherDaemon {
  dds_instance_handle_t writer = 0;  ///< of its status
  DaemonIdentity identity = {};
  std::string name;           ///< "cansyncd 0.1.0, process 1234 on host plc7"
  std::string host;           ///< "plc7"; empty: it was not told
  std::uint32_t process = 0;  ///< its number there
};

/// Sees the other daemons of a bus by their GatewayStatus. A daemon that was killed before this object was
/// made is never seen, for it tells nothing any more; one that is killed later counts until DDS knows of its
/// death (5 s). One thread.
class OtherDaemons {
 public:
  /// What has changed.
  struct News {
    std::vector<OtherDaemon> came;
    std::vector<OtherDaemon> gone;
  };
  /// Most that are known at a time.
  static constexpr std::size_t kMost = 64;

  /// `own`: the start that is no other; all zero: none. `signal` (may be null) is raised when there may be
  /// news. Throws SetupError.
  OtherDaemons(const Participant& participant, const DaemonIdentity& own, DataSignal* signal);

  /// Looks, and says what has changed since the last call.
  News look();

  const std::vector<OtherDaemon>& there() const noexcept { return there_; }
  /// Daemons of the bus that are matched, also those that have told nothing yet.
  std::uint32_t matched() const noexcept { return reader_.matched(); }

 private:
  const DaemonIdentity own_;
  Reader<gateway_GatewayStatus> reader_;
  std::vector<OtherDaemon> there_;
};

/// Looks which of these buses a daemon serves already, before one is started: at most `kLongestLook` for all
/// of them, and `kShortLook` when no other program is in their domains. One daemon for each bus, in their
/// order; nothing: none was found. Throws SetupError.
std::vector<std::optional<OtherDaemon>> names_in_use(std::span<const Participant> buses);
inline constexpr std::chrono::milliseconds kShortLook{100};
inline constexpr std::chrono::milliseconds kLongestLook{300};

}  // namespace gateway::dds
