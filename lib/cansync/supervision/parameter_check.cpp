#include "cansync/supervision/parameter_check.h"

namespace cansync {

void ParameterCheck::begin(std::span<const ParameterValue> list, bool write, SlaveNumber slave,
                           IntervalNumber monitoring) noexcept {
  stop();
  failure_ = nullptr;
  write_ = write;
  slave_ = slave;
  monitoring_ = monitoring;
  at_ = 0;
  list_ = list;
  if (running()) ask(write);
}

void ParameterCheck::ask(bool write) noexcept {
  ParameterRequest request;
  request.slave = slave_;
  request.number = wanted().number;
  request.write = write;
  request.value = wanted().value;
  job_ = ParameterJob(request);
  sent_ = false;
}

Step ParameterCheck::answered(const ParameterReply& reply, IntervalNumber now) noexcept {
  const Step step = job_.answered(reply, now);
  return step == Step::ended ? step_ended() : step;
}

Step ParameterCheck::check_time(IntervalNumber now) noexcept {
  if (!job_.monitored()) {
    job_.monitor_until(now + monitoring_);
    return Step::again;
  }
  if (now < job_.deadline()) return Step::again;
  job_.end(JobEnd::time, now);
  return step_ended();
}

Step ParameterCheck::step_ended() noexcept {
  const bool written = job_.request().write;
  const ParameterResult& result = job_.result();
  if (result.outcome != Outcome::done || (!written && result.value != wanted().value)) {
    failure_ = &wanted();
    list_ = {};
    return Step::ended;
  }
  if (written) {
    ask(false);
    return Step::again;
  }
  if (++at_ == list_.size()) {
    list_ = {};
    return Step::ended;
  }
  ask(write_);
  return Step::again;
}

}  // namespace cansync
