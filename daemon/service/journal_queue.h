#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "daemon/service/journal.h"

namespace cansyncd {

/// Bounds of a `JournalQueue`.
struct JournalQueueLimits {
  std::size_t entries = 4096;              ///< that wait; further ones are lost; at least 2
  std::chrono::milliseconds at_end{2000};  ///< for what still waits when the queue ends
};

/// Lets nobody wait for the journal or for whoever reads standard error: a thread of its own writes entry
/// after entry. What finds no room is lost and counted; once half of the room is free again, one entry
/// journal_entries_lost tells how many were.
class JournalQueue final : public JournalSink {
 public:
  /// Starts the thread, which takes no signals. `bus`: field BUS of what the queue itself has to tell. `sink`
  /// must outlive the queue, and a write that has not returned by then: that one is left behind. Throws
  /// std::system_error without a thread.
  JournalQueue(JournalSink& sink, std::string bus, JournalQueueLimits limits = {});
  /// Writes what waits, as long as `limits.at_end` allows; the rest is lost.
  ~JournalQueue() override;

  void write(LogPriority priority, EventCode event, const std::string& message,
             const std::vector<JournalField>& fields) override;

 private:
  struct Waiting;
  const std::shared_ptr<Waiting> waiting_;  // the thread's, too: it may be left behind
};

}  // namespace cansyncd
