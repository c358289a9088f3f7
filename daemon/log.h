#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <string_view>
#include <utility>

/// Lines for the journal: one line each on standard error, begun with the priority in angle brackets that
/// systemd understands. Never on the realtime thread.
namespace cansyncd {

/// Priority of a line, as syslog numbers it.
enum class LogPriority : std::uint8_t { error = 3, warning = 4, notice = 5, info = 6 };

/// Writes one line; control characters in `text` (names given by clients) become '?'. Any thread; lines of
/// several threads never mix.
void log_line(LogPriority priority, std::string_view text);

/// Formats and writes one line, e.g. `log(LogPriority::notice, "slave {} lost", 3)`.
template <class... Arguments>
void log(LogPriority priority, fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  log_line(priority, fmt::format(format, std::forward<Arguments>(arguments)...));
}

}  // namespace cansyncd
