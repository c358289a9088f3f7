#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "cansync_slave.h"
#include "cansync_slave/client/slave_client.h"
#include "dds/daemon_identity.h"
#include "dds/endpoint.h"

namespace cansync_slave::client {

/// Releases the slave's actual values: each call of `write` is good for one telegram. One thread.
class ReleaseWriter {
 public:
  /// The values are for the daemon that `client` sees now: another start of it takes none of them, until
  /// `take_up`. `strength`: 0 and more, or gateway::dds::kTakeOver; a telegram has one writer at a time, which
  /// keeps it until it gives it up, is lost, or a stronger one comes. `client` must outlive the writer. Throws
  /// gateway::dds::SetupError.
  ReleaseWriter(SlaveClient& client, std::int32_t strength);

  /// Gives up every telegram that was written.
  ~ReleaseWriter();
  ReleaseWriter(const ReleaseWriter&) = delete;
  ReleaseWriter& operator=(const ReleaseWriter&) = delete;

  /// Releases telegram 1 (values 0..3) or 2 (4..7) once. `valid`: bit n: value n is new, the others keep what
  /// they had. `wait_intervals`: for so many intervals, 1..1000, the release waits for the master to ask.
  /// Returns what failed; empty: it was handed to DDS. While another writer has the telegram that is no weaker,
  /// nothing is written.
  std::string write(std::uint8_t telegram, const std::array<std::uint32_t, 4>& raw, std::uint8_t valid,
                    std::uint32_t wait_intervals);

  /// The last `write` wrote nothing, because another writer has the telegram that is no weaker.
  bool waits() const noexcept { return waits_; }

  /// Nothing more is released by this writer; another one may.
  void give_up(std::uint8_t telegram);

  /// The daemon was started anew since the values were taken up: none of them is taken.
  bool daemon_restarted() const noexcept;

  /// From now on the values are for the daemon that is there now.
  void take_up() noexcept;

 private:
  SlaveClient& client_;
  const std::int32_t strength_;
  gateway::dds::Writer<cansync_slave_ActualRelease> writer_;
  gateway::dds::DaemonIdentity daemon_ = {};
  std::array<bool, 2> written_ = {};
  bool waits_ = false;
};

}  // namespace cansync_slave::client
