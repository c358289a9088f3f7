#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "dds/participant.h"

namespace gateway::dds {

/// The beginning of what a peer says, as printable ASCII of at most 40 bytes; any other byte as "\x1b". Any thread.
std::string printable_part(std::string_view text);

/// What a participant says of its process; each empty or 0 when it says nothing. Not checked, but shortened,
/// and without control characters.
struct ProcessFacts {
  std::string program;
  std::uint32_t process = 0;  ///< its number
  std::string host;
};

/// Those of the participant with this key, as endpoints have it in `participant_key`. Any thread; asks DDS.
ProcessFacts process_facts(const Participant& participant, const std::array<std::uint8_t, 16>& key);

/// "lead_axis, process 1234 on host plc7"; empty when nothing is known.
std::string text_of(const ProcessFacts& facts);

}  // namespace gateway::dds
