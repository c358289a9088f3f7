#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "daemon/desk/audit.h"
#include "daemon/desk/client_table.h"
#include "daemon/desk/dropped_replies.h"
#include "daemon/desk/fair_lanes.h"
#include "daemon/desk/gateway_events.h"
#include "daemon/desk/gateway_replies.h"
#include "daemon/desk/job_book.h"
#include "daemon/desk/job_end_topic.h"
#include "daemon/desk/job_protocol.h"
#include "daemon/desk/open_requests.h"
#include "daemon/desk/rejections.h"
#include "daemon/desk/request_readers.h"
#include "daemon/desk/request_topic.h"
#include "dds/daemon_identity.h"
#include "dds/denial.h"
#include "dds/gateway_topics.h"
#include "dds/signal.h"

namespace cansyncd {

/// Takes the requests of clients, hands them on, and answers each exactly once. What requests there are and
/// what they mean is `Protocol`'s (job_protocol.h says what that has to provide). Gateway thread only.
///
/// A request is refused at once, and its reply says why, when a field is out of range, when its number was
/// used before (nothing is executed twice; an open request is answered by itself), when it is stale, when its
/// client has `JobBook::kPerClient` requests open, or when open transfers need too much memory. Otherwise it
/// waits its turn (`FairLanes`). The requests of a client that is gone are cancelled.
///
/// What is meant for another start of a daemon is neither taken nor answered: that one answers, and its
/// client would repeat what was refused here. What names no start is refused.
///
/// Everybody is told who is connected and what is open (topic OpenRequests), and engineers may end what is
/// (topic JobEnd).
///
/// No reply is given to who uses another program's identity: that program would take it for its own.
///
/// Only who uses a desk of a protocol for the first time includes job_desk_requests.h, job_desk_answers.h
/// and job_desk_oversight.h, which have the definitions, and instantiates it there.
template <RequestProtocol Protocol>
class JobDesk {
 public:
  using Context = typename Protocol::Context;
  using Request = typename Protocol::Request;
  using Terminal = typename Protocol::Terminal;
  using Outcome = typename Protocol::Outcome;
  using Newer = typename NewerOf<Protocol>::Type;

  /// Least time between two samples of the progress of one request.
  static constexpr std::chrono::milliseconds kProgressPeriod{50};
  /// Longest time between two, also while it waits: its client sees that it is not lost.
  static constexpr std::chrono::seconds kSignPeriod{1};

  /// Throws gateway::dds::SetupError. `signal`, `events` and `audit` must outlive this object. `daemon`: this
  /// start; `secured`: DDS Security is on.
  JobDesk(const gateway::dds::Participant& participant, gateway::dds::DataSignal& signal,
          EventPublisher& events, AuditTrail& audit, Protocol protocol,
          const gateway::dds::DaemonIdentity& daemon, bool secured);

  /// Programs that read what this writer writes are told of as connected, though they may ask for nothing.
  void set_read_by_all(const gateway::dds::WriterBase& writer) noexcept {
    open_requests_.set_read_by_all(writer);
  }

  /// Takes new requests and cancels, a bounded number, and looks which clients are gone. True: there may be
  /// more.
  bool take_requests(const Context& context);

  /// A job ended, or was refused by whoever executes it. An unknown one is ignored.
  void finish(const Terminal& terminal, const Context& context);

  /// Of the data of a job, so many bytes are done.
  void progress(JobId id, std::uint32_t bytes, SteadyTime now);

  /// Ends what waits here and has lost its turn to `newer`.
  void replace_waiting(const Newer& newer, const Context& context);

  /// Gives a request of the daemon itself; a refusal becomes an event.
  void give(Request request) requires GivesOwn<Protocol>;

  /// Writes what could not be written or handed on before. Returns when to call again; nothing: no need.
  std::optional<SteadyTime> retry(const Context& context);

  /// Answers every open request, and those that still come in this call, as stopped. Transfers' data stays
  /// until this object is destroyed, because the realtime thread may still have it.
  void stop(const Context& context);

  /// Stops, and waits at most half a second each until the replies are written and until the clients have
  /// them. `context()` makes a context of now; `signal`: of the constructor.
  void stop_and_deliver(gateway::dds::DataSignal& signal, const std::function<Context()>& context);

  /// Asks the protocol for its limits anew.
  void renew_limits() { lanes_.set_limits(protocol_.lane_limits()); }

  /// True while replies wait to be written (`retry` writes them).
  bool replies_waiting() const noexcept;

  /// Clients that live or have open requests.
  std::size_t clients() const noexcept { return book_.clients().size(); }
  const RejectionCounts& rejections() const noexcept { return rejections_.counts(); }

  /// Waits at most `time` on each reply topic until the clients have what was written.
  void wait_for_readers(dds_duration_t time) const noexcept;

