#pragma once

#include "cansync_slave.h"
#include "daemon/cansync_slave/exchange.h"
#include "daemon/service/daemon_identity.h"

/// The samples that tell of jobs and blocks. Pure; any thread.
namespace cansyncd {

cansync_slave_ParameterJob parameter_job(const JobReport& report, const DaemonIdentity& daemon) noexcept;

/// Its data are those of `report`, which must outlive the sample.
cansync_slave_BlockJob block_job(BlockReport& report, const DaemonIdentity& daemon) noexcept;

}  // namespace cansyncd
