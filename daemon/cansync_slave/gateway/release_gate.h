#pragma once

#include <dds/dds.h>

#include <array>
#include <chrono>
#include <cstdint>

#include "cansync_slave.h"
#include "daemon/cansync_slave/exchange.h"
#include "daemon/desk/gateway_events.h"
#include "daemon/desk/owned_reader.h"
#include "daemon/desk/writer_arbiter.h"
#include "daemon/service/daemon_identity.h"
#include "dds/denial.h"
#include "dds/participant.h"
#include "dds/signal.h"

namespace cansyncd {

/// Takes the actual values that applications release, from the owner of each telegram (WriterArbiter), and hands
/// them to the realtime thread. Gateway thread only.
class ReleaseGate {
 public:
  /// A row of refused releases is over when none was refused for so long.
  static constexpr std::chrono::seconds kQuiet{1};
  /// A release whose source time lies further away is not taken.
  static constexpr std::chrono::milliseconds kMaximumAge{500};

  /// `daemon`: this start, which releases must name. `signal`, `events` and `exchange` must outlive the gate.
  /// Throws gateway::dds::SetupError.
  ReleaseGate(const gateway::dds::Participant& participant, gateway::dds::DataSignal& signal,
              EventPublisher& events, const DaemonIdentity& daemon, SlaveExchange& exchange);

  /// Takes what has come, and looks who has gone. `wall`: CLOCK_REALTIME at `now`, ns since 1970. True: there may be more.
  bool take_samples(SteadyTime now, std::int64_t wall);

  /// Tells of refused releases that are over, and hands on what had no room. Returns when to call again; nothing: no need.
  std::optional<SteadyTime> tick(SteadyTime now);

  /// Releases are refused from now on, and what was released is withdrawn; or they are taken again.
  void set_read_only(bool read_only, SteadyTime now);

  /// Who has each telegram, and who waits for it.
  const WriterArbiter& arbiter(unsigned channel) const noexcept { return arbiters_[channel]; }

 private:
  /// `age`: since it was written.
  void take(const cansync_slave_ActualRelease& sample, WriterHandle from, std::chrono::nanoseconds age,
            SteadyTime now);
  gateway::dds::Problem problem_of(const cansync_slave_ActualRelease& sample,
                                   std::chrono::nanoseconds age) const;
  void new_owner(unsigned channel, const TopicWriter& writer, SteadyTime now);
  /// `wanted`: a client or the configuration says so.
  void lost(unsigned channel, const char* how, bool wanted, SteadyTime now);
  /// True: no withdrawal waits any more.
  bool flush();
  void refuse(unsigned channel, const gateway::dds::Denial& denial, SteadyTime now);

  OwnedReader<cansync_slave_ActualRelease> reader_;
  EventPublisher& events_;
  const DaemonIdentity daemon_;
  SlaveExchange& exchange_;
  bool read_only_ = false;
  std::array<WriterArbiter, cansync::kChannels> arbiters_{WriterArbiter("the actual values of telegram 1"),
                                                          WriterArbiter("the actual values of telegram 2")};
  std::array<bool, cansync::kChannels> withdrawals_ = {};  ///< had no room yet
  FaultRow refusals_{kQuiet};
};

}  // namespace cansyncd
