#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "cansync_slave.h"
#include "cansync_slave/dds/topics.h"
#include "dds/daemon_sight.h"
#include "dds/endpoint.h"
#include "dds/participant.h"
#include "dds/signal.h"

/// A program's side of the bus of a slave: the application behind the slave.
namespace cansync_slave::client {

using gateway::dds::NoDaemon;
/// How to find the daemon.
using Options = gateway::dds::ClientOptions;

/// A connection to the daemon that is the slave. One thread.
class SlaveClient {
 public:
  /// What is called for each sample that `receive` takes; an empty function: it is dropped.
  struct Listener {
    std::function<void(const cansync_slave_ReferencesReceived&)> references;
    std::function<void(const cansync_slave_MonitoredValues&)> monitored;
    std::function<void(const cansync_slave_ActionReceived&)> action;
    std::function<void(const cansync_slave_ParameterJob&)> parameter_job;
    std::function<void(const cansync_slave_BlockJob&)> block_job;
    std::function<void(const cansync_slave_SlaveCommandReply&)>
        command_reply;  ///< to commands of this client
  };

  /// Waits until a daemon serves the bus and everything is matched with it. Throws NoDaemon when
  /// `options.wait` is over, `stop` is set or several daemons serve the bus, gateway::dds::SetupError when
  /// DDS cannot be set up.
  /// `only_new`: reference values and actions of before the connection are not given.
  explicit SlaveClient(const Options& options, bool only_new = false);

  /// Waits at most `time` for what the daemon received, and calls `listener` for all that came. False: the
  /// daemon has gone.
  bool receive(std::chrono::milliseconds time, const Listener& listener);

  /// What the daemon told last of the slave, waiting at most `time` for the first; nothing: none came.
  std::optional<cansync_slave_SlaveSideStatus> status(std::chrono::milliseconds time);

  /// A command that was handed to DDS.
  struct Commanded {
    std::uint64_t request = 0;                        ///< its reply names it; 0: it was not written
    std::string problem;                              ///< why not
    gateway_RefusalCause cause = gateway_CAUSE_NONE;  ///< likewise
  };

  /// Has the slave do what `wanted` says: mode, own mapping, listening. Who asks, and which start of the
  /// daemon is asked, need not stand in it. Never waits: the one reply comes with `receive`, and none when
  /// the daemon goes before.
  Commanded command(cansync_slave_SlaveCommand wanted);

  /// Which daemon serves the bus, as it told last.
  const gateway_GatewayStatus& gateway_status() const noexcept { return *sight_.newest(); }

  /// A daemon serves the bus now.
  bool daemon_present() const noexcept { return status_.matched() != 0; }

  /// What writers of this connection stand on, and the name they give themselves.
  const gateway::dds::Participant& participant() const noexcept { return participant_; }
  const std::string& name() const noexcept { return options_.client_name; }

  /// Where the daemon was looked for, for messages.
  std::string place() const { return participant_.place(); }

 private:
  bool matched() const noexcept;
  int take(const Listener& listener);

  Options options_;
  std::array<std::uint8_t, 16> identity_;
  gateway::dds::Participant participant_;
  gateway::dds::DataSignal signal_;
  gateway::dds::Reader<cansync_slave_ReferencesReceived> references_;
  gateway::dds::Reader<cansync_slave_MonitoredValues> monitored_;
  gateway::dds::Reader<cansync_slave_ActionReceived> actions_;
  gateway::dds::Reader<cansync_slave_ParameterJob> parameter_jobs_;
  gateway::dds::Reader<cansync_slave_BlockJob> block_jobs_;
  gateway::dds::Reader<cansync_slave_SlaveSideStatus> status_;
  gateway::dds::Reader<cansync_slave_SlaveCommandReply> command_replies_;
  gateway::dds::Writer<cansync_slave_SlaveCommand> commands_;
  gateway::dds::DaemonSight sight_;
  std::uint64_t request_ = 0;  ///< of the last command
  std::optional<cansync_slave_SlaveSideStatus> newest_;
};

}  // namespace cansync_slave::client
