#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cansync.h"
#include "cansync/dds/convert.h"
#include "cansync/dds/topics.h"
#include "cansync/dds/validate.h"
#include "daemon/cansync/config/config.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/texts/refusal_text.h"
#include "daemon/desk/access.h"
#include "daemon/desk/audit.h"
#include "daemon/desk/client_table.h"
#include "daemon/desk/dropped_replies.h"
#include "daemon/desk/fair_lanes.h"
#include "daemon/desk/gateway_events.h"
#include "daemon/desk/gateway_replies.h"
#include "daemon/desk/rejections.h"
#include "dds/endpoint.h"
#include "dds/key_guard.h"
#include "dds/signal.h"

namespace cansyncd {

/// What the jobs need to know of the rest of the gateway.
struct JobContext {
  Exchange& exchange;
  const Config& config;
  RefusalContext line;  ///< newest state of the line
  SteadyTime now;
};

/// Takes the requests of clients, hands them to the realtime thread, and answers each exactly once. Gateway
/// thread only.
///
/// A request is refused at once, and its reply says why, when a field is out of range, when its number was
/// used before (nothing is executed twice; an open request is answered by itself), when it is stale, when its
/// client has `kPerClient` requests open, or when open transfers need too much memory. Otherwise it waits its
/// turn
/// (`FairLanes`). The requests of a client that is gone are cancelled.
///
/// No reply is given to who uses another program's identity: that program would take it for its own.
class JobDesk {
 public:
  /// Most open requests of one client: no client can take the queues from the others.
  static constexpr unsigned kPerClient = gateway::dds::kOpenRequests;
  /// Most bytes of all open transfers together, and of those of one client.
  static constexpr std::size_t kTransferMemory = 128u << 20;
  static constexpr std::size_t kClientTransferMemory = 32u << 20;
  /// Most cancels of one client that are remembered until their request comes.
  static constexpr std::size_t kEarlyCancels = 64;
  /// Least time between two samples of TransferProgress of one transfer.
  static constexpr std::chrono::milliseconds kProgressPeriod{50};
  /// Longest time between two, also while it waits: its client sees that it is not lost.
  static constexpr std::chrono::seconds kSignPeriod{1};
  /// Parameter requests, and requests that are refused unread, in one pass.
  static constexpr std::size_t kParametersAtOnce = 16;
  static constexpr std::size_t kRefusedAtOnce = 16;
  /// A cancel may overtake its request on the way; it is remembered so long.
  static constexpr std::chrono::seconds kEarlyCancel{10};

  /// Throws gateway::dds::SetupError. `signal`, `events` and `audit` must outlive this object.
  JobDesk(const gateway::dds::Participant& participant, gateway::dds::DataSignal& signal,
          EventPublisher& events, const Config& config, AuditTrail& audit);

  /// Takes new requests and cancels, a bounded number, and looks which clients are gone. True: there may be
  /// more.
  bool take_requests(const JobContext& context);

  /// A job ended, or was refused by the master.
  void finish(const Terminal& terminal, const JobContext& context);

  /// A transfer came further.
  void progress(const TransferProgress& report, SteadyTime now);

  /// Ends what waits here and has lost its turn to newer control words: those to `words` as replaced by them,
  /// and what would enable one of `stopped` after its stop.
  void replace_waiting(cansync::SlaveMask words, cansync::SlaveMask stopped, const JobContext& context);

  /// Gives a request of the daemon itself; a refusal becomes an event.
  void give(Request request);

  /// Writes what could not be written or handed on before. Returns when to call again; nothing: no need.
  std::optional<SteadyTime> retry(const JobContext& context);

  /// Answers every open request, and those that still come in this call, with REPLY_MASTER_STOPPED.
  /// Transfers' data stays until this object is destroyed, because the realtime thread may still have it.
  void stop(const JobContext& context);

  /// True while replies wait to be written (`retry` writes them).
  bool replies_waiting() const noexcept {
    return !parameter_replies_.empty() || !transfer_replies_.empty() || !command_replies_.empty();
  }

  /// Clients that live or have open requests.
  std::size_t clients() const noexcept { return clients_.size(); }
  const RejectionCounts& rejections() const noexcept { return rejections_.counts(); }

  /// Waits at most `time` on each reply topic until the clients have what was written.
  void wait_for_readers(dds_duration_t time) const noexcept;

 private:
  using Key = std::pair<ClientIdentity, std::uint64_t>;
  enum class Kind : std::uint8_t { parameter, transfer, command, internal };

  struct Job {
    Kind kind = Kind::internal;
    gateway::dds::RequestKey key;
    Place place;
    Requester who;
    std::optional<Change> change;  ///< nothing: it only reads
    cansync::State state_before = cansync::State::start_up;
    Request request;
    bool understood = false;  ///< `request` is what was asked for
    std::vector<std::uint8_t> data;
    bool cancel_wanted = false;
    std::uint32_t done = 0;  ///< bytes of a transfer
    SteadyTime next_progress;
  };
  using Jobs = std::map<cansync::JobId, Job>;

