#pragma once

#include <dds/dds.h>

#include <cstdint>
#include <optional>
#include <string>

#include "dds/participant.h"

namespace gateway::dds {

/// Who is behind a writer, as far as it tells.
struct WriterIdentity {
  std::string who;  ///< e.g. "'lead axis' (lead_axis, process 1234 on host plc7)"; at most 127 bytes
  std::int32_t strength = 0;  ///< of its ownership
};

/// The program that an endpoint belongs to, in words like `WriterIdentity::who`; never empty. Any thread;
/// asks DDS.
std::string program_of(const Participant& participant, const dds_builtintopic_endpoint_t& endpoint);

/// The writer with this handle, matched with `reader`; nothing when it has left. What peers say of themselves
/// is shortened, and control characters are taken out of it. Any thread; asks DDS, so not in a hurry.
std::optional<WriterIdentity> identify_writer(const Participant& participant, dds_entity_t reader,
                                              dds_instance_handle_t writer);

}  // namespace gateway::dds
