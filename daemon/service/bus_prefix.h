#pragma once

#include <string>
#include <vector>

#include "daemon/service/journal.h"

namespace cansyncd {

/// For a process that serves several buses: puts the field BUS before each message, for those who read lines
/// and not fields. Any thread.
class BusPrefix final : public JournalSink {
 public:
  /// `sink` must outlive this object.
  explicit BusPrefix(JournalSink& sink) : sink_(sink) {}

  void write(LogPriority priority, EventCode event, const std::string& message,
             const std::vector<JournalField>& fields) override {
    for (const JournalField& field : fields) {
      if (field.name == "BUS") return sink_.write(priority, event, field.value + ": " + message, fields);
    }
    sink_.write(priority, event, message, fields);
  }

 private:
  JournalSink& sink_;
};

}  // namespace cansyncd
