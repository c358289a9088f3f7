#include "daemon/service/log.h"

#include <fmt/format.h>
#include <unistd.h>

#include "daemon/service/journal.h"
#include "text/visible.h"

namespace cansyncd {

std::string line_of(LogPriority priority, std::string_view text, bool journal) {
  std::string line;
  if (journal) {
    line = fmt::format("<{}>", static_cast<unsigned>(priority));
  } else if (priority == LogPriority::error) {
    line = "error: ";
  } else if (priority == LogPriority::warning) {
    line = "warning: ";
  }
  line += text::visible(text) + '\n';
  return line;
}

void log_line(LogPriority priority, std::string_view text) {
  static const bool journal = writes_to_journal();
  const std::string line = line_of(priority, text, journal);
  // One write keeps lines of several threads apart. There is nowhere to report that it failed.
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, line.data(), line.size());
}

}  // namespace cansyncd
