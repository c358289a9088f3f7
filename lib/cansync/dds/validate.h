#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "cansync.h"
#include "cansync/channel/jobs.h"
#include "cansync/settings/settings.h"
#include "dds/denial.h"

/// Every range check of what comes in over DDS, in one place. A problem text names field, value, allowed
/// range and, where there is one, the remedy; it fits `gateway_TEXT`. Gateway thread only (allocates).
namespace cansync::dds {

/// What the checks need to know of the line.
struct Limits {
  SlaveMask configured;                                 ///< configured slaves
  std::array<std::uint16_t, kSlaves> block_limit = {};  ///< most bytes per initialise, per slave
  bool allow_reserved_addresses = false;                ///< start addresses 0x00..0xFF
  std::uint8_t address_step = 1;                        ///< bytes per start address
  std::uint32_t release_limit = 1000;                   ///< most release_intervals
  std::uint32_t ahead_limit = 1000;                     ///< most intervals ahead
  std::uint16_t parameter_queue = 256;                  ///< open parameter jobs of all slaves together
  std::uint16_t transfer_queue = 32;                    ///< open transfers of all slaves together
};

/// Longest monitoring time a request may ask for: one hour.
inline constexpr std::uint32_t kMaximumTimeoutMs = 3'600'000;

/// The limits of a line with these settings.
Limits limits_of(const MasterSettings& settings) noexcept;

/// Nothing, or why the request is refused. What passes can be converted (convert.h) without loss.
gateway::dds::Problem check(const cansync_ParameterRequest& request, const Limits& limits);
gateway::dds::Problem check(const cansync_TransferRequest& request, const Limits& limits);
gateway::dds::Problem check(const cansync_Command& command, const Limits& limits);
/// Reference values have no reply; cause and reason go into an Event.
gateway::dds::Problem check(const cansync_ReferenceValues& values, const Limits& limits);

/// The cause by which clients are told of a refusal of the master; none for Refusal::none.
gateway_RefusalCause to_cause(Refusal refusal) noexcept;

/// A refusal of the master in words, with limits and remedy; for what only the master knows, like a full
/// queue.
std::string explain(Refusal refusal, const Limits& limits);

}  // namespace cansync::dds
