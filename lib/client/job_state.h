#pragma once

#include <algorithm>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/job.h"
#include "client/types.h"
#include "dds/endpoint.h"

/// Internal to lib/client.
namespace cansync::client::detail {

/// The reply writers of the daemons that are matched.
using Daemons = std::vector<dds_instance_handle_t>;

/// One request of a client, shared by its Job and the receiver thread.
template <class R>
struct JobState {
  std::mutex mutex;
  std::condition_variable changed;
  std::optional<R> reply;  // once there, it never changes
  std::vector<std::function<void(const R&)>> callbacks;
  std::uint32_t done = 0;
  std::uint32_t total = 0;
  std::uint64_t progress = 0;  // rises with each progress sample
  std::uint64_t request = 0;   // constant from here on
  std::weak_ptr<Link> link;
  Daemons daemons;  // who could answer when it was sent

  /// Ends the job; a second reply is ignored.
  void finish(R&& terminal) {
    std::vector<std::function<void(const R&)>> waiting;
    {
      const std::lock_guard lock(mutex);
      if (reply) return;
      reply = std::move(terminal);
      waiting.swap(callbacks);
    }
    changed.notify_all();
    for (const auto& callback : waiting) callback(*reply);
  }
  void end(ReplyCode code, const std::string& reason) {
    R terminal;
    terminal.code = code;
    terminal.reason = reason;
    terminal.speaker = code == ReplyCode::no_reply ? Speaker::nobody : Speaker::client;
    finish(std::move(terminal));
  }
};

/// The open jobs of one kind, by request number. Guarded by the link's mutex.
template <class R>
class OpenJobs {
 public:
  using State = std::shared_ptr<JobState<R>>;

  void add(const State& state) { open_.emplace(state->request, state); }

  /// The job of a request; nullptr when it is not (or no longer) open.
  State find(std::uint64_t request) const {
    const auto entry = open_.find(request);
    return entry == open_.end() ? nullptr : entry->second;
  }

  State remove(std::uint64_t request) {
    State state = find(request);
    open_.erase(request);
    return state;
  }

  /// Removes and returns the jobs that none of `alive` can answer any more.
  std::vector<State> remove_lost(const Daemons& alive) {
    std::vector<State> lost;
    for (auto entry = open_.begin(); entry != open_.end();) {
      const Daemons& asked = entry->second->daemons;
      const bool answerable = std::any_of(asked.begin(), asked.end(), [&](dds_instance_handle_t daemon) {
        return std::find(alive.begin(), alive.end(), daemon) != alive.end();
      });
      if (answerable) {
        ++entry;
        continue;
      }
      lost.push_back(entry->second);
      entry = open_.erase(entry);
    }
    return lost;
  }

 private:
  std::map<std::uint64_t, State> open_;
};

}  // namespace cansync::client::detail
