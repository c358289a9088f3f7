#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "daemon/cansync/config/config.h"
#include "daemon/cansync/exchange.h"

/// What a request is allowed to do. Pure functions; any thread.
namespace cansyncd {

/// Who may give a request, with DDS Security on. Each includes those before it.
enum class Right : std::uint8_t {
  operate,   ///< operators: control words, broadcasts, reference values, cancelling
  engineer,  ///< engineers: parameters, transfers, modes, polling, cursors, mappings
};

/// The least right a request needs.
Right needed_right(const Request& request);

/// Would it change a drive, the line or the master? False for reads, uploads, cancelling and withdrawing.
bool changes_something(const Request& request);

/// Why `request` is not taken from a topic that gives only `right`; nothing when it may be taken.
std::optional<std::string> right_refusal(const Request& request, Right right);

/// Why `request` is not taken because the daemon is read-only; nothing when it may be taken.
std::optional<std::string> read_only_refusal(const Request& request, const Config& config);

/// The same for reference values.
std::optional<std::string> read_only_refusal_of_references(const Config& config);

}  // namespace cansyncd
