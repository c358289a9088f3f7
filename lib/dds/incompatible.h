#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "dds/participant.h"

namespace gateway::dds {

/// A reader or writer of another program that is on a topic of a participant and in its partition, and does
/// not match.
struct Incompatible {
  std::string topic;        ///< name
  bool writes = false;      ///< a writer; false: a reader
  std::string policy;       ///< what does not fit: `data representation`, `ownership`, ..., `type`
  std::string difference;   ///< in words: what is offered, and what is asked for; may be empty
  std::string who;          ///< its program, printable ASCII, at most 127 characters; never empty
  std::string participant;  ///< its DDS participant, 32 hexadecimal digits
};

/// Looks through what discovery knows of the domain, which takes the time of some thousand allocations there.
/// At most `most` are returned, the participant's own are not among them. Endpoints that DDS Security keeps
/// apart, or that are about to match, are none. `types`: endpoints that fit by name and QoS and do not match
/// all the same differ in their types (Participant::type_mismatches). Any thread; never throws but for
/// memory.
std::vector<Incompatible> find_incompatible(const Participant& participant, bool types, std::size_t most);

/// "a writer of topic Command of NAME does not match: ownership (offered shared, asked for exclusive)"
std::string to_string(const Incompatible& endpoint);

}  // namespace gateway::dds
