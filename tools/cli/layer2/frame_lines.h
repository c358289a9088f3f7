#pragma once

#include <string>

#include "cli/base/session.h"
#include "layer2/client/frame_client.h"

/// What the verbs of general frames write of frames. Main thread.
namespace cansync::cli {

/// Three hexadecimal digits, eight of a 29-bit identifier.
std::string identifier_text(const layer2_CanFrame& frame);

/// The bytes, hexadecimal; "remote" of a remote frame.
std::string data_text(const layer2_CanFrame& frame);

/// Identifier, width, kind, length and data.
void add_frame(const layer2_CanFrame& frame, JsonObject& object);

}  // namespace cansync::cli
