#pragma once

#include <cstdint>
#include <string>
#include <string_view>

/// Lines on standard error. What the daemon has to say goes through the journal (journal.h), which writes
/// lines only where there is no journal. Never on the realtime thread.
namespace cansyncd {

/// Priority of a line, as syslog numbers it.
enum class LogPriority : std::uint8_t { error = 3, warning = 4, notice = 5, info = 6 };

/// `text` as one line: control characters (in names that clients have) are written as "\x1b". For the journal
/// every line begins with the priority in angle brackets, which systemd understands; elsewhere errors and
/// warnings begin with that word.
std::string line_of(LogPriority priority, std::string_view text, bool journal);

/// Writes one line to standard error. Any thread; lines of several threads never mix.
void log_line(LogPriority priority, std::string_view text);

}  // namespace cansyncd
