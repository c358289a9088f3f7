#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "dds/ask/request_client.h"
#include "dds/overview/open_requests.h"
#include "dds/overview/overview_topics.h"
#include "dds/process_facts.h"

namespace gateway::dds {

/// What is open at the daemon of a bus, and ending it, whatever its protocol. One thread.
class DeskClient : public RequestClient {
 public:
  /// How a request to end another one ended.
  struct EndedOther : Ended {
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
  EndedOther end(std::uint64_t job);

 private:
  /// Waits at most `time` until `condition()` holds, looking again whenever something comes.
  template <class Condition>
  bool wait(std::chrono::milliseconds time, Condition&& condition);

  OpenRequestsReader open_;
  ProcessFacts own_;  ///< as others see this process
};

}  // namespace gateway::dds