  struct TakenParameter {
    cansync_ParameterRequest sample;
    Place place;
    std::int64_t written = 0;
  };
  enum ReaderIndex : std::uint8_t { kParameters, kTransfers, kCommands, kCancels, kEngineer, kReaders };
  std::array<dds_entity_t, kReaders> reader_handles() const;

  /// Takes a sample of a request topic.
  template <class Sample>
  bool accept(gateway::dds::Reader<Sample>& reader, ReaderIndex index, Right right,
              const JobContext& context);
  template <class Sample>
  void accept(const Sample& sample, const Place& place, Right right, std::int64_t written,
              const JobContext& context);
  /// A few at a time: a pass over 128 would keep control words waiting.
  bool take_parameters(const JobContext& context);
  /// Answers those for which a client had too many waiting.
  bool refuse_turned_away(const JobContext& context);
  /// The client of a request that may be taken; null: it was answered, or must not be.
  ClientEntry* admit(Job& job, std::int64_t written, const JobContext& context);
  /// Completes `job` from a sample that passed its checks; false: it is no request.
  static bool fill(const cansync_ParameterRequest& sample, cansync::JobId id, Job& job);
  static bool fill(const cansync_TransferRequest& sample, cansync::JobId id, Job& job);
  static bool fill(const cansync_Command& sample, cansync::JobId id, Job& job);
  std::optional<std::string> no_room(const ClientEntry& client, std::size_t bytes) const;
  void refuse(const Job& job, Rejection kind, const std::string& reason, const JobContext& context);
  /// Replies to a job that ended without a result of its own: cancelled before it began, or master stopped.
  void end(Job& job, cansync::Outcome outcome, const JobContext& context);
  bool take_cancels(const JobContext& context);
  void take_cancel(const gateway::dds::RequestKey& key, const Place& place, const JobContext& context);
  static bool take_early_cancel(ClientEntry& client, std::uint64_t request, SteadyTime now);
  void replace_waiting(const Request& newer, const JobContext& context);
  /// Ends a job that waits; one that the master has ends by itself, soon.
  void cancel(Jobs::iterator job, const JobContext& context);
  void look_for_clients(const JobContext& context);
  /// Nothing is kept of a client that is gone and has every answer.
  void forget(const ClientIdentity& identity, SteadyTime now);
  void erase(Jobs::iterator job, SteadyTime now);
  /// `ended` bytes of a job's data are no longer counted.
  void count_data(const Job& job, std::size_t ended);
  void record_end(const Job& job, cansync::Outcome outcome, const JobContext& context);
  void tell_dropped(SteadyTime now);
  /// Publishes the progress of transfers that are open and have had none for long. When to call again.
  std::optional<SteadyTime> show_open_transfers(SteadyTime now);

  void reply(Job& job, const ParameterDone& done, const JobContext& context);
  void reply(Job& job, const TransferDone& done, const JobContext& context);
  void reply(Job& job, const CommandDone& done, const JobContext& context);
  void reply(Job& job, const Refused& refused, const JobContext& context);

  /// Counts what was dropped before it could be taken: keys too many, samples DDS could not read.
  void count_dropped(SteadyTime now);

  std::array<gateway::dds::KeyGuard, kReaders> guards_;
  gateway::dds::Reader<cansync_ParameterRequest> parameters_;
  gateway::dds::Reader<cansync_TransferRequest> transfers_;
  gateway::dds::Reader<cansync_Command> commands_;
  std::optional<gateway::dds::Reader<cansync_Command>> engineer_commands_;  ///< with DDS Security on
  gateway::dds::Reader<gateway_JobCancel> cancels_;
  ReplyOutbox<cansync_ParameterReply> parameter_replies_;
  ReplyOutbox<cansync_TransferReply> transfer_replies_;
  ReplyOutbox<cansync_CommandReply> command_replies_;
  gateway::dds::Writer<cansync_TransferProgress> progress_;
  EventPublisher& events_;
  AuditTrail& audit_;
  cansync::dds::Limits limits_;
  PlaceFinder places_;
  LivingPlaces living_;
  ClientTable clients_;
  Rejections rejections_;

  Jobs jobs_;
  std::deque<TakenParameter> parameters_taken_;  ///< from the reader, not looked at yet; at most a batch
  FairLanes lanes_;
  std::map<Key, cansync::JobId> open_;                ///< requests of clients that are not answered
  std::deque<Request> own_;                           ///< requests of the daemon itself that wait for room
  std::vector<std::vector<std::uint8_t>> abandoned_;  ///< data the realtime thread may still have
  std::size_t transfer_bytes_ = 0;
  DroppedReplies dropped_;
  SteadyTime next_sign_;
  cansync::JobId next_id_ = 1;
  bool cancels_waiting_ = false;
  bool lanes_blocked_ = false;  ///< a request has its turn, but there is no room on the way
  bool stopping_ = false;
};

}  // namespace cansyncd
