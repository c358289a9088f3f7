#pragma once

#include <sys/uio.h>

#include <string>
#include <string_view>
#include <vector>

#include "daemon/service/event_codes.h"
#include "daemon/service/log.h"

namespace cansyncd {

/// One field of a journal entry. BUS, SLAVE, PARAMETER and CLIENT name what an entry concerns; every other
/// field begins with CANSYNC_.
struct JournalField {
  std::string_view name;  ///< capital letters, digits and underscores
  std::string value;      ///< empty: the field is left out
};

/// Entries with fields. Not for the realtime thread.
class JournalSink {
 public:
  JournalSink() = default;
  JournalSink(const JournalSink&) = delete;
  JournalSink& operator=(const JournalSink&) = delete;
  virtual ~JournalSink() = default;
  /// Writes one entry with `message` and `fields`; EVENT and MESSAGE_ID come from `event`. There is nowhere
  /// to tell that it failed. Any thread.
  virtual void write(LogPriority priority, EventCode event, const std::string& message,
                     const std::vector<JournalField>& fields) = 0;
};

/// The journal of systemd when this process writes to it, so that fields stay fields (`journalctl SLAVE=3`);
/// elsewhere one readable line on standard error.
class Journal : public JournalSink {
 public:
  using Send = int (*)(const iovec*, int);
  /// `send`: sd_journal_sendv, or a stand-in; null: lines on standard error.
  explicit Journal(Send send) : send_(send) {}
  void write(LogPriority priority, EventCode event, const std::string& message,
             const std::vector<JournalField>& fields) override;

 private:
  Send send_;
};

/// True when standard error is the stream that systemd has given this process (JOURNAL_STREAM).
bool writes_to_journal();

/// The journal of this process. The first call must come before a second thread is started.
JournalSink& process_journal();

}  // namespace cansyncd
