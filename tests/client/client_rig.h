#pragma once

#include <cansync/client.h>

#include <chrono>
#include <condition_variable>
#include <mutex>

#include "dds/participant.h"
#include "support/long_wait.h"

/// What the tests of the client share.
namespace cansync::client {

/// Of a client that looks for the daemon at `place`.
inline Options options_for(const gateway::dds::ParticipantOptions& place,
                           std::chrono::milliseconds wait = gateway::kLongWait) {
  return {.domain = place.domain,
          .bus = place.partition,
          .interface = place.interface,
          .client_name = "client_test",
          .xml = place.xml,
          .wait = wait};
}

/// A value that callbacks change and tests wait for.
template <class T>
class Watched {
 public:
  template <class Change>
  void change(Change&& apply) {
    {
      const std::lock_guard lock(mutex_);
      apply(value_);
    }
    changed_.notify_all();
  }
  template <class Condition>
  bool wait(Condition&& condition) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, gateway::kLongWait, [&] { return condition(value_); });
  }
  T get() {
    const std::lock_guard lock(mutex_);
    return value_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  T value_ = {};
};

}  // namespace cansync::client
