#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>

#include "dds/daemon_identity.h"
#include "dds/gateway_topics.h"

/// Internal to lib/client.
namespace cansync::client::detail {

/// The requests of a connection that never waits: each ends once, also when its daemon goes. `Client` is that
/// of a protocol. One thread.
template <class Client, class Result>
class OpenRequests {
 public:
  using Ended = std::function<void(const Result&)>;

  /// `client` must outlive the object.
  explicit OpenRequests(Client& client)
      : client_(&client), daemon_(gateway::dds::daemon_of(client.gateway_status())) {}

  /// No more fits.
  bool full() const noexcept { return open_.size() >= gateway::dds::kOpenRequests; }
  std::size_t size() const noexcept { return open_.size(); }

  /// Takes what `begin(client)` began; false: it was not written, and `problem` says why.
  template <class Begin>
  bool begin(Begin&& begin, Ended ended) {
    auto begun = std::forward<Begin>(begin)(*client_);
    if (begun.not_begun) {
      problem_ = begun.not_begun->reason;
      return false;
    }
    open_.emplace(begun.request, std::move(ended));
    return true;
  }
  /// Why the last one was not written.
  const std::string& problem() const noexcept { return problem_; }

  /// A result came.
  void ended(std::uint64_t request, const Result& result) {
    const auto found = open_.find(request);
    if (found == open_.end()) return;
    const Ended tell = std::move(found->second);
    open_.erase(found);
    tell(result);
  }

  /// Ends what its daemon will not answer any more. True: another start of a daemon is there than before.
  bool watch_daemon() {
    const auto newest = gateway::dds::daemon_of(client_->gateway_status());
    const bool another = newest != daemon_;
    if (!another && (open_.empty() || client_->daemon_present())) return false;
    if (!client_->may_answer(daemon_)) end_all();
    daemon_ = newest;
    return another;
  }

 private:
  void end_all() {
    for (auto& [request, tell] : std::exchange(open_, {})) {
      Result gone;
      gone.reason = "the daemon has gone";
      tell(gone);
    }
  }

  Client* client_;
  gateway::dds::DaemonIdentity daemon_;
  std::map<std::uint64_t, Ended> open_;
  std::string problem_;
};

}  // namespace cansync::client::detail
