#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "dds/daemon_choice.h"
#include "dds/endpoint.h"
#include "dds/gateway_topics.h"
#include "dds/participant.h"
#include "dds/signal.h"

/// What the client libraries of all protocols but the master's share: how the daemon of a bus is found, and
/// whom requests are for.
namespace gateway::dds {

/// No daemon serves the bus, or several do; the text says where it was looked for, or who they are, and the
/// remedy.
class NoDaemon : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// How to find the daemon.
struct ClientOptions {
  std::uint32_t domain = 0;      ///< DDS domain, 0..230
  std::string bus = "sim";       ///< name of the bus: the DDS partition
  std::string interface = "lo";  ///< network interface
  std::string client_name;       ///< for the daemon's journal
  std::string xml;               ///< Cyclone DDS configuration used instead of the built one; empty: none
  std::string security;          ///< folder of the identity; empty: without DDS Security
  bool final_types = false;      ///< as the daemon's dds.types: true for "final"
  std::chrono::milliseconds wait{3000};  ///< how long to look for the daemon
  const std::atomic<bool>* stop =
      nullptr;  ///< set by another thread or a signal handler: ends waiting; null: none

  /// `stop` was set.
  bool stopped() const noexcept { return stop != nullptr && stop->load(); }
  /// A program's participant on that bus.
  ParticipantOptions participant() const;
};

/// 16 random bytes: no two clients have the same. Throws SetupError.
std::array<std::uint8_t, 16> random_client_identity();

/// The daemons of a bus, as a program sees them. One thread.
class DaemonSight {
 public:
  /// Why no request may be sent now.
  struct Obstacle {
    bool gone = false;  ///< no daemon is there; false: one may not be asked, cause CAUSE_OTHER_DAEMON
    std::string reason;
  };

  /// Endpoints of this program over which a daemon is asked and answers. What its identity may not write does
  /// not count.
  struct Ways {
    std::vector<const WriterBase*> requests;
    std::vector<const ReaderBase*> replies;
  };

  /// `participant` and `signal` must outlive the object. Throws SetupError.
  DaemonSight(const Participant& participant, DataSignal& signal, std::string bus);

  /// Waits until exactly one daemon is seen, all `ways` lead to it and `matched()` is true, looking again
  /// whenever `signal` rises. The endpoints of `ways` must outlive the object. Throws NoDaemon when
  /// `options.wait` is over, `options.stop` is set or several daemons serve the bus. `protocol`: what the
  /// daemon's file must say of bus.protocol, empty: any; `other_topics`: endpoints are matched that a daemon
  /// of another data model has, too.
  template <class Matched, class OtherTopics>
  void find(const ClientOptions& options, DataSignal& signal, std::string_view protocol, Ways ways,
            Matched&& matched, OtherTopics&& other_topics) {
    ways_ = std::move(ways);
    const auto end = std::chrono::steady_clock::now() + options.wait;
    while (!newest_ || !matched() || !reached()) {
      if (choice_.view() == DaemonChoice::View::several) throw NoDaemon(obstacle()->reason);
      if (options.stopped() || std::chrono::steady_clock::now() >= end)
        throw NoDaemon(absent(options, protocol, other_topics()));
      (void)signal.wait(kLookMs);
      signal.clear();
      look();
    }
  }

  /// Takes what the daemons tell of themselves, and looks whom requests are for.
  void look();

  /// The same, waiting at most a second for all ways to a daemon that has just come. Ends when
  /// `options.stop` is set.
  void look_until_reached(const ClientOptions& options, DataSignal& signal);

  /// Why no request may be sent now; nothing: one may. A request that is written before the daemon's reader
  /// is known reaches nobody.
  std::optional<Obstacle> obstacle();

  /// Requests are for one daemon, and it reads what the writer writes.
  bool is_read(const WriterBase& writer) const;
  /// Requests are for one daemon, and it writes what the reader reads.
  bool is_written(const ReaderBase& reader) const;

  /// Which daemon serves the bus, as it told last; nothing before the first time.
  const std::optional<gateway_GatewayStatus>& newest() const noexcept { return newest_; }
  DaemonChoice& choice() noexcept { return choice_; }

  /// Waiting is looked at again so often: `stop` is seen soon.
  static constexpr int kLookMs = 20;

 private:
  /// Requests are for one daemon, and every way leads to it.
  bool reached();
  /// The participant of the daemon whom requests are for; 0: there is none, or several are.
  dds_instance_handle_t participant_of_daemon() const;
  std::string names_of_living() const;
  std::string absent(const ClientOptions& options, std::string_view protocol, bool other_topics) const;

  const Participant& participant_;
  const std::string bus_;
  Reader<gateway_GatewayStatus> statuses_;
  DaemonChoice choice_;  ///< a place is the writer of a status
  std::optional<gateway_GatewayStatus> newest_;
  Ways ways_;
  DaemonChoice::Place reached_ = 0;  ///< to which all ways led; 0: none
};

}  // namespace gateway::dds
