#pragma once

#include <string>

#include "can/frame.h"
#include "text/json.h"

/// What the verbs of general frames write of frames. Main thread.
namespace cansync::cli {

/// Three hexadecimal digits, eight of a 29-bit identifier.
std::string identifier_text(const can::Frame& frame);

/// The bytes, hexadecimal; "remote" of a remote frame.
std::string data_text(const can::Frame& frame);

/// Identifier, width, kind, length and data.
void add_frame(const can::Frame& frame, text::JsonObject& object);

}  // namespace cansync::cli
