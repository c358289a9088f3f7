#pragma once

#include <array>
#include <cstdint>

#include "cansync/cluster/cluster.h"
#include "cansync/slave/slave.h"
#include "daemon/cansync_slave/exchange.h"

namespace cansyncd {

/// The releases of the application that wait to be asked for: each is good for one telegram, and for so many
/// intervals as it says. Realtime thread only; realtime safe.
class ReleaseStore {
 public:
  /// `lead`: gets each release once, at the beginning of the next interval; null: there is none. It must
  /// outlive the store.
  explicit ReleaseStore(cansync::LeadAxis* lead = nullptr) noexcept : lead_(lead) {}

  /// A release, or a withdrawal, came. It counts from the next edge on, or from now when the master has not
  /// asked in this interval yet.
  void take(const ReleaseOrder& order, cansync::Slave& slave) noexcept;

  /// The interval ends: before `Slave::on_sync`.
  void interval_ends(const cansync::Slave& slave, std::uint64_t passed) noexcept;

  /// The interval has begun: after `Slave::on_sync`.
  void interval_begins(cansync::Slave& slave) noexcept;

  /// There are no intervals any more: what waits is dropped.
  void drop() noexcept;

  /// Releases that were not asked for in their time, or replaced before.
  std::uint64_t unused(cansync::Channel channel) const noexcept { return waiting_[index(channel)].unused; }

 private:
  struct Waiting {
    std::uint32_t left = 0;  ///< intervals; 0: nothing waits
    bool in_slave = false;   ///< the slave has it for the running interval
    std::uint64_t unused = 0;
  };

  void hand_on(cansync::Channel channel, cansync::Slave& slave) noexcept;

  cansync::Values values_ = {};
  cansync::LeadAxis* const lead_;
  std::array<std::uint8_t, cansync::kChannels> for_lead_ = {};  ///< bit n: value n was released anew
  std::array<Waiting, cansync::kChannels> waiting_ = {};
};

}  // namespace cansyncd
