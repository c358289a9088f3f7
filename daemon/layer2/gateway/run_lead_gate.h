#pragma once

#include <optional>
#include <string>

#include "daemon/desk/gateway_events.h"
#include "daemon/layer2/exchange.h"
#include "daemon/layer2/gateway/sole_writer.h"
#include "daemon/service/daemon_identity.h"
#include "layer2.h"

namespace cansyncd {

/// Run and stop tied to the life of a program, as those of the module were to its PLC: the module runs while
/// the strongest living writer of RunLead with the configured name says so. Gateway thread only.
class RunLeadGate {
 public:
  /// `name`: of the program; empty: none is followed, and nothing is ever changed. `daemon`: this start. All
  /// must outlive the gate. Throws gateway::dds::SetupError.
  RunLeadGate(const gateway::dds::Participant& participant, gateway::dds::DataSignal& signal,
              EventPublisher& events, const DaemonIdentity& daemon, std::string name,
              Layer2Exchange& exchange);

  /// Takes what has come, and looks whether the program is gone. True: there may be more.
  bool take_samples(SteadyTime now);
  /// Tries again what had no room. Returns when to call again; nothing: no need.
  std::optional<SteadyTime> tick(SteadyTime now);

  /// A program is followed, whether it is there or not.
  bool follows() const noexcept { return !name_.empty(); }
  /// It says that the module is to run.
  bool wants_run() const noexcept { return run_; }
  /// Every order to run or to stop that follows from it was handed on.
  bool settled() const noexcept { return !wanted_; }
  /// The program that is there; empty: none.
  const std::string& program() const noexcept { return writer_.name(); }

 private:
  void take(const layer2_RunLead& sample, dds_instance_handle_t writer, SteadyTime now);
  void set(bool run, std::string text, bool fault, SteadyTime now);
  bool flush();

  SoleWriter<layer2_RunLead> writer_;
  EventPublisher& events_;
  const DaemonIdentity daemon_;
  const std::string name_;
  Layer2Exchange& exchange_;
  bool run_ = false;
  std::optional<bool> wanted_;  ///< had no room yet
};

}  // namespace cansyncd
