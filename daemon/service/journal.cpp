// A field of its own would name our source line, which says nothing to who reads the journal.
#define SD_JOURNAL_SUPPRESS_LOCATION
#include "daemon/service/journal.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <systemd/sd-journal.h>
#include <unistd.h>

#include <cstdlib>

#include "text/visible.h"

namespace cansyncd {

// systemd names device and inode of the journal's stream; a standard error that was turned elsewhere
// differs.
bool writes_to_journal() {
  // Before any other thread could change the environment.
  const char* stream = std::getenv("JOURNAL_STREAM");  // NOLINT(concurrency-mt-unsafe): nobody writes it
  struct stat status = {};
  if (stream == nullptr || ::fstat(STDERR_FILENO, &status) != 0) return false;
  return fmt::format("{}:{}", status.st_dev, status.st_ino) == stream;
}

void Journal::write(LogPriority priority, EventCode event, const std::string& message,
                    const std::vector<JournalField>& fields) {
  if (send_ == nullptr) return log_line(priority, message);
  constexpr std::size_t kOwn = 5;
  std::vector<std::string> texts;
  texts.reserve(fields.size() + kOwn);
  texts.push_back("MESSAGE=" + text::visible(message));
  texts.push_back(fmt::format("PRIORITY={}", static_cast<unsigned>(priority)));
  texts.emplace_back("SYSLOG_IDENTIFIER=cansyncd");
  texts.push_back(fmt::format("MESSAGE_ID={}", event.message_id()));
  texts.push_back(fmt::format("EVENT={}", event.word()));
  for (const JournalField& field : fields) {
    if (!field.value.empty()) texts.push_back(fmt::format("{}={}", field.name, text::visible(field.value)));
  }
  std::vector<iovec> parts;
  parts.reserve(texts.size());
  for (std::string& text : texts) parts.push_back({text.data(), text.size()});
  if (send_(parts.data(), static_cast<int>(parts.size())) < 0) log_line(priority, message);
}

JournalSink& process_journal() {
  static Journal journal(writes_to_journal() ? ::sd_journal_sendv : nullptr);
  return journal;
}

}  // namespace cansyncd
