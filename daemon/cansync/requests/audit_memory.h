#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <tuple>

#include "cansync/channel/jobs.h"
#include "cansync/config/config.h"
#include "cansync/settings/settings_in_force.h"

namespace cansyncd {

/// What values were before: what this daemon read, wrote or set last. Nothing is read from a slave for it.
/// Gateway thread only.
class AuditMemory {
 public:
  /// Parameter values remembered; then the oldest is forgotten.
  static constexpr std::size_t kParameters = 4096;

  explicit AuditMemory(const Config& config);

  /// The newest value of the parameter that `request` names; nothing: not known.
  std::optional<std::uint32_t> parameter(const cansync::ParameterRequest& request) const;
  /// A parameter job ended: keeps the value, or forgets it when the slave may have another one.
  void learn(const cansync::ParameterRequest& request, const cansync::ParameterResult& result);

  /// The control word that a slave got last; nothing: not known.
  std::optional<std::uint16_t> control_word(cansync::SlaveNumber slave) const {
    return control_words_[slave.value()];
  }
  void set_control_word(cansync::SlaveNumber slave, std::uint16_t word) {
    control_words_[slave.value()] = word;
  }
  /// It may have got a newer one.
  void forget_control_word(cansync::SlaveNumber slave) { control_words_[slave.value()].reset(); }

  /// Mappings, polling and cursors.
  const cansync::SettingsInForce& settings() const noexcept { return settings_; }
  cansync::SettingsInForce& settings() noexcept { return settings_; }

 private:
  using Key = std::tuple<std::uint8_t, std::uint16_t, std::uint16_t>;  ///< slave, sub-slave, number

  static Key key_of(const cansync::ParameterRequest& request) noexcept;
  void remember(const Key& key, std::uint32_t value);

  std::map<Key, std::uint32_t> parameters_;
  std::deque<Key> order_;  ///< of parameters_, oldest first
  std::array<std::optional<std::uint16_t>, cansync::kSlaves> control_words_ = {};
  cansync::SettingsInForce settings_;
};

}  // namespace cansyncd
