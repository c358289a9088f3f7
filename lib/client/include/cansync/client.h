#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "export.h"
#include "job.h"
#include "types.h"

/// C++ access to a bus that a daemon serves, over the DDS topics (docs/dds-api.md). What the state functions
/// and subscriptions give is looked into with <cansync/topics.h>.
namespace cansync::client::function_blocks {
class SettingSlot;
}

namespace cansync::client {

/// Where the daemon is looked for.
struct CANSYNC_PUBLIC Options {
  std::uint32_t domain = 0;              ///< DDS domain, 0..230
  std::string bus = "can0";              ///< the bus, "HOST/BUS": of that host alone; empty: the only one
  std::string interface = "lo";          ///< network interface
  std::string client_name = "client";    ///< shown in the daemon's journal, at most 64 characters
  std::string xml = {};                  ///< Cyclone DDS configuration instead of the built one; empty: none
  std::chrono::milliseconds wait{5000};  ///< how long to look for the daemon
  std::string security = {};             ///< DDS Security: folder of this program's identity; empty: without
  std::chrono::milliseconds grace =
      kGrace;  ///< how long after its monitoring time a request ends at the latest
  /// Asked every 20 ms, on the waiting thread, while `connect`, a ReferenceWriter or a function that gives a
  /// state waits for the daemon; false ends the wait as if its time were over. Empty: nobody is asked. Must
  /// not throw.
  std::function<bool()> go_on = {};
  bool final_types = false;  ///< as the daemon's dds.types: true for "final"
  /// False: this client only looks. It needs less of DDS and the network, finds daemons of every protocol,
  /// and each request ends as `refused`.
  bool requests = true;
};

/// Result of looking up a slave.
struct CANSYNC_PUBLIC SlaveLookup {
  std::optional<std::uint8_t> slave;
  std::string problem;  ///< why there is none, with the names there are; empty otherwise
};

/// Ends its callback when it is destroyed; after that the callback is not running and never called again.
/// Destroyed in its own callback it ends when that has returned. May outlive the client.
class CANSYNC_PUBLIC Subscription {
 public:
  Subscription() = default;
  Subscription(Subscription&&) noexcept = default;
  /// Ends the callback that this one had, waiting for it while it runs, and takes over the other's.
  Subscription& operator=(Subscription&&) noexcept;
  ~Subscription();
  struct Hold;  ///< internal

 private:
  friend class detail::Link;
  explicit Subscription(std::shared_ptr<Hold> hold) : hold_(std::move(hold)) {}
  std::shared_ptr<Hold> hold_;
};

/// One connection to one bus.
///
/// Every function may be called from any thread. One receiver thread per client takes what arrives and runs
/// the callbacks of subscriptions: these must be short and must not throw. A job of the client cannot be waited for there:
/// its reply comes after them. `wait` and what waits for a reply end at once there.
class CANSYNC_PUBLIC Client {
 public:
  /// Waits until a daemon serves the bus and every request and reply is matched with it, so that nothing is
  /// lost. Throws NoDaemon when `options.wait` is over, SeveralDaemons (a NoDaemon) as soon as two are known
  /// to serve it, SetupError when DDS cannot be set up.
  static Client connect(const Options& options);

  /// Takes the connection over; the other one may only be assigned to and destroyed.
  Client(Client&&) noexcept;
  /// Closes the connection that this one had, as the destructor does, and takes over the other's.
  Client& operator=(Client&&) noexcept;
  /// Open jobs end with `no_reply` here; the daemon goes on with them. In one of its own callbacks: as soon as that has
  /// returned.
  ~Client();

  // --- state: what a daemon that is there told last. Each waits at most 2 s for the first, when it looks at its topic
  // for the first time or the daemon was just started, and throws NoDaemon when none comes: the protocol of the bus may
  // not have it. When no daemon is there any more it throws NoDaemon at once; that one was killed, or its network is cut,
  // is known after 5 s.

