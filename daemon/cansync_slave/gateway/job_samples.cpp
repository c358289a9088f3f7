#include "daemon/cansync_slave/gateway/job_samples.h"

#include <algorithm>
#include <iterator>

#include "dds/daemon_identity.h"

namespace cansyncd {
namespace {

cansync_slave_JobStep to_idl(JobReport::Step step) noexcept {
  switch (step) {
    case JobReport::Step::asked:
      return cansync_slave_JOB_ASKED;
    case JobReport::Step::answered:
      return cansync_slave_JOB_ANSWERED;
    case JobReport::Step::dropped:
      break;
  }
  return cansync_slave_JOB_DROPPED;
}

cansync_slave_BlockStep to_idl(BlockReport::Step step) noexcept {
  switch (step) {
    case BlockReport::Step::begun:
      return cansync_slave_BLOCK_BEGUN;
    case BlockReport::Step::complete:
      return cansync_slave_BLOCK_COMPLETE;
    case BlockReport::Step::telegram:
      return cansync_slave_BLOCK_TELEGRAM;
    case BlockReport::Step::ended:
      break;
  }
  return cansync_slave_BLOCK_ENDED;
}

cansync_slave_BlockResult to_idl(cansync::BlockEnd end) noexcept {
  switch (end) {
    case cansync::BlockEnd::done:
      return cansync_slave_BLOCK_DONE;
    case cansync::BlockEnd::cancelled:
      return cansync_slave_BLOCK_CANCELLED;
    case cansync::BlockEnd::refused:
      return cansync_slave_BLOCK_REFUSED;
    case cansync::BlockEnd::timed_out:
      return cansync_slave_BLOCK_TIMED_OUT;
    case cansync::BlockEnd::application:
      break;
  }
  return cansync_slave_BLOCK_APPLICATION_GONE;
}

}  // namespace

void JobApplications::given(std::uint64_t id, const gateway::dds::WriterGuid& application) noexcept {
  given_[next_] = {id, application};
  next_ = (next_ + 1) % given_.size();
}

gateway::dds::WriterGuid JobApplications::of(std::uint64_t id) const noexcept {
  const auto found =
      std::find_if(given_.begin(), given_.end(), [id](const Given& one) { return one.id == id; });
  return found == given_.end() ? gateway::dds::WriterGuid{} : found->application;
}

cansync_slave_ParameterJob parameter_job(const JobReport& report, const DaemonIdentity& daemon,
                                         const gateway::dds::WriterGuid& application) noexcept {
  cansync_slave_ParameterJob sample = {};
  std::copy(application.begin(), application.end(), std::begin(sample.application));
  sample.job = report.job.id;
  gateway::dds::set_daemon(daemon, sample);
  sample.time = report.when.wall_clock.count();
  sample.interval = report.when.interval;
  sample.step = to_idl(report.step);
  sample.write = report.job.write;
  sample.parameter = report.job.number.value();
  sample.element = report.job.element.value();
  sample.sub_slave = report.job.sub_slave.value;
  sample.doubleword = report.job.doubleword;
  sample.value = report.job.value;
  return sample;
}

cansync_slave_BlockJob block_job(BlockReport& report, const DaemonIdentity& daemon,
                                 const gateway::dds::WriterGuid& application) noexcept {
  cansync_slave_BlockJob sample = {};
  std::copy(application.begin(), application.end(), std::begin(sample.application));
  sample.job = report.block.id;
  gateway::dds::set_daemon(daemon, sample);
  sample.time = report.when.wall_clock.count();
  sample.interval = report.when.interval;
  sample.step = to_idl(report.step);
  sample.result = to_idl(report.end);
  sample.download = report.block.direction == cansync::AskedBlock::Direction::download;
  sample.address = report.block.address;
  sample.length = report.block.length;
  sample.whole = report.block.area;
  sample.offset = report.offset;
  sample.bytes = report.step == BlockReport::Step::telegram ? report.bytes : std::uint16_t{0};
  const bool with_data = report.step == BlockReport::Step::complete ||
                         (report.step == BlockReport::Step::telegram && sample.download);
  sample.data._buffer = report.data.data();
  sample.data._length = with_data ? report.bytes : 0u;
  sample.data._maximum = sample.data._length;
  return sample;
}

}  // namespace cansyncd