 private:
  static constexpr std::size_t kTopics = std::tuple_size_v<decltype(Protocol::Topics::all)>;
  /// In the place of a topic: a request of the daemon itself.
  static constexpr std::size_t kOwn = kTopics;
  /// Likewise: a request to end another one, which is answered at once.
  static constexpr std::size_t kEnd = kTopics + 1;

  struct Job {
    std::size_t topic = kOwn;  ///< index into the protocol's topics
    gateway::dds::RequestKey key;
    Place place = {};
    Requester who;
    std::optional<Change> change;  ///< nothing: it only reads
    typename StateBeforeOf<Protocol>::Type state_before = {};
    Request request = {};
    bool understood = false;  ///< `request` is what was asked for
    std::vector<std::uint8_t> data;
    bool cancel_wanted = false;
    std::int64_t time = 0;   ///< when it was taken, CLOCK_REALTIME in ns
    std::uint32_t done = 0;  ///< bytes of a transfer
    SteadyTime next_progress;
  };
  using Jobs = std::map<JobId, Job>;

  /// Calls `use(topic, index)` for each topic.
  template <class Use>
  void each_topic(Use&& use);
  /// The same, and for that of requests to end others.
  template <class Use>
  void each_outbox(Use&& use);
  /// Calls `use(topic)` for one of them, if there is such a one.
  template <class Use>
  void with_topic(std::size_t index, Use&& use);

  template <class Topic>
  bool accept_from(Topic& topic, std::size_t index, const Context& context);
  template <class Row>
  void accept(const typename Row::Sample& sample, Job job, Right right, std::int64_t written,
              const Context& context);
  /// What is wrong with a request whose fields are in range.
  gateway::dds::Problem objection(const Request& request, Right right, const Context& context);
  /// Answers those for which a client had too many waiting.
  bool refuse_turned_away(const Context& context);
  /// The client of a request that may be taken; null: it was answered, or must not be.
  ClientEntry* admit(Job& job, std::int64_t written, const Context& context);
  void refuse(const Job& job, const gateway::dds::Denial& denial, const Context& context);
  bool take_cancels(const Context& context);
  void take_cancel(const gateway_JobCancel& sample, const Place& place, const Context& context);
  bool take_ends(const Context& context);
  void take_end(const gateway_JobEnd& sample, Job asked, std::int64_t written, const Context& context);
  /// What was asked for, in words.
  std::string open_text(const Job& job, const Context& context) const;
  /// Publishes who is connected and what is open, when that is news and due. When to call again.
  std::optional<SteadyTime> tell_open(const Context& context);
  /// Clients take turns in a lane: without this, what was given earlier could go out later.
  void make_way_for(const Request& newer, const Context& context);
  /// Ends a job that waits; one that was handed on ends by itself, soon.
  void cancel(typename Jobs::iterator job, const Context& context);
  void look_for_clients(const Context& context);
  void tell_gone(const ClientIdentity& identity, const ClientEntry& client, const Context& context);
  void hand_on_own(const Context& context);

  /// Replies to a job that ended without a result of its own: cancelled before it began, or all stopped.
  void end(Job& job, Outcome outcome, const Context& context);
  void answer(Job& job, const Terminal& terminal, const Context& context);
  /// Nothing is kept of a client that is gone and has every answer.
  void forget(const ClientIdentity& identity, SteadyTime now);
  void erase(typename Jobs::iterator job, SteadyTime now);
  std::string before(const Job& job);
  void record_end(const Job& job, Outcome outcome, const Context& context);
  void tell_dropped(SteadyTime now);
  /// Publishes the progress of transfers that are open and have had none for long. When to call again.
  std::optional<SteadyTime> show_open_transfers(SteadyTime now);

  Protocol protocol_;
  const gateway::dds::DaemonIdentity daemon_;
  RequestReaders readers_;
  typename Protocol::Topics topics_;
  GuardedReader<gateway_JobCancel> cancels_;
  RequestTopic<JobEndTopic> ends_;
  OpenRequestsTopic open_requests_;
  EventPublisher& events_;
  AuditTrail& audit_;
  PlaceFinder places_;
  Rejections rejections_;
  JobBook book_;

  Jobs jobs_;
  FairLanes lanes_;
  std::deque<Request> own_;                           ///< requests of the daemon itself that wait for room
  std::vector<std::vector<std::uint8_t>> abandoned_;  ///< data the realtime thread may still have
  DroppedReplies dropped_;
  SteadyTime next_sign_;
  std::uint64_t looks_told_ = 0;  ///< of who is connected, when that was told last
  bool cancels_waiting_ = false;
  bool lanes_blocked_ = false;  ///< a request has its turn, but there is no room on the way
  bool stopping_ = false;
};

}  // namespace cansyncd
