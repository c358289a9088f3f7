#include "daemon/log.h"

#include <unistd.h>

#include <string>

namespace cansyncd {

void log_line(LogPriority priority, std::string_view text) {
  std::string line = fmt::format("<{}>", static_cast<unsigned>(priority));
  line.reserve(line.size() + text.size() + 1);
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    line.push_back(byte < 0x20 || byte == 0x7F ? '?' : c);
  }
  line.push_back('\n');
  // One write keeps lines of several threads apart. There is nowhere to report that it failed.
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, line.data(), line.size());
}

}  // namespace cansyncd
