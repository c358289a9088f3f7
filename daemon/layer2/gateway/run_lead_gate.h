#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "daemon/desk/gateway_events.h"
#include "daemon/desk/owned_reader.h"
#include "daemon/desk/writer_arbiter.h"
#include "daemon/layer2/exchange.h"
#include "daemon/service/daemon_identity.h"
#include "layer2.h"

namespace cansyncd {

/// Run and stop tied to the life of a program, as those of the module were to its PLC: the module runs while the
/// writer of RunLead with the configured name says so that has it (WriterArbiter). Writers with other names have
/// no part in it. Gateway thread only.
class RunLeadGate {
 public:
  /// A row of samples that are not heard is over when none came for so long.
  static constexpr std::chrono::seconds kQuiet{1};

  /// `name`: of the program; empty: none is followed, and nothing is ever changed. `daemon`: this start. All
  /// must outlive the gate. Throws gateway::dds::SetupError.
  RunLeadGate(const gateway::dds::Participant& participant, gateway::dds::DataSignal& signal,
              EventPublisher& events, const DaemonIdentity& daemon, std::string name,
              Layer2Exchange& exchange);

  /// While it is read-only no program is heard, and one that is there counts as gone.
  void set_read_only(bool read_only, SteadyTime now);
  /// Takes what has come, and looks whether the program is gone. True: there may be more.
  bool take_samples(SteadyTime now);
  /// Tries again what had no room, and looks whether a row of refusals is over. Returns when to call again; nothing: no need.
  std::optional<SteadyTime> tick(SteadyTime now);

  /// A program is followed, whether it is there or not.
  bool follows() const noexcept { return !name_.empty(); }
  /// It says that the module is to run.
  bool wants_run() const noexcept { return run_; }
  /// It has said stop, or has gone, since this was asked last.
  bool take_stopped() noexcept { return std::exchange(stopped_, false); }
  /// Every order to run or to stop that follows from it was handed on.
  bool settled() const noexcept { return !wanted_; }
  /// The program that is there; empty: none.
  const std::string& program() const noexcept { return arbiter_.owner().identity.who; }
  /// Who has it, and who waits for it.
  const WriterArbiter& arbiter() const noexcept { return arbiter_; }

 private:
  void take(const layer2_RunLead& sample, WriterHandle writer, SteadyTime now);
  void gone(std::string_view how, bool fault, SteadyTime now);
  void set(bool run, std::string text, bool fault, SteadyTime now);
  bool flush();

  OwnedReader<layer2_RunLead> reader_;
  WriterArbiter arbiter_{"run and stop"};
  EventPublisher& events_;
  const DaemonIdentity daemon_;
  const std::string name_;
  Layer2Exchange& exchange_;
  bool read_only_ = false;
  bool run_ = false;
  bool stopped_ = false;
  std::optional<bool> wanted_;  ///< had no room yet
  FaultRow refusals_{kQuiet};
};

}  // namespace cansyncd
