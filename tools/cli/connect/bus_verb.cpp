#include "cli/connect/bus_verb.h"

#include "cli/text/values.h"

namespace cansync::cli {

std::uint64_t parse_end_count(const std::string& text) {
  return text.empty() ? 0 : static_cast<std::uint64_t>(parse_integer(text, "--count", 1, INT32_MAX));
}

ExitCode end_without_daemon(Session& session, const std::string& place) {
  session.output().remark("the daemon has gone (" + place + ")");
  return ExitCode::not_reachable;
}

}  // namespace cansync::cli