  /// Which daemon serves the bus, as it told last: its start, version and data model, host and process; whom
  /// it has refused. At most about a second old.
  GatewayStatus gateway_status() const;
  /// The same, waiting at most `time`; nothing when no daemon that is there has told it.
  std::optional<GatewayStatus> gateway_status(std::chrono::milliseconds time) const;
  /// The CAN controller and its interface. Waits at most 2 s for the first.
  BusStatus bus_status() const;
  /// The same, waiting at most `time`; nothing when no daemon that is there has told it.
  std::optional<BusStatus> bus_status(std::chrono::milliseconds time) const;
  /// What the realtime thread was granted, and what its timeline follows. Waits at most 2 s for the first.
  RealtimeStatus realtime_status() const;
  /// The same, waiting at most `time`; nothing when no daemon that is there has told it.
  std::optional<RealtimeStatus> realtime_status(std::chrono::milliseconds time) const;
  /// The line of CANsync as the daemon told it last; at most about a second old.
  MasterStatus master_status() const;
  /// The same, waiting at most `time`; nothing when no daemon that is there has told it.
  std::optional<MasterStatus> master_status(std::chrono::milliseconds time) const;
  /// Waits at most `time` until the master's status fits, looking at each one that comes (at least one a
  /// second): for example until `status.slaves_synchronized == status.slaves_configured`. That status;
  /// nothing when none has fitted. What a daemon that is gone told last does not count. `fits` may use this client; the
  /// time that it takes counts.
  std::optional<MasterStatus> wait_status(const std::function<bool(const MasterStatus&)>& fits,
                                          std::chrono::milliseconds time) const;
  /// Configured slaves in rising order. Waits at most `time` until the status of every configured slave is
  /// there. Throws NoDaemon when no daemon is there.
  std::vector<SlaveStatus> slaves(std::chrono::milliseconds time = std::chrono::milliseconds(2000)) const;
  /// Newest actual values of a slave. Waits at most `time` for the first; nothing when there are none yet.
  std::optional<ActualValues> actual_values(
      std::uint8_t slave, std::chrono::milliseconds time = std::chrono::milliseconds(500)) const;
  /// The slave with this number (decimal or 0x hexadecimal, 0..31) or name. Waits like `slaves`.
  SlaveLookup find_slave(std::string_view number_or_name) const;
  /// True while a daemon is matched.
  bool daemon_present() const;
  /// Who they are and what helps, while more than one daemon serves the bus, or only that of another computer than
  /// Options::bus names: then states are those of either, and every request is refused. Empty: not so.
  std::string several_daemons() const;
  /// Other DDS participants known in the domain now: on `lo` daemons and programs without this library, on
  /// other interfaces clients too.
  std::uint32_t participants() const noexcept;
  /// The last events, at most 100 of each severity, oldest first: collected until none comes for `quiet`, for at most
  /// 2 s.
  std::vector<Event> recent_events(std::chrono::milliseconds quiet = std::chrono::milliseconds(300)) const;

  // --- subscriptions: state topics deliver what is known at once. Throw SetupError like every function that
  // is the first to look at a topic.

  /// Each actual value telegram of each slave as it arrives; `arrived` tells which of the two it was.
  [[nodiscard]] Subscription on_actual_values(std::function<void(const ActualValues&)> callback);
  /// On every change and once a second.
  [[nodiscard]] Subscription on_gateway_status(std::function<void(const GatewayStatus&)> callback);
  /// Likewise.
  [[nodiscard]] Subscription on_bus_status(std::function<void(const BusStatus&)> callback);
  /// Likewise.
  [[nodiscard]] Subscription on_realtime_status(std::function<void(const RealtimeStatus&)> callback);
  /// On every change and once a second.
  [[nodiscard]] Subscription on_master_status(std::function<void(const MasterStatus&)> callback);
  /// The daemon was started anew: settings that clients made before are lost, interval and event numbers
  /// begin again. Noticed by GatewayStatus.daemon, however short it was away; counted from this call.
  [[nodiscard]] Subscription on_restart(std::function<void(const GatewayStatus&)> callback);
  /// Each slave on every change, at most every 100 ms a slave.
  [[nodiscard]] Subscription on_slave_status(std::function<void(const SlaveStatus&)> callback);
  /// The last 100 events of each severity first, then each as it happens.
  [[nodiscard]] Subscription on_event(std::function<void(const Event&)> callback);
  /// Once a second: lateness and slot times in ns, bus load in permille. Best effort: one may be missing.
  [[nodiscard]] Subscription on_timing(std::function<void(const Timing&)> callback);
  /// Only when the daemon's configuration switches the Interval topic on.
  [[nodiscard]] Subscription on_interval(std::function<void(const Interval&)> callback);

