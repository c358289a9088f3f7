#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <tuple>

#include "cansync/telegram/telegram.h"

namespace cansyncd::campaign {

/// How often what changes something was handed to the bus, and stood on it.
class SentTruth {
 public:
  struct Write {
    unsigned slave = 0;
    unsigned number = 0;
    std::uint32_t value = 0;
    friend auto operator<=>(const Write&, const Write&) = default;
  };
  struct Count {
    std::uint64_t handed = 0;
    std::uint64_t on_bus = 0;
  };

  void handed_over(const cansync::Telegram& telegram) {
    if (const auto* action = std::get_if<cansync::ActionCommand>(&telegram)) ++actions_[key(*action)].handed;
    const auto* command = std::get_if<cansync::ParameterCommand>(&telegram);
    if (command == nullptr || command->kind == cansync::ParameterCommand::Kind::read) return;
    ++writes_[{command->slave.value(), command->number.value(), command->value}];
  }
  void on_bus(const cansync::ActionCommand& action) { ++actions_[key(action)].on_bus; }

  Count action(const cansync::ActionCommand& action) const { return at(actions_, key(action)); }
  /// Telegrams that write exactly this.
  std::uint64_t writes(const Write& write) const { return at(writes_, write); }

  /// Slaves, command, data byte and data word.
  using Action = std::tuple<std::uint32_t, std::uint8_t, std::uint8_t, std::uint16_t>;

  /// Forgets what nothing is open of: `keeps` is asked with each Action and each Write.
  template <class Keeps>
  void forget(Keeps&& keeps) {
    std::erase_if(actions_, [&](const auto& entry) { return !keeps(entry.first); });
    std::erase_if(writes_, [&](const auto& entry) { return !keeps(entry.first); });
  }

 private:
  static Action key(const cansync::ActionCommand& action) {
    return {action.slaves.bits, action.command, action.data_byte, action.data_word};
  }
  template <class Map>
  static typename Map::mapped_type at(const Map& map, const typename Map::key_type& key) {
    const auto found = map.find(key);
    return found == map.end() ? typename Map::mapped_type{} : found->second;
  }

  std::map<Action, Count> actions_;
  std::map<Write, std::uint64_t> writes_;
};

}  // namespace cansyncd::campaign
