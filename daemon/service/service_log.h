#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/problem.h"
#include "daemon/service/journal.h"

namespace cansyncd {

/// What the process itself has to say, outside the gateway: start, configuration, reload, stop. Not for the
/// realtime thread. Any other thread.
class ServiceLog {
 public:
  /// `bus`: field BUS of every entry; empty: not known yet. `journal` must outlive the object.
  explicit ServiceLog(std::string bus, JournalSink& journal = process_journal())
      : bus_(std::move(bus)), journal_(journal) {}

  /// Writes one entry.
  void say(LogPriority priority, EventCode event, const std::string& text,
           std::vector<JournalField> further = {}) const;

  /// Writes one entry configuration_wrong for each problem, with its place and option in fields; of more than
  /// `kProblemsShown` the others are counted in one.
  void problems(const std::vector<config::Problem>& problems) const;

  /// Writes why the daemon cannot run: one entry daemon_cannot_run for each line of `why`, at least one.
  void cannot_run(std::string_view why) const;

 private:
  std::string bus_;
  JournalSink& journal_;
};

/// What is wrong with the configuration at the start: entries where there is a journal, else plain lines on
/// standard error, as compilers write them.
void tell_wrong_configuration(const std::string& bus, const std::vector<config::Problem>& problems);

}  // namespace cansyncd
