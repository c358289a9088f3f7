#pragma once

#include <cansync/function_blocks/command_slot.h>
#include <cansync/types.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

/// Internal to lib/client.
namespace cansync::client::detail {

/// A setting that a function block has entered. Locked by its book.
struct SettingState {
  std::string block;                            ///< whose it is
  bool entered = false;                         ///< there is one
  std::array<std::uint8_t, 16> daemon = {};     ///< the start it was entered in
  std::chrono::steady_clock::time_point given;  ///< when it was entered last
  bool in_force = false;                        ///< there
  std::string error;                            ///< why it is not
  struct Before {
    function_blocks::CommandSlot slot;
    function_blocks::CommandSlot::Submit submit;
  };
  std::optional<Before> before;                   ///< what was entered before a wrong one was refused
  std::optional<MappingBytes> reference_mapping;  ///< what it maps
  std::uint64_t mapping_before = 1;               ///< number of the mapping known when it was entered, from 1
};

/// The settings of a client's function blocks: which are in force in the daemon. Any thread.
class SettingsBook {
 public:
  void add(const std::shared_ptr<SettingState>& state) {
    const std::lock_guard lock(mutex_);
    std::erase_if(states_, [](const auto& each) { return each.expired(); });
    states_.push_back(state);
  }

  template <class Change>
  void change(SettingState& state, Change&& change) {
    const std::lock_guard lock(mutex_);
    change(state);
  }

  /// Which setting is not in force in the start of the daemon that is known; empty: none. A mapping counts
  /// from the status that shows it or a later one: values given before would name the mapping before it.
  std::string missing(const Validity& known, const MappingBytes& mapping) const {
    const std::lock_guard lock(mutex_);
    for (const auto& each : states_) {
      const auto state = each.lock();
      if (!state || !state->entered) continue;
      const bool shown = !state->reference_mapping || *state->reference_mapping == mapping ||
                         known.mapping_number > state->mapping_before;
      if (state->in_force && state->daemon == known.daemon && shown) continue;
      return state->block + (state->error.empty() ? ": not yet in effect" : ": " + state->error);
    }
    return {};
  }

  /// True when a block has entered this mapping of the reference values.
  bool maps(const MappingBytes& mapping) const {
    const std::lock_guard lock(mutex_);
    for (const auto& each : states_) {
      const auto state = each.lock();
      if (state && state->in_force && state->reference_mapping == mapping) return true;
    }
    return false;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::weak_ptr<SettingState>> states_;
};

}  // namespace cansync::client::detail
