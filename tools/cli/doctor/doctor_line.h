#pragma once

#include "cli/base/finding_list.h"
#include "cli/doctor/doctor_findings.h"

namespace cansync::cli {

/// The line of CANsync: operating state, its slaves, who gives reference values, what was missed. Call only
/// with the status of a master.
void look_at_line(const DoctorInput& in, FindingList& out);

}  // namespace cansync::cli
