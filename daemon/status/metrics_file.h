#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "daemon/desk/event_text.h"

namespace cansyncd {

/// Replaces the metrics file, on a thread of its own, because a disk may take its time. Each text goes into
/// FILE.new, which then takes the name of the file, so that no reader sees half a text.
///
/// A write that fails is counted and tried again with the next text; `tell` gets an event when failures
/// begin, and one when they are over.
class MetricsFile {
 public:
  using Tell = std::function<void(const EventText&)>;

  /// Starts the thread; `tell` is called on it. Throws std::system_error when there is no thread to be had.
  MetricsFile(std::string path, Tell tell);

  /// Ends the thread and removes the file: what nobody renews must not be taken for news.
  ~MetricsFile();
  MetricsFile(const MetricsFile&) = delete;
  MetricsFile& operator=(const MetricsFile&) = delete;

  /// Has `text` written; a text that was not begun yet is dropped for it. Any thread; returns at once.
  void write(std::string text);

  /// Texts that could not be written so far. Any thread.
  std::uint64_t failures() const noexcept { return failures_.load(std::memory_order_relaxed); }

 private:
  void run();
  void replace(const std::string& text);

  const std::string path_;
  const Tell tell_;
  std::atomic<std::uint64_t> failures_{0};
  std::uint64_t in_a_row_ = 0;  ///< the thread's own

  std::mutex mutex_;
  std::condition_variable wake_;
  std::optional<std::string> waiting_;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace cansyncd
