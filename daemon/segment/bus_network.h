#pragma once

#include <chrono>
#include <optional>
#include <span>
#include <string>

#include "daemon/service/network_watch.h"
#include "daemon/service/surroundings.h"
#include "daemon_config/daemon_config.h"

namespace cansyncd {

/// Where the DDS side of a file's buses is to be: on the network that is configured, or on `lo` while its
/// interface cannot be used, or while the daemon of another computer has a name of theirs there. Main thread.
class BusNetwork {
 public:
  /// Between two looks whether a name that is taken is free again.
  static constexpr std::chrono::seconds kLookForName{10};
  /// So many looks in a row, a second apart, must find a name free that was taken: one may miss the other daemon.
  static constexpr unsigned kFreeLooks = 3;
  static constexpr std::chrono::seconds kLookAgain{1};

  /// `buses`: of one file, which have the same DDS options; must outlive the object. Looks at the interface.
  explicit BusNetwork(std::span<const DaemonConfig> buses);

  /// Looks at the interface, and who has the names on its network; that takes 0.3 s at most, when there is a
  /// new network or a name is taken. True: `place` or `taken_by` is another one now.
  bool look();

  NetworkPlace place() const;
  /// The computer whose daemon has a name; empty: none.
  const std::string& taken_by() const noexcept { return taken_by_; }
  void set_taken_by(std::string computer);

 private:
  /// `anew`: on a network on which nobody has looked yet.
  void look_for_name(bool anew);

  const std::span<const DaemonConfig> buses_;
  std::optional<NetworkWatch> watch_;  ///< nothing: DDS stays where its own configuration says
  std::string taken_by_;
  std::chrono::steady_clock::time_point look_for_name_at_;
  unsigned free_looks_ = 0;  ///< in a row, of a name that was taken
};

}  // namespace cansyncd
