#pragma once

#include "cansync/channel/jobs.h"

/// Who shares a master has ids of its own: `Master::cancel` names a job by its id alone.
namespace cansync {

/// Control words of the failsafe reaction begin here. Jobs of clients stay below.
inline constexpr JobId kFailsafeJobs = JobId{1} << 62;
/// A cluster's gateway's own jobs on the lower bus begin here; everybody else stays below.
inline constexpr JobId kGatewayJobs = JobId{1} << 63;

static_assert(kFailsafeJobs < kGatewayJobs);

}  // namespace cansync
