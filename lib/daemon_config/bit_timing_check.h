#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "can/link_facts.h"
#include "daemon_config/daemon_config.h"

/// The bit timing that a bus is to have. Pure functions; not for the realtime thread (they allocate).
namespace cansyncd {

/// What is wrong with the bit timing registers of a configuration.
struct BitTimingProblem {
  const char* option;  ///< "bus.btr0" or "bus.btr1"
  std::string text;    ///< what was found and what is allowed
};

/// Checks that the registers, when given, are complete, can work, and give the configured bit rate.
std::optional<BitTimingProblem> check_bit_timing(const BusConfig& bus);

/// Sample point the interface should have, in 1/1000 of a bit: of the registers when given, else of the protocol.
/// 0: any.
std::uint16_t wanted_sample_point(const BusConfig& bus);

/// Shell command that sets the interface to the configured bit timing and up, and so that it sends. `link`: what the
/// kernel knows of it.
std::string bit_rate_command(const BusConfig& bus, const can::LinkFacts& link);

/// Shell command that sets an interface up that is down: without bit timing where its driver has none (vcan,
/// slcan). `link`: as above.
std::string set_up_command(const BusConfig& bus, const can::LinkFacts& link);

/// Shell command that sets the interface to one-shot mode and up.
std::string one_shot_command(const BusConfig& bus);

}  // namespace cansyncd
