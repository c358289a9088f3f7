#pragma once

#include <string>

#include "cansync/observe/evidence.h"
#include "cli/base/output.h"

/// Which protocol the frames of a bus belong to, and how far their time stamps can be trusted, as text.
namespace cansync::cli {

/// True when something was received and it does not look like CANsync. `frames`: error frames included.
bool is_other_protocol(const observe::LineEvidence& evidence, std::uint64_t frames) noexcept;

/// "CANsync, 98 %", "J1939", "CANopen", "unknown"; "-" for a bus without frames.
std::string protocol_text(const observe::LineEvidence& evidence);

/// The evidence for it.
std::string evidence_text(const observe::LineEvidence& evidence);

/// "this does not look like CANsync; it looks like J1939: ...".
std::string other_protocol_text(const observe::LineEvidence& evidence);

/// "steady", "bunched" or "coarse", and why.
std::string stamps_text(const observe::StampCheck::Result& stamps);
std::string stamps_evidence(const observe::StampCheck::Result& stamps);

/// Says so when they are not steady.
void remark_on_stamps(Output& output, const observe::StampCheck::Result& stamps);

}  // namespace cansync::cli
