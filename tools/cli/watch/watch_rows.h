#pragma once

#include <cansync/client.h>
#include <cansync/topics.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cli/cansync/fault_words.h"
#include "cli/watch/watched_parameters.h"

/// What `watch` knows of the slaves at one moment, from the newest samples of their topics.
namespace cansync::cli {

inline constexpr unsigned kSlaveValues = 8;

/// One slave at one moment.
struct WatchRow {
  client::SlaveStatus status = {};
  std::optional<client::ActualValues> values;
  std::uint8_t shown = 0;  ///< bit n: value n is mapped and its telegram came at least once
  std::string fault = {};  ///< what the slave's profile calls the faults in its status word; empty: none
  std::vector<WatchedParameter> parameters = {};  ///< in the order typed
};

/// Nanoseconds of CLOCK_REALTIME, which time stamps of samples are compared with.
std::int64_t wall_clock();

/// Gives the newest actual values of these slaves (bit n: slave n) half a second to come.
void await_values(const client::Client& client, std::uint32_t wanted);

/// The rows of these slaves, in rising order. Waits for nothing.
std::vector<WatchRow> watch_rows(const client::Client& client, std::uint32_t wanted, FaultWords& faults);

/// The number on the bus of value 0..7, with the width it came with.
std::int64_t raw_number(const client::ActualValues& values, unsigned value, bool is_signed);

}  // namespace cansync::cli
