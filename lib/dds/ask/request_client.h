#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "dds/ask/daemon_sight.h"
#include "dds/bounded_text.h"
#include "dds/daemon_identity.h"
#include "dds/endpoint.h"
#include "dds/gateway_topics.h"
#include "dds/newest.h"
#include "dds/participant.h"
#include "dds/signal.h"
#include "gateway.h"

/// What the clients of all protocols but the master's do alike: find the daemon, send it requests, and wait
/// for replies.
namespace gateway::dds {

/// How a request ended, whatever it was for.
struct Ended {
  bool replied = false;  ///< false: the daemon went away, or did not answer; `code` says nothing then
  gateway_ReplyCode code = gateway_REPLY_DONE;
  gateway_RefusalCause cause = gateway_CAUSE_NONE;  ///< of REPLY_REFUSED
  std::string reason;                               ///< empty when done
  bool passes = false;  ///< of a refusal: its cause ends soon, and nobody has to do anything
};

/// A refusal that the program gives itself: nothing was written.
Ended refused(gateway_RefusalCause cause, std::string reason);

/// A request that was begun; how it ends comes later.
struct Begun {
  std::uint64_t request = 0;       ///< its number; 0: it was not written
  std::optional<Ended> not_begun;  ///< why it was not written
};

/// A connection to the daemon of one bus, of which a protocol's client is made: the client adds its topics. One
/// thread.
class RequestClient {
 public:
  RequestClient(const RequestClient&) = delete;
  RequestClient& operator=(const RequestClient&) = delete;

  /// A daemon serves the bus now.
  bool daemon_present() const noexcept { return presence_ != nullptr && presence_->matched() != 0; }
  /// May the result of a request to this start of the daemon still come? A caller that receives false is
  /// regarded as informed that the daemon has gone.
  bool may_answer(const DaemonIdentity& daemon);
  /// Which daemon serves the bus, as it published last; once a second, taken by every function that looks.
  const gateway_GatewayStatus& gateway_status() const noexcept { return *sight_.newest(); }
  /// The newest state of the controller and its interface; nothing: a daemon that is there has published none yet.
  /// Never waits.
  const std::optional<gateway_BusStatus>& bus_status();

  /// For writers of topics of their own.
  const Participant& participant() const noexcept { return participant_; }
  /// The program's name for the daemon's journal.
  const std::string& name() const noexcept { return options_.client_name; }
  /// Where the daemon was looked for, for messages.
  std::string place() const { return participant_.place(); }

 protected:
  /// Throws SetupError.
  explicit RequestClient(const ClientOptions& options);
  ~RequestClient() = default;

  /// Where the replies to this program come, and no others.
  Partitions reply_partitions() const;

  /// Waits for the daemon as DaemonSight::find does; throws as that. `presence`: matched as long as a daemon
  /// serves the bus (`daemon_present`, `wait_until`); it must live as long as the object, or be null when neither
  /// is used.
  template <class Matched, class OtherTopics>
  void connect(std::string_view protocol, const ReaderBase* presence, DaemonSight::Ways ways,
               Matched&& matched, OtherTopics&& other_topics) {
    presence_ = presence;
    sight_.find(options_, signal_, protocol, std::move(ways), std::forward<Matched>(matched),
                std::forward<OtherTopics>(other_topics));
  }

  /// Why no request may be sent now; nothing: one may.
  std::optional<Ended> obstacle();

  /// Writes the request with who asks, its number, and the daemon that it is for. `role`: who may, with DDS
  /// Security on. Waits at most 1 s when the daemon takes no samples.
  template <class Request>
  Begun begin(Writer<Request>& writer, Request& request, std::string_view role) {
    if (auto problem = obstacle()) return {0, std::move(problem)};
    std::copy(identity_.begin(), identity_.end(), std::begin(request.client));
    request.request = ++number_;
    copy_text(options_.client_name, request.client_name);
    set_daemon(sight_.choice().daemon(), request);
    if (auto problem = not_written(writer.write(request), topic_info<Request>.name, role))
      return {0, std::move(problem)};
    return {request.request, std::nullopt};
  }

