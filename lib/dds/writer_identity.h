#pragma once

#include <dds/dds.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "dds/endpoint.h"
#include "dds/participant.h"

namespace gateway::dds {

/// Who is behind a writer, as far as it tells.
struct WriterIdentity {
  std::string who;  ///< e.g. "'lead axis' (lead_axis, process 1234 on host plc7)"; at most 127 bytes
  std::int32_t strength = 0;               ///< of its ownership
  std::array<std::uint8_t, 16> guid = {};  ///< of DDS; all 0: not known
};

/// The program that an endpoint belongs to, in words like `WriterIdentity::who`; never empty. Any thread;
/// asks DDS.
std::string program_of(const Participant& participant, const dds_builtintopic_endpoint_t& endpoint);

/// The writer with this handle, matched with `reader`; nothing when it has left. What peers say of themselves
/// is shortened, and control characters are taken out of it. Any thread; asks DDS, so not in a hurry.
std::optional<WriterIdentity> identify_writer(const Participant& participant, dds_entity_t reader,
                                              dds_instance_handle_t writer);

/// The participant, by its instance handle, of a writer that is matched with `reader`; 0: it is matched no
/// more. This and the next two: any thread; they ask DDS, and wait for a write in progress.
dds_instance_handle_t participant_of_writer(dds_entity_t reader, dds_instance_handle_t writer);

/// Is a reader of the participant matched with the writer? DDS finds the endpoints of a program one by one,
/// so that one topic may know a program of which another has not heard yet.
bool is_read_by(const WriterBase& writer, dds_instance_handle_t participant);
/// Is a writer of the participant matched with the reader?
bool is_written_by(const ReaderBase& reader, dds_instance_handle_t participant);

}  // namespace gateway::dds
