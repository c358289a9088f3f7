#pragma once

#include <sys/uio.h>

#include <string>
#include <string_view>
#include <vector>

namespace cansyncd {

/// One field of a journal entry, e.g. CANSYNC_SLAVE.
struct JournalField {
  std::string_view name;  ///< capital letters, digits and underscores
  std::string value;
};

/// Entries with fields. Gateway thread only.
class JournalSink {
 public:
  JournalSink() = default;
  JournalSink(const JournalSink&) = delete;
  JournalSink& operator=(const JournalSink&) = delete;
  virtual ~JournalSink() = default;
  /// Writes one entry of priority notice with `message` and `fields`. There is nowhere to tell that it
  /// failed.
  virtual void write(const std::string& message, const std::vector<JournalField>& fields) = 0;
};

/// The journal of systemd when this process writes to it, so that fields stay fields (`journalctl
/// CANSYNC_ACTION=parameter_write`); elsewhere one readable line on standard error.
class Journal : public JournalSink {
 public:
  using Send = int (*)(const iovec*, int);
  /// `send`: sd_journal_sendv, or a stand-in; null: lines on standard error.
  explicit Journal(Send send) : send_(send) {}
  void write(const std::string& message, const std::vector<JournalField>& fields) override;

 private:
  Send send_;
};

/// The journal of this process.
JournalSink& process_journal();

}  // namespace cansyncd