  /// Waits for the one reply to what was begun: `take_replies` is given a function to call with the number and
  /// the result of each reply that has come. When `stop` of the options is set, or `longest` is over, the
  /// request is cancelled, and the reply says whether that was in time; without one 5 s later waiting ends, and
  /// what was asked may have been done.
  template <class Result, class TakeReplies>
  Result await(const Begun& begun, std::chrono::milliseconds longest, Writer<gateway_JobCancel>& cancels,
               TakeReplies&& take_replies) {
    Result result;
    const std::function<bool()> came = [&] {
      bool found = false;
      take_replies([&](std::uint64_t number, const Result& one) {
        if (number != begun.request) return;
        result = one;
        found = true;
      });
      return found;
    };
    if (auto otherwise =
            begun.not_begun ? begun.not_begun : without_reply(begun.request, longest, cancels, came))
      static_cast<Ended&>(result) = *std::move(otherwise);
    return result;
  }
  /// From the end of a request's monitoring time to its reply, and from a cancel to it.
  static constexpr std::chrono::milliseconds kGrace{5000};
  /// For the monitoring time of a daemon that has not published its own.
  static constexpr std::chrono::milliseconds kDefaultMonitoring{1000};

  /// This program asked.
  template <class Reply>
  bool is_mine(const Reply& reply) const {
    return std::equal(identity_.begin(), identity_.end(), std::begin(reply.client));
  }
  /// Hands a reply on to `ended` with what every reply says, when this program asked.
  template <class Reply, class Result, class Function>
  void hand_on(const Reply& reply, Result result, Function&& ended) const {
    if (!is_mine(reply)) return;
    result.replied = true;
    result.code = reply.code;
    result.cause = reply.cause;
    result.reason = text(reply.reason);
    ended(reply.request, result);
  }

  /// Calls `came()` whenever something may have come, until it is true, `time` is over, or `stop` is set. False:
  /// the daemon has gone, and nothing came. `came` takes from all readers: a full one holds up all topics.
  template <class Came>
  bool wait_until(std::chrono::milliseconds time, Came&& came) {
    const auto end = std::chrono::steady_clock::now() + time;
    while (true) {
      signal_.clear();
      if (came()) return true;
      if (!daemon_present()) return false;
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
      if (left <= std::chrono::milliseconds{0} || options_.stopped()) return true;
      (void)signal_.wait(std::min(static_cast<int>(left.count()), DaemonSight::kLookMs));
    }
  }

  /// The options end what is waited for.
  bool stopped() const { return options_.stopped(); }
  DataSignal& signal() noexcept { return signal_; }
  DaemonSight& sight() noexcept { return sight_; }
  const DaemonSight& sight() const noexcept { return sight_; }
  /// As DaemonSight::look_until_reached.
  void look_until_reached() { sight_.look_until_reached(options_, signal_); }

 private:
  static std::optional<Ended> not_written(dds_return_t code, std::string_view topic, std::string_view role);
  /// Nothing: `came()` was true. Else why there was no reply.
  std::optional<Ended> without_reply(std::uint64_t request, std::chrono::milliseconds longest,
                                     Writer<gateway_JobCancel>& cancels, const std::function<bool()>& came);
  void cancel(std::uint64_t request, const DaemonIdentity& daemon, Writer<gateway_JobCancel>& cancels);

  ClientOptions options_;
  std::array<std::uint8_t, 16> identity_;
  Participant participant_;
  DataSignal signal_;
  Reader<gateway_BusStatus> bus_reader_;
  Newest<gateway_BusStatus> bus_;
  DaemonSight sight_;
  const ReaderBase* presence_ = nullptr;
  std::uint64_t number_ = 0;  ///< of the last request
};

}  // namespace gateway::dds
