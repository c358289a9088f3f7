#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "dds/ask/daemon_choice.h"
#include "dds/endpoint.h"
#include "dds/gateway_topics.h"
#include "dds/participant.h"
#include "dds/signal.h"

/// What client libraries share: how programs name a bus; and, those of all protocols but the master's, how the
/// daemon of a bus is found, and whom requests are for.
namespace gateway::dds {

/// No daemon serves the bus, or several do; the text says where it was looked for, or who they are, and the
/// remedy.
class NoDaemon : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The bus is served, but with another protocol than the program needs.
class OtherProtocol : public NoDaemon {
 public:
  OtherProtocol(std::string_view bus, std::string_view served_as, std::string_view needs);
  std::string bus;
  std::string served_as;  ///< bus.protocol of the daemon
  std::string needs;      ///< what bus.protocol must be
};

/// The bus that a program means, as people type it: `can0`, or `plc2/can0` for that of one computer alone.
struct BusAddress {
  std::string computer;  ///< its host name, as GatewayStatus.host has it; empty: any
  std::string bus;       ///< the DDS partition

  /// May a daemon of this host name be asked?
  bool is_on(std::string_view host) const noexcept { return computer.empty() || computer == host; }
  /// For messages: "can0", or "can0 of computer plc2".
  std::string in_words() const { return computer.empty() ? bus : bus + " of computer " + computer; }
};

/// Takes the address apart at its first `/`, which no bus name has. Pure; any thread.
BusAddress bus_address(std::string_view text);

/// Why the daemon `found` ("'..' (cansyncd, process 12 on host plc1)") is not asked; `place`: where it was found. Pure; any
/// thread.
std::string on_other_computer(const BusAddress& wanted, std::string_view place, std::string_view found);

/// How to find the daemon.
struct ClientOptions {
  std::uint32_t domain = 0;      ///< DDS domain, 0..230
  std::string bus = "sim";       ///< the bus (`BusAddress`); of one that looks at every bus: any
  std::string interface = "lo";  ///< network interface
  std::string client_name;       ///< for the daemon's journal
  std::string xml;               ///< Cyclone DDS configuration used instead of the built one; empty: none
  std::string security;          ///< folder of the identity; empty: without DDS Security
  bool final_types = false;      ///< as the daemon's dds.types: true for "final"
  std::chrono::milliseconds wait{3000};  ///< how long to look for the daemon
  const std::atomic<bool>* stop =
      nullptr;  ///< set by another thread or a signal handler: ends waiting; null: none
  std::function<bool()> go_on =
      {};  ///< asked while something is waited for: false ends it; empty: nobody is asked

  /// `stop` was set, or `go_on` says no.
  bool stopped() const { return (stop != nullptr && stop->load()) || (go_on && !go_on()); }
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
    bool passes =
        false;  ///< soon, without anybody doing anything; what is asked then is for the daemon that is meant now
  };

  /// Endpoints of this program over which a daemon is asked and answers. What its identity may not write does
  /// not count.
  struct Ways {
    std::vector<const WriterBase*> requests;
    std::vector<const ReaderBase*> replies;
  };

  /// `participant` and `signal` must outlive the object. `bus`: with a computer, no daemon of another one is asked. Throws
  /// SetupError.
  DaemonSight(const Participant& participant, DataSignal& signal, std::string_view bus);

  /// Waits until exactly one daemon is seen, all `ways` lead to it and `matched()` is true, looking again
  /// whenever `signal` rises. The endpoints of `ways` must outlive the object. Throws NoDaemon when
  /// `options.wait` is over, `options.stop` is set or several daemons serve the bus; OtherProtocol as soon as the only one
  /// is known to have another. `protocol`: what the daemon's file must say of bus.protocol, empty: any; `other_topics`: endpoints are matched that a daemon
  /// of another data model has, too.
  template <class Matched, class OtherTopics>
  void find(const ClientOptions& options, DataSignal& signal, std::string_view protocol, Ways ways,
            Matched&& matched, OtherTopics&& other_topics) {
    ways_ = std::move(ways);
    const auto end = std::chrono::steady_clock::now() + options.wait;
    while (!newest_ || !matched() || !reached()) {
      if (choice_.view() == DaemonChoice::View::several) throw NoDaemon(obstacle()->reason);
      if (serves_another(protocol)) throw OtherProtocol(address_.bus, newest_->protocol, protocol);
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

  /// Several daemons serve the bus: requests are for none of them.
  bool sees_several() const noexcept { return choice_.view() == DaemonChoice::View::several; }

  /// Which daemon serves the bus, as it told last; nothing before the first time.
  const std::optional<gateway_GatewayStatus>& newest() const noexcept { return newest_; }
  DaemonChoice& choice() noexcept { return choice_; }

  /// Waiting is looked at again so often: `stop` is seen soon.
  static constexpr int kLookMs = 20;

 private:
  /// Requests are for one daemon of the computer that is meant, and every way leads to it.
  bool reached();
  /// The only daemon is that of a computer that is not meant.
  bool on_other_computer() const;
  /// The participant of the daemon whom requests are for; 0: there is none, or several are.
  dds_instance_handle_t participant_of_daemon() const;
  std::string names_of_living() const;
  /// The only daemon of the bus has another protocol; empty: any will do.
  bool serves_another(std::string_view protocol) const;
  std::string absent(const ClientOptions& options, std::string_view protocol, bool other_topics) const;

  const Participant& participant_;
  const BusAddress address_;
  Reader<gateway_GatewayStatus> statuses_;
  DaemonChoice choice_;  ///< a place is the writer of a status
  std::optional<gateway_GatewayStatus> newest_;
  std::map<DaemonChoice::Place, std::string> hosts_;  ///< of daemons that are matched
  Ways ways_;
  DaemonChoice::Place reached_ = 0;  ///< to which all ways led; 0: none
};

}  // namespace gateway::dds
