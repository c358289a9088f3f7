#include "reference_truth.h"

namespace cansyncd::campaign {

void ReferenceTruth::pushed(std::uint32_t number, const cansync::ReferenceUpdate& update) {
  updates_[number % kKnown] = {number, update.channel, update.from_interval, update.release_intervals, 0, 0};
}

void ReferenceTruth::released(const cansync::ReferenceTelegram& telegram, std::uint64_t now) {
  if (telegram.words == 0) return;  // asks for actual values alone
  Update& update = updates_[telegram.word[0] % kKnown];
  const std::uint32_t number = update.number;
  if (number == 0 || update.channel != telegram.channel || number % kKnown != telegram.word[0]) {
    complain(telegram.word[0], "were never given for this telegram");
    return;
  }
  if (number <= in_force_[index(telegram.channel)])
    complain(number, "are released after they were withdrawn");
  if (update.count == 0) update.first = now;
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
