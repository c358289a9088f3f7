#pragma once

#include <cansync/client.h>
#include <cansync/topics.h>

#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>

namespace cansync::cli {

/// Samples of the topic Timing, which comes once a second, on their way from the client's thread to this one.
class SampleQueue {
 public:
  /// `client` must outlive the queue.
  explicit SampleQueue(client::Client& client);

  /// The next sample; nothing when none comes within 3 s or a signal came. Main thread.
  std::optional<client::Timing> next();

 private:
  void put(const client::Timing& timing);
  std::optional<client::Timing> take();

  std::mutex mutex_;
  std::deque<client::Timing> samples_;
  client::Subscription subscription_;  // ends before what its callback needs
};

}  // namespace cansync::cli
