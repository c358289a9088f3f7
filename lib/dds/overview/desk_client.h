#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "dds/daemon_sight.h"
#include "dds/endpoint.h"
#include "dds/overview/open_requests.h"
#include "dds/overview/overview_topics.h"
#include "dds/participant.h"
#include "dds/process_facts.h"
#include "dds/signal.h"

namespace gateway::dds {

/// What is open at the daemon of a bus, and ending it, whatever its protocol. One thread.
class DeskClient {
 public:
  /// How a request to end another one ended.
  struct Ended {
    bool replied = false;  ///< false: the daemon went away, or did not answer; `code` says nothing then
    gateway_ReplyCode code = gateway_REPLY_DONE;
    gateway_RefusalCause cause = gateway_CAUSE_NONE;
    std::string reason;
    std::string what;  ///< done: what ends, and whose it is
  };

  /// A file of the daemon.
  struct ProfileFile {
    std::uint32_t size = 0;  ///< bytes of the file
    std::string text;        ///< the file; empty: it is too long to be passed on, over 64 KiB
  };

  /// Waits for the daemon. Throws NoDaemon when `options.wait` is over, `stop` is set or several daemons
  /// serve the bus, SetupError when DDS cannot be set up.
  explicit DeskClient(const ClientOptions& options);

  /// The newest that the daemon told, waiting at most `time` for the first; nothing: it tells none.
  std::optional<OpenRequestsNow> open(std::chrono::milliseconds time);

  /// Waits until the daemon has told that this job is no longer open, at most `time`. False: it still is.
  bool wait_end(std::uint64_t job, std::chrono::milliseconds time);

  /// What this request waits for, in words as `waited_for`; empty: its turn has come, or that is not known,
  /// as with the first call, which only asks. `request`: its number, of any client in this process.
  std::string waits_behind(std::uint64_t request);

  /// The file of a drive profile that the daemon uses, by its SHA-256 in hexadecimal digits. Waits at most
  /// `time`; nothing: the daemon passes none on.
  std::optional<ProfileFile> profile(std::string_view hash, std::chrono::milliseconds time);

  /// Has the daemon end the job with this number, whoever's it is; waits at most 5 s for the reply.
  Ended end(std::uint64_t job);

  /// As the daemon told it last.
  const gateway_GatewayStatus& gateway_status() const noexcept { return *sight_.newest(); }

 private:
  /// The topics that only who ends something needs.
  struct Ends {
    Ends(const Participant& participant, DataSignal& signal, const std::string& bus,
         const std::array<std::uint8_t, 16>& identity);
    Reader<gateway_JobEndReply> replies;
    Writer<gateway_JobEnd> requests;
  };

  /// Waits at most `time` until `condition()` holds, looking again whenever something comes.
  template <class Condition>
  bool wait(std::chrono::milliseconds time, Condition&& condition);
  std::optional<Ended> take_reply(Ends& ends) const;

  ClientOptions options_;
  std::array<std::uint8_t, 16> identity_;
  Participant participant_;
  DataSignal signal_;
  DaemonSight sight_;
  OpenRequestsReader open_;
  ProcessFacts own_;  ///< as others see this process
};

}  // namespace gateway::dds