  // --- jobs: submit returns at once, the others wait for the terminal reply. Beyond `kOpenRequests` open at
  // a time a request is refused here.
  //
  // A request is for one start of the daemon, and no other takes it. When the daemon was started anew, open
  // ones end with `no_reply`; the first request after that is refused here unless the program knows it
  // already: by `on_restart`, or by a request that ended so or found no daemon. While it is not known whether
  // the daemon before is dead (2.5 s at most after it was heard last), and while several daemons serve the
  // bus, every request is refused here; `reason` names program, process and host of each.

  /// Sends the request and returns its job; what is wrong with it is the job's reply, never an exception.
  ParameterJob submit(const ParameterRequest& request);
  TransferJob submit(const TransferRequest& request);
  /// Reads the value of parameter 0..4095 of slave 0..31 (M 4.12). `timeout_ms`: monitoring time, 0: the
  /// daemon's default. Always ends; see Job::wait.
  ParameterReply read(std::uint32_t slave, std::uint32_t number, std::uint32_t timeout_ms = 0);
  /// Writes a raw value in the format that the slave has (M 4.14), otherwise like `read`. After `no_answer`
  /// or `no_reply` read it back: whether the slave took it is not known.
  ParameterReply write(std::uint32_t slave, std::uint32_t number, std::uint32_t value,
                       std::uint32_t timeout_ms = 0);
  /// Reads `length` bytes (1..16777216) from a start address (0x00..0xFF are reserved; M 4.24) into the
  /// reply's `data`. `on_progress` runs on this thread. Always ends; to stop it before, submit and use
  /// Job::wait with a stop flag.
  TransferReply upload(std::uint32_t slave, std::uint32_t address, std::uint32_t length,
                       const OnProgress& on_progress = {});
  /// Writes 1..16777216 bytes to a start address (M 4.24), otherwise like `upload`. When it fails, `done`
  /// bytes were confirmed: the slave may hold a part.
  TransferReply download(std::uint32_t slave, std::uint32_t address, std::vector<std::uint8_t> data,
                         const OnProgress& on_progress = {});

  // --- commands: answered when they were on the bus, or are in effect

  /// A newer word of the slave, of any client, replaces one that waits (`replaced`). What is not sent within
  /// `timeout_ms` ends as `timeout`; 0: the daemon's default.
  CommandJob control_word(std::uint32_t slave, std::uint32_t word, std::uint32_t timeout_ms = 0);
  /// Action command to a group of slaves (M 4.2 to 4.4), which never answer it: done means seen on the bus.
  /// `replaced`: a stop, or the failsafe reaction, took the place of a word that enables.
  CommandJob broadcast(const Broadcast& broadcast);
  /// `force`: Mode::run also when slaves are missing.
  CommandJob mode(Mode mode, bool force = false);
  /// Lets a slave that was away and is held out be used again: after its list of parameters, or with `force`
  /// at once.
  CommandJob release(std::uint32_t slave, bool force = false);
  /// Which slaves are asked for actual values (M 4.19); all of it or, when refused, nothing. Lost when the
  /// daemon is started anew, like the three below: see `on_restart`.
  CommandJob polling(const Polling& polling);
  /// Which slaves the command channel serves, for each kind of job (M 4.6); all of it or nothing.
  CommandJob cursors(const Cursors& cursors);
  /// Mapping of the reference value telegrams (M 4.15). Another one than that in force ends what is released,
  /// and writers give nothing until `take_up`.
  CommandJob map_references(const MappingBytes& mapping);
  /// How a slave's actual value telegrams are read (M 4.16): it must be what the slave itself sends by, which
  /// is not checked.
  CommandJob map_actuals(std::uint32_t slave, const MappingBytes& mapping);

