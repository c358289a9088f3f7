#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cansync.h"
#include "daemon/config.h"
#include "daemon/exchange.h"
#include "daemon/gateway_events.h"
#include "daemon/gateway_replies.h"
#include "daemon/refusal_text.h"
#include "dds/convert.h"
#include "dds/endpoint.h"
#include "dds/signal.h"
#include "dds/validate.h"

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
/// A request is refused at once, and its reply says why, when a field is out of range, when its number is
/// open already (nothing is executed twice; the open request is answered by itself), when its client has
/// `kPerClient` requests open, when the transfers in work need too much memory, or when there is no room on
/// the way to the realtime thread.
class JobDesk {
 public:
  /// Most open requests of one client: no client can take the queues from the others.
  static constexpr unsigned kPerClient = 64;
  /// Most bytes of all open transfers together.
  static constexpr std::size_t kTransferMemory = 64u << 20;
  /// Least time between two samples of TransferProgress of one transfer.
  static constexpr std::chrono::milliseconds kProgressPeriod{50};
  /// A cancel may overtake its request on the way; it is remembered so long.
  static constexpr std::chrono::seconds kEarlyCancel{10};

  /// Throws cansync::dds::SetupError. `signal` and `events` must outlive this object.
  JobDesk(const cansync::dds::Participant& participant, cansync::dds::DataSignal& signal,
          EventPublisher& events, const Config& config);

  /// Takes new requests and cancels.
  void take_requests(const JobContext& context);

  /// A job ended, or was refused by the master.
  void finish(const Terminal& terminal, const JobContext& context);

  /// A transfer came further.
  void progress(const TransferProgress& report, SteadyTime now);

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

  /// Waits at most `time` on each reply topic until the clients have what was written.
  void wait_for_readers(dds_duration_t time) const noexcept;

 private:
  using Key = std::pair<std::array<std::uint8_t, 16>, std::uint64_t>;
  enum class Kind : std::uint8_t { parameter, transfer, command, internal };

  struct Job {
    Kind kind = Kind::internal;
    cansync::dds::RequestKey key;
    Place place;
    std::string who;
    Request request;
    std::vector<std::uint8_t> data;
    bool cancel_wanted = false;
    SteadyTime next_progress;
  };
  using Jobs = std::map<cansync::JobId, Job>;

  /// Takes a sample of a request topic.
  template <class Sample>
  void accept(cansync::dds::Reader<Sample>& reader, const JobContext& context);
  template <class Sample>
  void accept(const Sample& sample, const Place& place, const JobContext& context);
  /// Completes `job` from a sample that passed its checks; false: it is no request.
  static bool fill(const cansync_ParameterRequest& sample, cansync::JobId id, Job& job);
  static bool fill(const cansync_TransferRequest& sample, cansync::JobId id, Job& job);
  static bool fill(const cansync_Command& sample, cansync::JobId id, Job& job);
  std::optional<std::string> no_room(const Job& job, std::size_t bytes, const JobContext& context) const;
  void refuse(const Job& job, const std::string& reason, const JobContext& context);
  /// Replies to a job that ended without a result of its own: cancelled before it began, or master stopped.
  void end(Job& job, cansync::Outcome outcome, const JobContext& context);
  void take_cancels(const JobContext& context);
  bool take_early_cancel(const Key& key, SteadyTime now);
  void erase(Jobs::iterator job);
  void log_end(const Job& job, std::string_view outcome, const Config& config) const;
  void tell_dropped(SteadyTime now);

  void reply(Job& job, const ParameterDone& done, const JobContext& context);
  void reply(Job& job, const TransferDone& done, const JobContext& context);
  void reply(Job& job, const CommandDone& done, const JobContext& context);
  void reply(Job& job, const Refused& refused, const JobContext& context);

  cansync::dds::Reader<cansync_ParameterRequest> parameters_;
  cansync::dds::Reader<cansync_TransferRequest> transfers_;
  cansync::dds::Reader<cansync_Command> commands_;
  cansync::dds::Reader<cansync_JobCancel> cancels_;
  ReplyOutbox<cansync_ParameterReply> parameter_replies_;
  ReplyOutbox<cansync_TransferReply> transfer_replies_;
  ReplyOutbox<cansync_CommandReply> command_replies_;
  cansync::dds::Writer<cansync_TransferProgress> progress_;
  EventPublisher& events_;
  cansync::dds::Limits limits_;
  PlaceFinder places_;

  Jobs jobs_;
  std::map<Key, cansync::JobId> open_;  ///< requests of clients that are not answered
  std::map<std::array<std::uint8_t, 16>, unsigned> per_client_;  ///< open requests of each client
  std::deque<std::pair<Key, SteadyTime>> early_cancels_;
  std::deque<Request> own_;                           ///< requests of the daemon itself that wait for room
  std::vector<std::vector<std::uint8_t>> abandoned_;  ///< data the realtime thread may still have
  std::size_t transfer_bytes_ = 0;
  cansync::JobId next_id_ = 1;
  bool cancels_waiting_ = false;
  bool stopping_ = false;
};

}  // namespace cansyncd
