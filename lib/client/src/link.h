#pragma once

#include <cansync/client.h>
#include <cansync/topics.h>

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include "cansync/dds/convert.h"
#include "cansync/dds/topics.h"
#include "client/src/feed.h"
#include "client/src/job_state.h"
#include "client/src/settings_book.h"
#include "dds/ask/daemon_choice.h"
#include "dds/ask/daemon_sight.h"
#include "dds/endpoint.h"
#include "dds/owner_seen.h"
#include "dds/participant.h"

/// Internal to lib/client.
namespace cansync::client::detail {

/// The DDS side of a Client: entities, open jobs and the receiver thread. Every function may be called from
/// any thread.
class Link : public std::enable_shared_from_this<Link> {
 public:
  /// Throws SetupError and dds::SetupError.
  explicit Link(const Options& options);
  ~Link();
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  /// How often `go_on` is to be asked while something is waited for.
  static constexpr std::chrono::milliseconds kAsk{20};

  /// Starts the receiver thread and waits for the daemon. Throws NoDaemon, SeveralDaemons.
  void connect(std::chrono::milliseconds wait);
  /// Asks the program whether to wait any longer.
  bool go_on() const;

  /// Ends the receiver thread and every open job. Not from a callback.
  void close();
  /// Is this the receiver thread, which runs the callbacks?
  bool is_receiver() const noexcept { return receiver_id_ == std::this_thread::get_id(); }

  bool daemon_present() const;
  /// Why nothing is asked or given now, because several daemons serve the bus, or only that of another computer than the
  /// program means; else empty.
  std::string several_daemons() const;
  /// Is this start of the daemon the one that is there?
  bool is_there(const dds::DaemonIdentity& start) const;
  /// Are requests for this start of the daemon, and does it hear them?
  bool asks(const dds::DaemonIdentity& start) const;
  /// The start of the daemon that told of itself last, whether it is there or not; nothing: none has.
  std::optional<dds::DaemonIdentity> told_start() const;
  /// The program was told of this start of the daemon.
  void program_told_of(const dds::DaemonIdentity& start);
  /// As the daemon has told last; after `connect`. `mapping` (null: not wanted): the reference mapping of it.
  Validity validity(MappingBytes* mapping = nullptr) const;
  /// What the daemon has told last of who gives the reference values of telegrams 1 and 2: `look(owners)`.
  template <class Look>
  auto with_owners(Look&& look) const {
    decltype(look(dds::OwnerSeen{}, dds::OwnerSeen{})) out{};
    master_.look([&](const std::vector<MasterStatus>& known) {
      if (known.empty()) return;
      const auto seen = [&](unsigned telegram) {
        const auto& release = known.front().reference_release[telegram];
        return dds::owner_seen(release.writer, release.strength, release.writer_guid);
      };
      out = look(seen(0), seen(1));
    });
    return out;
  }
  /// Of the function blocks.
  SettingsBook& settings() noexcept { return settings_; }
  /// Throws OtherProtocol when the bus is known to be served with another protocol than CANsync's master.
  void expect_own_protocol() const;
  /// That no daemon is there, and where one was looked for.
  std::string gone() const;
  /// Why nothing was written to a topic that the identity may not write.
  std::string not_permitted(std::string_view topic) const;
  const dds::Participant& participant() const noexcept { return participant_; }
  /// The client's name for the daemon's journal.
  const std::string& name() const noexcept { return options_.client_name; }

  std::shared_ptr<JobState<ParameterReply>> submit(const ParameterRequest& request);
  std::shared_ptr<JobState<TransferReply>> submit(const TransferRequest& request);
  /// Client and number are filled in here.
  std::shared_ptr<JobState<CommandReply>> submit(cansync_Command command);
  bool cancel(std::uint64_t request);

