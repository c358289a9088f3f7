#pragma once

#include <dds/dds.h>

#include <chrono>
#include <cstdint>
#include <optional>
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

/// Knows which application stands behind the slave, the strongest living writer that says so, and hands what
/// it has taken over and answered to the realtime thread. Gateway thread only.
class ApplicationGate {
 public:
  /// An application that says nothing for so long is none.
  static constexpr std::chrono::seconds kSilence{2};
  /// A row of refused samples is over when none was refused for so long.
  static constexpr std::chrono::seconds kQuiet{1};

  /// `daemon`: this start, which answers must name. `status_parameter`: number of the status word, which
  /// nobody else answers. `signal`, `events` and `exchange` must outlive the gate.
  /// Throws gateway::dds::SetupError.
  ApplicationGate(const gateway::dds::Participant& participant, gateway::dds::DataSignal& signal,
                  EventPublisher& events, const DaemonIdentity& daemon, std::uint16_t status_parameter,
                  SlaveExchange& exchange);

  /// Takes what has come, and looks who has gone. True: there may be more.
  bool take_samples(SteadyTime now);

  /// Looks who is silent, and tells of refusals that are over. Returns when to call again; nothing: no need.
  std::optional<SteadyTime> tick(SteadyTime now);

  /// No application is let in from now on, and the one that is there is none any more; or one is let in again.
  void set_read_only(bool read_only, SteadyTime now);

  /// The application, as it names itself; empty: none.
  const std::string& name() const noexcept { return name_; }
  /// What it has taken over.
  const TakeOver& taken() const noexcept { return taken_; }

 private:
  using Sample = cansync_slave_ApplicationAnswer;
  using Writer = dds_instance_handle_t;

  void take(const Sample& sample, const dds_sample_info_t& info, SteadyTime now);
  gateway::dds::Problem problem_of(const Sample& sample, Writer writer) const;
  void take_over(const Sample& sample, Writer writer, SteadyTime now);
  /// `wanted`: somebody has said so.
  void lost(const char* how, bool wanted, SteadyTime now);
  void refuse(const gateway::dds::Denial& denial, SteadyTime now);
  bool flush();

  gateway::dds::Reader<Sample> reader_;
  EventPublisher& events_;
  const DaemonIdentity daemon_;
  const std::uint16_t status_parameter_;
  SlaveExchange& exchange_;
  WriterWatch writers_;
  bool read_only_ = false;
  Writer owner_ = 0;  ///< 0: nobody
  std::string name_;
  TakeOver taken_;
  std::optional<TakeOver> waiting_;  ///< had no room yet
  SteadyTime heard_{};
  bool without_writer_ = false;
  FaultRow refusals_{kQuiet};
};

}  // namespace cansyncd
