#include "daemon/service/log.h"

#include <fmt/format.h>
#include <unistd.h>

namespace cansyncd {

std::string line_of(LogPriority priority, std::string_view text, bool terminal) {
  std::string line;
  if (!terminal) {
    line = fmt::format("<{}>", static_cast<unsigned>(priority));
  } else if (priority == LogPriority::error) {
    line = "error: ";
  } else if (priority == LogPriority::warning) {
    line = "warning: ";
  }
  line.reserve(line.size() + text.size() + 1);
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    line.push_back(byte < 0x20 || byte == 0x7F ? '?' : c);
  }
  line.push_back('\n');
  return line;
}

void log_line(LogPriority priority, std::string_view text) {
  static const bool terminal = ::isatty(STDERR_FILENO) == 1;
  const std::string line = line_of(priority, text, terminal);
  // One write keeps lines of several threads apart. There is nowhere to report that it failed.
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, line.data(), line.size());
}

}  // namespace cansyncd
