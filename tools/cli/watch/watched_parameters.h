#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cli/base/session.h"
#include "cli/cansync/profiles.h"

/// Parameters that `watch` shows beside the actual values.
namespace cansync::cli {

inline constexpr std::size_t kMostParameters = 8;

/// One parameter of one slave, and what its reads gave.
struct WatchedParameter {
  std::uint32_t number = 0;
  std::string typed;                                 ///< its name or number on the command line
  bool asked = true;                                 ///< false: the slave's profile does not have this name
  bool by_name = false;                              ///< shown in its unit, else raw
  ProfilePointer profile = {};                       ///< keeps `known`
  const profile::Parameter* known = nullptr;         ///< null: no profile tells of it
  std::optional<client::ParameterReply> last = {};   ///< of the newest read, also of one that failed
  std::optional<client::ParameterReply> value = {};  ///< of the newest that was done
  std::int64_t time = 0;                             ///< CLOCK_REALTIME in ns of `value`
};

/// The parameters of the slaves with these numbers.
struct WatchedSlave {
  unsigned slave = 0;
  std::vector<WatchedParameter> parameters;  ///< in the order typed
};

/// What stands above a parameter's values: its name, or "parameter 100".
std::string heading_of(const WatchedParameter& parameter);

/// The number as it is to be shown: with the sign that its profile gives it. `value` is there.
std::int64_t raw_number(const WatchedParameter& parameter);

/// In the unit of the profile; nothing: no value yet, or no profile tells.
std::optional<double> scaled_number(const WatchedParameter& parameter);

/// What the profile calls the value's bits or number; empty: nothing.
std::string words_of(const WatchedParameter& parameter);

/// "12.5 mm", "3: closed loop", "-": in its unit when it was asked for by name and `raw` is not set.
std::string text_of(const WatchedParameter& parameter, bool raw);

/// Age in ms of the oldest of the values; nothing: there is none yet.
std::optional<std::int64_t> oldest_ms(const std::vector<WatchedParameter>& parameters, std::int64_t now);

/// The parameters `typed` (numbers or names, with commas) of these slaves (bit n: slave n), by rising number.
/// A name that a slave does not know is not asked of it when the slaves were not named one by one. Throws
/// UsageError, std::runtime_error.
std::vector<WatchedSlave> find_watched(Session& session, const std::vector<std::string>& typed,
                                       std::uint32_t slaves, bool named);

}  // namespace cansync::cli
