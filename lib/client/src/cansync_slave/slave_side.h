#pragma once

#include <cansync/client.h>

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cansync_slave.h"
#include "cansync_slave/client/application.h"
#include "cansync_slave/client/slave_client.h"
#include "dds/daemon_identity.h"

/// Internal to lib/client.
namespace cansync::client::detail {

/// A step of an upload or download with what belongs to it.
struct BlockStep {
  cansync_slave_BlockJob job = {};  ///< its sequence is not looked at
  std::vector<std::uint8_t> data;
};

/// What a connection to the daemon of a slave has told so far, and the application behind the slave. Counters
/// rise with each receipt: each function block remembers what it has seen. One thread.
class SlaveSide {
 public:
  /// The telegrams of one sender.
  struct Telegrams {
    std::array<std::int32_t, 8> values = {};
    std::array<std::uint64_t, 2> count = {};  ///< of telegram 1, 2
    bool known = false;                       ///< a sample came: intervals and time mean something
    std::array<std::uint64_t, 2> interval = {};
    std::int64_t time = 0;                     ///< of the newest telegram
    std::array<std::uint8_t, 8> mapping = {};  ///< of another slave
  };
  /// The newest of a kind of actions.
  struct Action {
    std::uint64_t count = 0;
    std::uint8_t command = 0;
    std::uint8_t data_byte = 0;
    std::uint16_t data_word = 0;
  };
  /// The other slave whose telegram was heard last, for each channel.
  struct Heard {
    std::uint64_t count = 0;
    std::uint8_t slave = 0;
  };
  using Status = cansync_slave_SlaveSideStatus;
  /// What became of a command.
  struct CommandReply {
    ReplyCode code = ReplyCode::done;
    RefusalCause cause = RefusalCause::none;
    std::string reason;
  };

  /// Waits for the daemon and its first status. Throws as SlaveConnection::connect.
  explicit SlaveSide(const Options& options);

  /// Takes what has come, and says to the daemon that the application is there. Never waits for anything.
  void look();

  cansync_slave::client::SlaveClient& client() noexcept { return client_; }
  /// A daemon is there, and has told of its slave.
  bool daemon_present() const noexcept {
    return client_.daemon_present() && client_.newest_status().has_value();
  }
  /// The start of the daemon that is there, or was last.
  const gateway::dds::DaemonIdentity& daemon() const noexcept { return daemon_; }
  /// What the daemon told last; one that is there no more, too (`daemon_present`).
  const Status& status() const noexcept { return status_; }

  const Telegrams& references() const noexcept { return references_; }
  const Telegrams& monitored(std::size_t slave) const noexcept { return monitored_[slave]; }
  const Heard& heard(unsigned telegram) const noexcept { return heard_[telegram]; }
  const Action& control_word() const noexcept { return control_word_; }
  const Action& broadcast() const noexcept { return broadcast_; }

  /// A block that answers parameter jobs, or blocks, comes. Throws SetupError when there is one already.
  void attach_parameters();
  void attach_blocks();
  void detach_parameters() noexcept;
  void detach_blocks() noexcept;

  /// What is taken over from now on; steps that wait are dropped. Without both there is no application.
  void serve_parameters(const std::vector<std::uint16_t>& numbers);
  void serve_blocks(bool wanted);
  /// Nothing while nothing is taken over.
  cansync_slave::client::Application* application() noexcept;
  /// Something is taken over, and the daemon asks another program, or none yet.
  bool is_standby() const noexcept { return application_ && !application_->is_application(status_); }
  /// Why the application could not say what it takes over; empty: it could.
  const std::string& problem() const noexcept { return problem_; }

  /// The reply to a command of this connection, once; nothing: it is not there yet.
  std::optional<CommandReply> take_command_reply(std::uint64_t request);

  /// Steps that nobody has looked at yet, oldest first.
  std::deque<cansync_slave_ParameterJob>& parameter_steps() noexcept { return parameter_steps_; }
  std::deque<BlockStep>& block_steps() noexcept { return block_steps_; }

 private:
  void take_over();
  /// Jobs of another application are not for this program.
  template <class Job>
  bool is_asked(const Job& job) const noexcept {
    return application_ && application_->is_asked(job);
  }
  void note(const cansync_slave_MonitoredValues& sample);
  void note(const cansync_slave_ActionReceived& sample);
  void note(const cansync_slave_ParameterJob& sample);
  void note(const cansync_slave_BlockJob& sample);
  void note(const cansync_slave_SlaveCommandReply& reply);
  void watch_daemon();

  cansync_slave::client::SlaveClient client_;
  cansync_slave::client::SlaveClient::Listener listener_;
  Status status_ = {};
  gateway::dds::DaemonIdentity daemon_ = {};
  Telegrams references_;
  std::array<Telegrams, 32> monitored_;
  std::array<Heard, 2> heard_;
  Action control_word_;
  Action broadcast_;
  bool has_parameters_ = false;
  bool has_blocks_ = false;
  cansync_slave::client::Duties duties_;
  std::optional<cansync_slave::client::Application> application_;
  std::string problem_;
  std::deque<cansync_slave_ParameterJob> parameter_steps_;
  std::deque<BlockStep> block_steps_;
  std::map<std::uint64_t, CommandReply> command_replies_;  ///< nobody has taken yet
};

}  // namespace cansync::client::detail
