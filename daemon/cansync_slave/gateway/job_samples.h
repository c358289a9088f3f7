#pragma once

#include <array>
#include <cstdint>

#include "cansync_slave.h"
#include "daemon/cansync_slave/exchange.h"
#include "daemon/service/daemon_identity.h"
#include "dds/guard/writer_guid.h"

/// The samples that tell of jobs and blocks. Gateway thread only.
namespace cansyncd {

/// Which application each of the newest jobs was given to: what becomes of a job is news for that one.
class JobApplications {
 public:
  /// Job `id` is given to the writer `application`.
  void given(std::uint64_t id, const gateway::dds::WriterGuid& application) noexcept;
  /// Whom it was given to; all zero: it is not known any more.
  gateway::dds::WriterGuid of(std::uint64_t id) const noexcept;

 private:
  /// One is open, and the answer of another may be on its way to the bus.
  static constexpr std::size_t kRemembered = 8;

  struct Given {
    std::uint64_t id = 0;
    gateway::dds::WriterGuid application = {};
  };
  std::array<Given, kRemembered> given_ = {};
  std::size_t next_ = 0;
};

cansync_slave_ParameterJob parameter_job(const JobReport& report, const DaemonIdentity& daemon,
                                         const gateway::dds::WriterGuid& application) noexcept;

/// Its data are those of `report`, which must outlive the sample.
cansync_slave_BlockJob block_job(BlockReport& report, const DaemonIdentity& daemon,
                                 const gateway::dds::WriterGuid& application) noexcept;

}  // namespace cansyncd
