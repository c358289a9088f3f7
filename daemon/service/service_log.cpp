#include "daemon/service/service_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <iterator>

namespace cansyncd {
namespace {

/// Lines and columns count from 1; 0: the place is not known.
std::string place(std::uint32_t number) {
  return number == 0 ? std::string() : std::to_string(number);
}

}  // namespace

void ServiceLog::say(LogPriority priority, EventCode event, const std::string& text,
                     std::vector<JournalField> further) const {
  std::vector<JournalField> fields = {{"BUS", bus_}};
  fields.insert(fields.end(), std::make_move_iterator(further.begin()),
                std::make_move_iterator(further.end()));
  journal_.write(priority, event, text, fields);
}

void ServiceLog::problems(const std::vector<config::Problem>& problems) const {
  for (std::size_t i = 0; i < std::min(problems.size(), config::kProblemsShown); ++i) {
    const config::Problem& problem = problems[i];
    say(LogPriority::error, "configuration_wrong", to_string(problem),
        {{"CANSYNC_FILE", problem.where.file},
         {"CANSYNC_LINE", place(problem.where.line)},
         {"CANSYNC_COLUMN", place(problem.where.column)},
         {"CANSYNC_OPTION", problem.key}});
  }
  if (problems.size() > config::kProblemsShown) {
    say(LogPriority::error, "configuration_wrong",
        fmt::format("and {} more problems", problems.size() - config::kProblemsShown));
  }
}

void ServiceLog::cannot_run(std::string_view why) const {
  do {
    const std::string_view line = why.substr(0, why.find('\n'));
    why.remove_prefix(std::min(line.size() + 1, why.size()));
    say(LogPriority::error, "daemon_cannot_run", fmt::format("cannot run: {}", line));
  } while (!why.empty());
}

void tell_wrong_configuration(const std::string& bus, const std::vector<config::Problem>& problems) {
  if (writes_to_journal()) return ServiceLog(bus).problems(problems);
  std::fputs(problems_text(problems).c_str(), stderr);
}

}  // namespace cansyncd
