#pragma once

#include <dds/dds.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "cansync_slave.h"
#include "daemon/cansync_slave/exchange.h"
#include "daemon/desk/gateway_events.h"
#include "daemon/desk/owned_reader.h"
#include "daemon/desk/writer_arbiter.h"
#include "daemon/service/daemon_identity.h"
#include "dds/denial.h"
#include "dds/guard/writer_guid.h"
#include "dds/participant.h"
#include "dds/signal.h"

namespace cansyncd {

/// Knows which application is behind the slave, the one that has it (WriterArbiter), and hands what it has taken
/// over and answered to the realtime thread. Gateway thread only.
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
  const std::string& name() const noexcept { return arbiter_.owner().identity.who; }
  /// Its writer; all zero: there is no application.
  const gateway::dds::WriterGuid& guid() const noexcept { return arbiter_.owner().identity.guid; }
  /// Who is the application, and who waits to be it.
  const WriterArbiter& arbiter() const noexcept { return arbiter_; }
  /// What it has taken over.
  const TakeOver& taken() const noexcept { return taken_; }

 private:
  using Sample = cansync_slave_ApplicationAnswer;

  void take(const Sample& sample, const dds_sample_info_t& info, SteadyTime now);
  gateway::dds::Problem problem_of(const Sample& sample, WriterHandle writer) const;
  void take_over(const Sample& sample, const TopicWriter& writer, SteadyTime now);
  /// `wanted`: somebody has said so.
  void lost(const char* how, bool wanted, SteadyTime now);
  void refuse(const gateway::dds::Denial& denial, SteadyTime now);
  bool flush();

  OwnedReader<Sample> reader_;
  EventPublisher& events_;
  const DaemonIdentity daemon_;
  const std::uint16_t status_parameter_;
  SlaveExchange& exchange_;
  bool read_only_ = false;
  WriterArbiter arbiter_{"the place of the application"};
  TakeOver taken_;
  std::optional<TakeOver> waiting_;  ///< had no room yet
  SteadyTime heard_{};
  FaultRow refusals_{kQuiet};
};

}  // namespace cansyncd
