#include "cansync/supervision/strays.h"

namespace cansync {

Strays::Origin Strays::origin(const Telegram& telegram) noexcept {
  if (const auto* actual = std::get_if<ActualTelegram>(&telegram))
    return {index(actual->channel), actual->slave};
  if (const auto* reply = std::get_if<ParameterReply>(&telegram)) return {kResponse, reply->slave};
  const auto* reply = std::get_if<TransferReply>(&telegram);
  return {kResponse, reply != nullptr ? reply->slave : SlaveNumber{}};
}

void Strays::taken(const can::Frame& frame, const Telegram& telegram) noexcept {
  const Origin from = origin(telegram);
  owed_[from.place].set(from.slave, false);
  known_[from.place].set(from.slave);
  last_[from.place][from.slave.value()] = frame;
}

Unexpected Strays::judge(const can::Frame& frame, const Telegram& telegram,
                         std::optional<SlaveNumber> asked) noexcept {
  const Origin from = origin(telegram);
  if (owed_[from.place].has(from.slave)) {
    owed_[from.place].set(from.slave, false);
    return Unexpected::late;
  }
  if (known_[from.place].has(from.slave) && last_[from.place][from.slave.value()] == frame)
    return Unexpected::duplicate;
  if (!asked) return Unexpected::unasked;
  return *asked == from.slave ? Unexpected::wrong_answer : Unexpected::wrong_slave;
}

}  // namespace cansync
