#include "reference_truth.h"

namespace cansyncd::campaign {

void ReferenceTruth::pushed(std::uint32_t number, const cansync::ReferenceUpdate& update,
                            const ReferenceOrigin& origin) {
  updates_[number % kKnown] = {
      number, update.channel, update.from_interval, update.release_intervals + hold_, 0, 0, origin};
}

void ReferenceTruth::look_at_giver(const Update& update) {
  const std::string program = "of program " + std::to_string(update.origin.program);
  if (update.origin.of_daemon_before) {
    note(giver_complaint_, update.number, program + " are released, and meant for the daemon before");
  }
  if (update.number <= ended_in_force_[index(update.channel)][update.origin.program]) {
    note(giver_complaint_, update.number,
         program + " are released after it gave the telegram up, or another one took over");
  }
}

void ReferenceTruth::look_at_limits(const cansync::ReferenceTelegram& telegram) {
  const cansync::ReferenceLimits& limits = limits_[index(telegram.channel) * cansync::kWords];
  const std::uint32_t raw = telegram.word[0] | (std::uint32_t{telegram.word[1]} << 16);
  const std::int64_t number = cansync::number_of(raw, false, true);
  const auto last = std::exchange(sent_[index(telegram.channel)], number);
  const auto beyond = [&](const std::string& limit) {
    note(limit_complaint_, telegram.word[0], "are released with " + std::to_string(number) + ", " + limit);
  };
  if (number < limits.minimum) beyond("minimum " + std::to_string(limits.minimum));
  if (number > limits.maximum) beyond("maximum " + std::to_string(limits.maximum));
  if (mode_asked_ || !last) return;
  const std::int64_t step = number > *last ? number - *last : *last - number;
  if (step > limits.max_step)
    beyond("max_step " + std::to_string(limits.max_step) + ", after " + std::to_string(*last));
}

/// Values for a later interval may wait for it.
void ReferenceTruth::look_at_age(const Update& update, std::uint64_t now, can::Time at) {
  if (maximum_age_.count() == 0 || !update.origin.written || now == update.from) return;
  const can::Time age = at - *update.origin.written;
  if (age <= maximum_age_) return;
  note(age_complaint_, update.number,
       "are " + std::to_string(age.count()) + " ns old when their release begins, allowed are " +
           std::to_string(maximum_age_.count()));
}

void ReferenceTruth::released(const cansync::ReferenceTelegram& telegram, std::uint64_t now, can::Time at) {
  if (telegram.words == 0) return;  // asks for actual values alone
  look_at_limits(telegram);
  Update& update = updates_[telegram.word[0] % kKnown];
  const std::uint32_t number = update.number;
  if (number == 0 || update.channel != telegram.channel || number % kKnown != telegram.word[0]) {
    complain(telegram.word[0], "were never given for this telegram");
    return;
  }
  if (number <= in_force_[index(telegram.channel)])
    complain(number, "are released after they were withdrawn");
  look_at_giver(update);
  if (update.count == 0) {
    update.first = now;
    auto& follows_lost = follows_lost_[index(update.channel)];
    if (follows_lost == update.origin.program) {
      follows_lost.reset();
      taken_over(update.channel, update.origin.program);
    }
    look_at_age(update, now, at);
  }
  if (++update.count > update.intervals) {
    complain(number, "are released " + std::to_string(update.count) + " times, allowed are " +
                         std::to_string(update.intervals));
  }
  if (now >= update.first + update.intervals) {
    complain(number, "are released in interval " + std::to_string(now) + " for the first time in " +
                         std::to_string(update.first) + ", for " + std::to_string(update.intervals) +
                         " intervals in a row");
  }
  if (update.from == 0) return;
  if (now < update.from || now >= update.from + update.intervals) {
    complain(number, "are for " + std::to_string(update.intervals) + " intervals from " +
                         std::to_string(update.from) + " and released in " + std::to_string(now));
  }
}

}  // namespace cansyncd::campaign
