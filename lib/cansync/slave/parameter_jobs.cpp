#include "cansync/slave/parameter_jobs.h"

#include <utility>

namespace cansync {
namespace {

ParameterAnswer access_refused(ParameterError error) noexcept {
  ParameterAnswer answer;
  answer.error = error;
  return answer;
}

ParameterAnswer access_busy() noexcept {
  ParameterAnswer answer;
  answer.busy = true;
  return answer;
}

}  // namespace

bool ParameterJobs::belongs_to_application(ParameterNumber number, SubSlave sub) const noexcept {
  if (sub.value != 0) return settings_.sub_slaves;
  const ParameterDefinition* definition = table_.definition(number.value());
  return definition == nullptr ? settings_.unknown_numbers : definition->by_application;
}

ParameterAnswer ParameterJobs::read(ParameterNumber number, Element element, SubSlave sub) noexcept {
  forget_sending();
  const bool own = belongs_to_application(number, sub);
  if (sub.value != 0 && !own) return access_refused(ParameterError::not_present);
  const bool in_table = sub.value == 0 && table_.definition(number.value()) != nullptr;
  // Limits and first value stand in the table, whoever answers for the value.
  if (!own || (in_table && element != kValueElement)) return table_.read(number, element);
  if (in_table) {
    const ParameterAnswer known = table_.read(number, element);
    if (known.error != ParameterError::none) return known;
  }
  AskedParameter job;
  job.number = number;
  job.element = element;
  job.sub_slave = sub;
  return ask(job);
}

ParameterAnswer ParameterJobs::write(ParameterNumber number, Element element, SubSlave sub, bool doubleword,
                                     std::uint32_t value) noexcept {
  forget_sending();
  const bool own = belongs_to_application(number, sub);
  if (sub.value != 0 && !own) return access_refused(ParameterError::not_present);
  if (!own) return table_.write(number, doubleword, value);
  if (sub.value == 0 && table_.definition(number.value()) != nullptr) {
    const ParameterAnswer allowed = table_.check(number, doubleword, value);
    if (allowed.error != ParameterError::none) return allowed;
  }
  AskedParameter job;
  job.write = true;
  job.number = number;
  job.element = element;
  job.sub_slave = sub;
  job.doubleword = doubleword;
  job.value = value;
  return ask(job);
}

ParameterAnswer ParameterJobs::ask(const AskedParameter& job) noexcept {
  // The slave has told of another question by `dropped`, so this is the one that is open, again.
  if (!open_) {
    if (!application_) return access_refused(ParameterError::not_available_now);
    open_ = job;
    open_->id = ++ids_;
    answer_.reset();
    listener_.asked(*open_);
    return access_busy();
  }
  if (!answer_) return access_busy();
  // What has an id of 0 was the application's that is gone.
  sending_ = open_->id;
  open_.reset();
  return *answer_;
}

void ParameterJobs::dropped() noexcept {
  const std::optional<AskedParameter> gone = std::exchange(open_, std::nullopt);
  if (gone && gone->id != 0) listener_.dropped(gone->id);
}

/// A new question came, so the answer before was never on the bus, or nobody saw it there.
void ParameterJobs::forget_sending() noexcept {
  if (const std::uint64_t id = std::exchange(sending_, 0); id != 0) listener_.dropped(id);
}

void ParameterJobs::sent() noexcept {
  if (const std::uint64_t id = std::exchange(sending_, 0); id != 0) listener_.answered(id);
}

void ParameterJobs::set_application(bool present) noexcept {
  application_ = present;
  if (present || !open_ || answer_) return;
  listener_.dropped(std::exchange(open_->id, 0));
  answer_ = access_refused(ParameterError::not_available_now);
}

bool ParameterJobs::answer(std::uint64_t id, const ParameterAnswer& answer) noexcept {
  if (!open_ || id == 0 || open_->id != id || answer_) return false;
  answer_ = answer;
  answer_->busy = false;
  return true;
}

}  // namespace cansync
