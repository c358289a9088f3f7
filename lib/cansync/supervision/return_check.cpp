#include "cansync/supervision/return_check.h"

namespace cansync {

void ReturnCheck::begin(const SlaveSettings& settings, SlaveNumber slave,
                        IntervalNumber monitoring) noexcept {
  stop();
  failure_ = nullptr;
  slave_ = slave;
  monitoring_ = monitoring;
  at_ = 0;
  if (settings.on_return == OnReturn::release || settings.return_count == 0) return;
  settings_ = &settings;
  ask(settings.on_return == OnReturn::write);
}

void ReturnCheck::ask(bool write) noexcept {
  ParameterRequest request;
  request.slave = slave_;
  request.number = wanted().number;
  request.write = write;
  request.value = wanted().value;
  job_ = ParameterJob(request);
  sent_ = false;
}

Step ReturnCheck::answered(const ParameterReply& reply, IntervalNumber now) noexcept {
  const Step step = job_.answered(reply, now);
  return step == Step::ended ? step_ended() : step;
}

Step ReturnCheck::check_time(IntervalNumber now) noexcept {
  if (!job_.monitored()) {
    job_.monitor_until(now + monitoring_);
    return Step::again;
  }
  if (now < job_.deadline()) return Step::again;
  job_.end(Outcome::timeout, now);
  return step_ended();
}

Step ReturnCheck::step_ended() noexcept {
  const bool written = job_.request().write;
  const ParameterResult& result = job_.result();
  if (result.outcome != Outcome::done || (!written && result.value != wanted().value)) {
    failure_ = &wanted();
    settings_ = nullptr;
    return Step::ended;
  }
  if (written) {
    ask(false);
    return Step::again;
  }
  if (++at_ == settings_->return_count) {
    settings_ = nullptr;
    return Step::ended;
  }
  ask(settings_->on_return == OnReturn::write);
  return Step::again;
}

}  // namespace cansync