  /// What settings and reference values hold for now, as the daemon has told last.
  Validity validity() const;

  /// "DDS domain 3, partition can0, interface lo", for messages.
  std::string place() const;

 private:
  friend class ReferenceRepeater;
  friend class ReferenceWriter;
  friend class function_blocks::SettingSlot;
  explicit Client(std::shared_ptr<detail::Link> link);
  std::shared_ptr<detail::Link> link_;
};

/// In the place of a strength: one more than that of whoever has it when the writer is made, so that this one
/// takes over.
inline constexpr std::int32_t kTakeOver = std::numeric_limits<std::int32_t>::min();

/// Gives reference values. A telegram has one writer at a time, as the daemon decides: it keeps the telegram
/// until it gives it up, is lost, or a stronger one comes. While another writer has it that is no weaker,
/// `write` writes nothing and says so; the first `write` after that one has gone is taken. When this object is
/// destroyed it gives its telegrams up: their release ends at once, and another writer's next values are taken.
/// When its process dies (lease 500 ms), its telegrams are lost, and another writer's next values are taken, or
/// release stops. That is noticed for a dead process, not for one that hangs: `release_intervals` bounds how
/// long the last values of a hanging one are released.
///
/// What is written holds for one start of the daemon and one mapping of the reference values: those of the
/// construction, or of the last `take_up`. After the daemon was started anew, or the mapping was changed,
/// nothing is taken any more until the program has looked at the line and calls `take_up`. One thread at a
/// time.
class CANSYNC_PUBLIC ReferenceWriter {
 public:
  /// `strength`: 0 and more, or kTakeOver. Throws SetupError, also when the identity has no right to. Waits at most 2
  /// s until the daemon is matched; throws NoDaemon.
  explicit ReferenceWriter(Client& client, std::int32_t strength = 0);
  /// Gives up what was written; may take 300 ms when the daemon does not take samples.
  ~ReferenceWriter();
  /// Takes the telegrams over; the other one may only be assigned to and destroyed.
  ReferenceWriter(ReferenceWriter&&) noexcept;
  /// Gives up what this one wrote, as the destructor does, and takes over the other's telegrams.
  ReferenceWriter& operator=(ReferenceWriter&&) noexcept;

  /// Gives values of telegram 1 (values 0..3) or 2 (values 4..7); bit n of `valid`: value[n] is new. They are
  /// released in `release_intervals` intervals in a row (1: exactly once), from `from_interval` on (0: the
  /// next). Empty, or what failed: with a standing other than `current` nothing is written, and telegrams
  /// given before are given up; while another writer has the telegram (`waits`) nothing is written. Bad values are reported by the daemon as an event.
  std::string write(std::uint8_t telegram, const std::array<std::int32_t, 4>& value, std::uint8_t valid,
                    std::uint32_t release_intervals = 1, std::uint64_t from_interval = 0);

  /// The last `write` wrote nothing, because another writer has the telegram that is no weaker.
  bool waits() const;
  /// Of this writer; with kTakeOver as it was chosen.
  std::int32_t strength() const;

  /// Gives the telegram up: its release ends at once, and the next values of another writer are taken. A
  /// later `write` takes it again. May take 300 ms when the daemon does not take samples.
  void release(std::uint8_t telegram);

  /// Whether what is written is still meant for the daemon and the mapping in force.
  ReferenceStanding standing() const;

  /// What is written from now on is meant for the daemon and the mapping in force now. Make settings and look
  /// at the line before.
  void take_up();
  /// Likewise, for what the program has looked at (Client::validity); is that over already, the standing says
  /// so.
  void take_up(const Validity& meant_for);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cansync::client