  /// The feed with its reader open.
  template <class T>
  Feed<T>& open();
  /// The newest sample of a topic without keys, of a daemon that is there; waits for the first. Throws NoDaemon.
  template <class T>
  T first(std::string_view topic);
  /// The same; nothing when it does not come within `time`.
  template <class T>
  std::optional<T> first_within(std::chrono::milliseconds time);
  template <class T>
  Subscription subscribe(std::function<void(const T&)> callback);

 private:
  using Identity = std::array<std::uint8_t, 16>;
  /// A status that came, for the choice of the daemon.
  struct Heard {
    dds_instance_handle_t writer;
    dds::DaemonIdentity daemon;
    std::string host;
    std::string protocol;
  };

  /// Requests out, replies in.
  struct Requests {
    /// `identity`: whose replies come here.
    Requests(const dds::Participant& participant, const Identity& identity, dds::DataSignal* signal,
             bool secured);

    dds::Writer<cansync_ParameterRequest> parameter_writer;
    dds::Writer<cansync_TransferRequest> transfer_writer;
    dds::Writer<cansync_Command> command_writer;
    dds::Writer<gateway_JobCancel> cancel_writer;
    std::optional<dds::Writer<cansync_Command>> engineer_writer;  ///< with DDS Security on
    dds::Reader<cansync_ParameterReply> parameter_reader;
    dds::Reader<cansync_TransferReply> transfer_reader;
    dds::Reader<cansync_TransferProgress> progress_reader;
    dds::Reader<cansync_CommandReply> command_reader;
  };

  /// A new job; ended already when too many are open.
  template <class R>
  std::shared_ptr<JobState<R>> begin(OpenJobs<R>& jobs, std::chrono::milliseconds monitoring);
  /// The monitoring time of a request: its own, or that of the daemon.
  std::chrono::milliseconds monitoring(std::uint32_t own_ms, std::uint32_t MasterStatus::*otherwise) const;
  /// Why no request may be sent now, with its code; nothing: one may. Under the lock; the program is told by
  /// it.
  std::optional<std::pair<ReplyCode, std::string>> obstacle();
  /// "one, process 12 on host a; another, ...": the daemons that may live. Under the lock.
  std::string names_of_living() const;
  std::string several_text() const;
  /// Why the only daemon is not asked: its computer is not the one that is meant. Empty: it may be. Under the lock.
  std::string on_other_computer() const;
  template <class Request, class State>
  void address(Request& request, const State& state) const;
  template <class R, class Request>
  void send(dds::Writer<Request>& writer, std::string_view topic, const Request& request, OpenJobs<R>& jobs,
            JobState<R>& state);
  template <class T>
  Feed<T>& feed();
  template <class Sample>
  bool mine(const Sample& sample) const;

  void receive();
  void take_replies();
  void take_command_replies();
  void take_transfer_replies();
  void take_progress();
  /// Takes what has come, and forgets what daemons have told that are there no more.
  void take_feeds(const std::vector<Place>& matched, bool present);
  /// Tells the program of it.
  void tell_feeds();
  template <class Use>
  void with_feeds(Use&& use);
  void end_lost_jobs();
  /// Cancels and ends the jobs whose reply does not come.
  void end_overdue_jobs();
  /// Where the writers matched with a reader of replies or statuses are, each place once.
  std::vector<Place> matched_places(dds_entity_t reader);
  /// Where a writer matched with `reader` is; 0 when it has left.
  Place place_of(dds_entity_t reader, dds_instance_handle_t writer);
  /// Looks which daemon requests are for; `matched` are there.
  void choose_daemon(const std::vector<Place>& matched);
  /// True when all of these daemons hear what is written on every topic, and have been heard. Other programs
  /// that read requests do not count.
  bool everything_matched(const std::vector<Place>& daemons);
  std::string not_found(std::chrono::milliseconds waited) const;
  std::string not_told(std::string_view topic) const;
  std::string other_protocol() const;

  Options options_;
  const dds::BusAddress address_;
  Identity identity_;
  dds::Participant participant_;
  dds::DataSignal signal_;

