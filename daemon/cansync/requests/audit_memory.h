#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <tuple>

#include "cansync/mode.h"
#include "daemon/cansync/config/config.h"
#include "daemon/cansync/exchange.h"

namespace cansyncd {

/// What values were before: what this daemon read, wrote or set last. Nothing is read from a slave for it.
/// Gateway thread only.
class AuditMemory {
 public:
  /// Parameter values remembered; then the oldest is forgotten.
  static constexpr std::size_t kParameters = 4096;
  static constexpr const char* kNotKnown = "not known";

  explicit AuditMemory(const Config& config);

  /// The value `request` would replace, or "not known". `state`: the master's, when the request was taken.
  std::string before(const Request& request, cansync::State state) const;

  /// `request` ended as done.
  void done(const Request& request);
  /// A parameter was read or written, or a write got no answer.
  void learn(const cansync::ParameterRequest& request, const cansync::ParameterResult& result);

 private:
  using Key = std::tuple<std::uint8_t, std::uint16_t, std::uint16_t>;  ///< slave, sub-slave, number
  struct Before;
  struct Done;

  void remember(const Key& key, std::uint32_t value);

  std::map<Key, std::uint32_t> parameters_;
  std::deque<Key> order_;  ///< of parameters_, oldest first
  std::array<std::optional<std::uint16_t>, cansync::kSlaves> control_words_ = {};
  cansync::SettingsInForce settings_;
};

}  // namespace cansyncd
