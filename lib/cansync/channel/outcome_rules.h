#pragma once

#include "can/job_ending.h"
#include "cansync/channel/jobs.h"

namespace cansync {

using can::JobEnd;
using can::JobKnown;

/// The outcome of a job without a final answer (can/job_ending.h). Pure; realtime safe.
Outcome outcome_of(JobKnown known, JobEnd end) noexcept;

/// True when the slave has taken the value of a write that ended so, or it is not known whether it has. Pure;
/// realtime safe.
bool perhaps_written(const ParameterResult& result) noexcept;

}  // namespace cansync
