#include "cli/layer2/frame_lines.h"

#include <fmt/format.h>

#include <iterator>

namespace cansync::cli {

std::string identifier_text(const layer2_CanFrame& frame) {
  return frame.extended ? fmt::format("{:08X}", frame.identifier) : fmt::format("{:03X}", frame.identifier);
}

std::string data_text(const layer2_CanFrame& frame) {
  if (frame.remote) return "remote";
  std::string text;
  for (unsigned i = 0; i < frame.length && i < std::size(frame.data); ++i)
    text += fmt::format("{}{:02X}", i == 0 ? "" : " ", frame.data[i]);
  return text;
}

void add_frame(const layer2_CanFrame& frame, JsonObject& object) {
  JsonArray data;
  for (unsigned i = 0; !frame.remote && i < frame.length && i < std::size(frame.data); ++i)
    data.add(frame.data[i]);
  object.add("identifier", frame.identifier)
      .add("extended", frame.extended)
      .add("remote", frame.remote)
      .add("length", frame.length)
      .add("data", data);
}

}  // namespace cansync::cli