  std::optional<Requests> requests_;  ///< nothing: this client only looks

  SettingsBook settings_;
  Feed<GatewayStatus> gateway_;
  Feed<BusStatus> bus_;
  Feed<RealtimeStatus> realtime_;
  Feed<MasterStatus> master_;
  Feed<SlaveStatus> slaves_;
  Feed<ActualValues> actual_;
  Feed<Event> events_;
  Feed<Timing> timing_;
  Feed<Interval> interval_;

  mutable std::mutex mutex_;  // everything below
  std::condition_variable ready_changed_;
  bool ready_ = false;
  std::string protocol_;  ///< of the daemon that was heard last; empty: none was
  bool closed_ = false;
  std::uint64_t last_request_ = 0;
  bool present_ = false;    ///< a daemon is matched
  bool reachable_ = false;  ///< all of them hear every request, and their replies get here
  dds::DaemonChoice choice_;
  /// A daemon that was heard and is matched.
  struct Seen {
    std::string name;  ///< for people
    std::string host;
  };
  std::map<Place, Seen> seen_;
  OpenJobs<ParameterReply> parameter_jobs_;
  OpenJobs<TransferReply> transfer_jobs_;
  OpenJobs<CommandReply> command_jobs_;

  std::mutex heard_mutex_;
  std::vector<Heard> heard_;  // since the last look
  std::mutex places_mutex_;
  std::map<dds_instance_handle_t, Place> places_;  // of writers that are matched

  // Receiver thread only.
  std::chrono::steady_clock::time_point looked_at_time_;
  std::vector<Place> reached_;  // daemons of which every topic is known
  std::atomic<bool> stop_ = false;
  std::atomic<std::thread::id> receiver_id_;
  std::thread receiver_;
};

template <>
inline Feed<GatewayStatus>& Link::feed() {
  return gateway_;
}
template <>
inline Feed<BusStatus>& Link::feed() {
  return bus_;
}
template <>
inline Feed<RealtimeStatus>& Link::feed() {
  return realtime_;
}
template <>
inline Feed<MasterStatus>& Link::feed() {
  return master_;
}
template <>
inline Feed<SlaveStatus>& Link::feed() {
  return slaves_;
}
template <>
inline Feed<ActualValues>& Link::feed() {
  return actual_;
}
template <>
inline Feed<Event>& Link::feed() {
  return events_;
}
template <>
inline Feed<Timing>& Link::feed() {
  return timing_;
}
template <>
inline Feed<Interval>& Link::feed() {
  return interval_;
}

template <class T>
Feed<T>& Link::open() {
  feed<T>().open(participant_, signal_);
  return feed<T>();
}

template <class T>
T Link::first(std::string_view topic) {
  constexpr std::chrono::milliseconds kFirst(2000);
  // Only a bus of CANsync has it: what will never come is not waited for.
  if constexpr (std::is_same_v<T, MasterStatus>) expect_own_protocol();
  // Of a daemon that has gone nothing comes; a program that looks in each of its cycles is not held up.
  const bool present = daemon_present();
  const std::optional<T> newest = first_within<T>(present ? kFirst : std::chrono::milliseconds(0));
  if (!newest) throw NoDaemon(daemon_present() ? not_told(topic) : gone());
  return *newest;
}

template <class T>
std::optional<T> Link::first_within(std::chrono::milliseconds time) {
  return open<T>().wait_present(time);
}

template <class T>
Subscription Link::subscribe(std::function<void(const T&)> callback) {
  auto hold = std::make_shared<Subscription::Hold>();
  hold->callback = std::make_shared<const std::function<void(const void*)>>(
      [function = std::move(callback)](const void* sample) { function(*static_cast<const T*>(sample)); });
  open<T>().add(hold);
  signal_.raise();  // what is known already is delivered now
  return Subscription(std::move(hold));
}

}  // namespace cansync::client::detail
