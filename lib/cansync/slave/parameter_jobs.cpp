#include "cansync/slave/parameter_jobs.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace cansync {
namespace {

/// A master that still waits asks far more often.
constexpr Duration kFetchTime = std::chrono::seconds(1);

}  // namespace

bool ParameterJobs::belongs_to_application(ParameterNumber number, SubSlave sub) const noexcept {
  if (sub.value != 0) return settings_.sub_slaves || taken_.sub_slaves;
  if (taken_.numbers[number.value()]) return true;
  const ParameterDefinition* definition = table_.definition(number.value());
  return definition == nullptr ? settings_.unknown_numbers : definition->by_application;
}

ParameterAnswer ParameterJobs::read(ParameterNumber number, Element element, SubSlave sub) noexcept {
  questioned_at_ = now_;
  AskedParameter job;
  job.number = number;
  job.element = element;
  job.sub_slave = sub;
  if (is_open(job)) return answer_to_open();
  forget_sending();
  const bool own = belongs_to_application(number, sub);
  if (sub.value != 0 && !own) return ParameterAnswer::refused(ParameterError::not_present);
  const ParameterDefinition* definition = sub.value == 0 ? table_.definition(number.value()) : nullptr;
  const bool in_table = definition != nullptr;
  if (!own) {
    if (!in_table) return ParameterAnswer::refused(settings_.unknown);
    if (definition->without_application != ParameterError::none)
      return ParameterAnswer::refused(definition->without_application);
  }
  // Limits and first value stand in the table, whoever answers for the value.
  if (!own || (in_table && element != kValueElement)) return table_.read(number, element);
  if (in_table) {
    const ParameterAnswer known = table_.read(number, element);
    if (known.error != ParameterError::none) return known;
  }
  return ask(job);
}

ParameterAnswer ParameterJobs::write(ParameterNumber number, Element element, SubSlave sub, bool doubleword,
                                     std::uint32_t value) noexcept {
  questioned_at_ = now_;
  AskedParameter job;
  job.write = true;
  job.number = number;
  job.element = element;
  job.sub_slave = sub;
  job.doubleword = doubleword;
  job.value = value;
  if (is_open(job)) return answer_to_open();
  forget_sending();
  const bool own = belongs_to_application(number, sub);
  if (sub.value != 0 && !own) return ParameterAnswer::refused(ParameterError::not_present);
  const ParameterDefinition* definition = sub.value == 0 ? table_.definition(number.value()) : nullptr;
  if (!own) {
    if (definition == nullptr) return ParameterAnswer::refused(settings_.unknown);
    if (definition->without_application != ParameterError::none)
      return ParameterAnswer::refused(definition->without_application);
    return table_.write(number, doubleword, value);
  }
  if (definition != nullptr) {
    const ParameterAnswer allowed = table_.check(number, doubleword, value);
    if (allowed.error != ParameterError::none) return allowed;
  }
  return ask(job);
}

ParameterAnswer ParameterJobs::ask(const AskedParameter& job) noexcept {
  if (!application_) return ParameterAnswer::refused(ParameterError::not_available_now);
  open_ = job;
  open_->id = ++ids_;
  answer_.reset();
  asked_at_ = now_;
  listener_.asked(*open_);
  return ParameterAnswer::later();
}

/// Is this the question that is open, again? Another one drops it, if the slave has not told so before.
bool ParameterJobs::is_open(const AskedParameter& job) noexcept {
  if (!open_) return false;
  AskedParameter same = job;
  same.id = open_->id;
  if (same == *open_) return true;
  dropped();
  return false;
}

/// Whoever is to answer its number now.
ParameterAnswer ParameterJobs::answer_to_open() noexcept {
  if (!answer_) return ParameterAnswer::later();
  // What has an id of 0 was the application's that is gone.
  sending_ = open_->id;
  open_.reset();
  return *answer_;
}

void ParameterJobs::dropped() noexcept {
  const std::optional<AskedParameter> gone = std::exchange(open_, std::nullopt);
  if (gone && gone->id != 0) listener_.dropped(gone->id);
  forget_sending();
}

/// For how long an answer waits for the master.
Duration ParameterJobs::keeping() const noexcept {
  return std::max(settings_.answer_time, kFetchTime);
}

bool ParameterJobs::keeps_answer() noexcept {
  if (now_ - questioned_at_ > keeping()) return false;
  questioned_at_ = now_;
  return true;
}

/// A new question came, or none for long, so the answer before was never on the bus, or nobody saw it there.
void ParameterJobs::forget_sending() noexcept {
  if (const std::uint64_t id = std::exchange(sending_, 0); id != 0) listener_.dropped(id);
}

void ParameterJobs::sent() noexcept {
  if (const std::uint64_t id = std::exchange(sending_, 0); id != 0) listener_.answered(id);
}

void ParameterJobs::set_application(bool present) noexcept {
  application_ = present;
  if (present) return;
  taken_ = {};
  if (open_ && !answer_) end_open();
}

void ParameterJobs::take_over(const TakenOver& taken) noexcept {
  taken_ = taken;
  if (open_ && !answer_ && !belongs_to_application(open_->number, open_->sub_slave)) end_open();
}

void ParameterJobs::at(Duration now) noexcept {
  now_ = now;
  if (now - questioned_at_ > keeping()) forget_sending();
  if (!open_) return;
  const Duration limit = settings_.answer_time;
  if (!answer_) {
    if (limit.count() != 0 && now - asked_at_ > limit) end_open();
  } else if (now - answered_at_ > keeping()) {
    dropped();  // the master has given up: the same question later is a new one
  }
}

/// The application does not answer it any more: the master's next question is answered without.
void ParameterJobs::end_open() noexcept {
  listener_.dropped(std::exchange(open_->id, 0));
  answer_ = without_application(*open_);
  answered_at_ = now_;
}

ParameterAnswer ParameterJobs::without_application(const AskedParameter& job) const noexcept {
  const bool below = job.sub_slave.value != 0;
  const ParameterDefinition* definition = below ? nullptr : table_.definition(job.number.value());
  const bool by_application = definition != nullptr
                                  ? definition->by_application
                                  : (below ? settings_.sub_slaves : settings_.unknown_numbers);
  if (by_application) return ParameterAnswer::refused(ParameterError::not_available_now);
  if (definition != nullptr && definition->without_application != ParameterError::none)
    return ParameterAnswer::refused(definition->without_application);
  // Nobody knows whether a write was taken.
  if (job.write) return ParameterAnswer::refused(ParameterError::not_available_now);
  if (definition != nullptr) return table_.read(job.number, job.element);
  return ParameterAnswer::refused(below ? ParameterError::not_present : settings_.unknown);
}

bool ParameterJobs::answer(std::uint64_t id, const ParameterAnswer& answer) noexcept {
  if (!open_ || id == 0 || open_->id != id || answer_) return false;
  answer_ = answer;
  answer_->busy = false;
  answered_at_ = now_;
  return true;
}

}  // namespace cansync
