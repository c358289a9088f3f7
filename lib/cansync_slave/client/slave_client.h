#pragma once

#include <chrono>
#include <functional>
#include <optional>

#include "cansync_slave.h"
#include "cansync_slave/dds/topics.h"
#include "dds/ask/request_client.h"
#include "dds/endpoint.h"
#include "dds/newest.h"

/// A program's side of the bus of a slave: the application behind the slave.
namespace cansync_slave::client {

using gateway::dds::NoDaemon;
/// How to find the daemon.
using Options = gateway::dds::ClientOptions;

/// A connection to the daemon that is the slave. One thread.
class SlaveClient : public gateway::dds::RequestClient {
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

  /// What the daemon told last of the slave, waiting at most `time` for the first; nothing: none came, or the daemon
  /// has gone.
  std::optional<cansync_slave_SlaveSideStatus> status(std::chrono::milliseconds time);
  /// As `status`, without waiting.
  const std::optional<cansync_slave_SlaveSideStatus>& take_status();
  /// As `status`, of what was taken so far; takes nothing.
  const std::optional<cansync_slave_SlaveSideStatus>& newest_status() const noexcept {
    return newest_.told();
  }

  /// Has the slave do what `wanted` says: mode, own mapping, listening. Who asks, and which start of the
  /// daemon is asked, need not stand in it. Never waits: the one reply comes with `receive`, and none when
  /// the daemon goes before.
  gateway::dds::Begun command(cansync_slave_SlaveCommand wanted);

  /// The jobs of the daemon reach this connection. A daemon that has just come knows the connection before the
  /// connection knows all of the daemon, and what it asks then is lost. Of several daemons none is looked at.
  bool receives_jobs() const;

 private:
  bool matched() const noexcept;
  int take(const Listener& listener);

  gateway::dds::Reader<cansync_slave_ReferencesReceived> references_;
  gateway::dds::Reader<cansync_slave_MonitoredValues> monitored_;
  gateway::dds::Reader<cansync_slave_ActionReceived> actions_;
  gateway::dds::Reader<cansync_slave_ParameterJob> parameter_jobs_;
  gateway::dds::Reader<cansync_slave_BlockJob> block_jobs_;
  gateway::dds::Reader<cansync_slave_SlaveSideStatus> status_;
  gateway::dds::Reader<cansync_slave_SlaveCommandReply> command_replies_;
  gateway::dds::Writer<cansync_slave_SlaveCommand> commands_;
  gateway::dds::Newest<cansync_slave_SlaveSideStatus> newest_;
};

}  // namespace cansync_slave::client
