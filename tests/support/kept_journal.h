#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/service/journal.h"
#include "support/long_wait.h"

namespace cansyncd {

/// Keeps what would go to the journal. Any thread.
class KeptJournal : public JournalSink {
 public:
  struct Entry {
    LogPriority priority = LogPriority::info;
    std::string message;
    std::vector<JournalField> fields;
    /// Empty when there is no such field.
    std::string field(std::string_view name) const {
      for (const JournalField& field : fields) {
        if (field.name == name) return field.value;
      }
      return {};
    }
  };

  void write(LogPriority priority, EventCode event, const std::string& message,
             const std::vector<JournalField>& fields) override {
    const std::lock_guard lock(mutex_);
    entries_.push_back({priority, message, fields});
    entries_.back().fields.push_back({"EVENT", std::string(event.word())});
    written_.notify_all();
  }
  std::vector<Entry> all() const {
    const std::lock_guard lock(mutex_);
    return entries_;
  }
  /// Entries whose field has this value.
  std::vector<Entry> with(std::string_view name, std::string_view value) const {
    std::vector<Entry> out;
    for (Entry& entry : all()) {
      if (entry.field(name) == value) out.push_back(std::move(entry));
    }
    return out;
  }
  /// The same once there are `count` of them, or what there is after 20 s. For an entry that its writer makes
  /// after what the test waited for, such as that of an event, which comes after its sample.
  std::vector<Entry> wait_for(std::string_view name, std::string_view value, std::size_t count = 1) const {
    std::unique_lock lock(mutex_);
    std::vector<Entry> found;
    written_.wait_for(lock, gateway::kLongWait, [&] {
      found.clear();
      for (const Entry& entry : entries_) {
        if (entry.field(name) == value) found.push_back(entry);
      }
      return found.size() >= count;
    });
    return found;
  }
  /// Entries that record what a client wanted to change, one by one.
  std::vector<Entry> changes() const {
    std::vector<Entry> out;
    for (Entry& entry : all()) {
      if (!entry.field("CANSYNC_ACTION").empty()) out.push_back(std::move(entry));
    }
    return out;
  }

 private:
  mutable std::mutex mutex_;
  mutable std::condition_variable written_;
  std::vector<Entry> entries_;
};

}  // namespace cansyncd
