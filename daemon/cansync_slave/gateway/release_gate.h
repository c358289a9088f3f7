#pragma once

#include <dds/dds.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <string>

#include "cansync_slave.h"
#include "daemon/cansync_slave/exchange.h"
#include "daemon/desk/gateway_events.h"
#include "daemon/desk/writer_watch.h"
#include "daemon/service/daemon_identity.h"
#include "dds/denial.h"
#include "dds/endpoint.h"
#include "dds/participant.h"
#include "dds/signal.h"

namespace cansyncd {

/// Takes the actual values that applications release, from the strongest living writer of each telegram, and
/// hands them to the realtime thread. Gateway thread only.
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

  /// Takes what has come, and looks who has gone. True: there may be more.
  bool take_samples(SteadyTime now);

  /// Tells of refused releases that are over. Returns when to call again; nothing: no need.
  std::optional<SteadyTime> tick(SteadyTime now);

  /// Releases are refused from now on, or taken.
  void set_read_only(bool read_only) noexcept { read_only_ = read_only; }

 private:
  using Writer = dds_instance_handle_t;

  void take(const cansync_slave_ActualRelease& sample, const dds_sample_info_t& info, SteadyTime now);
  gateway::dds::Problem problem_of(const cansync_slave_ActualRelease& sample, std::int64_t written) const;
  void new_owner(unsigned channel, Writer writer, SteadyTime now);
  void lost(unsigned channel, bool given_up, SteadyTime now);
  void refuse(unsigned channel, const gateway::dds::Denial& denial, SteadyTime now);

  gateway::dds::Reader<cansync_slave_ActualRelease> reader_;
  EventPublisher& events_;
  const DaemonIdentity daemon_;
  SlaveExchange& exchange_;
  WriterWatch writers_;
  bool read_only_ = false;
  std::array<Writer, cansync::kChannels> owners_ = {};  ///< 0: nobody
  std::array<std::string, cansync::kChannels> names_;
  std::array<bool, cansync::kChannels> without_writer_ = {};
  FaultRow refusals_{kQuiet};
};

}  // namespace cansyncd
