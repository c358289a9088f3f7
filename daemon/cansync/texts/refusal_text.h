#pragma once

#include <string>

#include "cansync/channel/jobs.h"
#include "cansync/config/config.h"
#include "cansync/settings/mode.h"
#include "cansync/telegram/numbers.h"
#include "daemon/cansync/exchange.h"
#include "dds/denial.h"

/// What people read when the master does not take a request. Not for the realtime thread (allocates).
namespace cansyncd {

/// "slave 3 'feeder'", or "slave 3" when it has no name.
std::string slave_label(const Config& config, unsigned slave);

/// The slaves of a mask with their names, e.g. "slave 1 'unwinder', slave 4"; "none" when it is empty. At
/// most eight are spelled out.
std::string slave_list(const Config& config, cansync::SlaveMask slaves);

/// State of the line that a refusal is explained with.
struct RefusalContext {
  cansync::State state = cansync::State::start_up;
  cansync::IntervalNumber interval = 0;
  cansync::SlaveMask responding;
  cansync::SlaveMask released;
  std::uint64_t mapping_number = 1;
  cansync::ProcessMapping reference_mapping = {};
  cansync::BusAccess access = cansync::BusAccess::granted;
  bool waits_for_upper_sync = false;
};

/// Why `request` was refused by the master: field, its value, what is allowed, and the remedy.
std::string refusal_text(cansync::Refusal refusal, const Request& request, const Config& config,
                         const RefusalContext& context);

/// The same with the cause for programs.
gateway::dds::Denial denial_of(cansync::Refusal refusal, const Request& request, const Config& config,
                               const RefusalContext& context);

/// Of reference values that were given for mapping `given`, while `in_force` is.
gateway::dds::Denial mapping_denial(std::uint64_t given, std::uint64_t in_force);

/// Of reference values for a telegram that the lead axis of a cluster gives.
gateway::dds::Denial lead_axis_denial();

/// Why an accepted job ended so, where the slave's name belongs into the reason; empty for other outcomes.
std::string outcome_text(cansync::Outcome outcome, const Request& request, const Config& config);

}  // namespace cansyncd
