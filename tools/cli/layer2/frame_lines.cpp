#include "cli/layer2/frame_lines.h"

#include <fmt/format.h>

namespace cansync::cli {

std::string identifier_text(const can::Frame& frame) {
  return frame.extended ? fmt::format("{:08X}", frame.id) : fmt::format("{:03X}", frame.id);
}

std::string data_text(const can::Frame& frame) {
  if (frame.remote) return "remote";
  std::string text;
  for (unsigned i = 0; i < frame.dlc && i < frame.data.size(); ++i)
    text += fmt::format("{}{:02X}", i == 0 ? "" : " ", frame.data[i]);
  return text;
}

void add_frame(const can::Frame& frame, text::JsonObject& object) {
  text::JsonArray data;
  for (unsigned i = 0; !frame.remote && i < frame.dlc && i < frame.data.size(); ++i) data.add(frame.data[i]);
  object.add("identifier", frame.id)
      .add("extended", frame.extended)
      .add("remote", frame.remote)
      .add("length", frame.dlc)
      .add("data", data);
}

}  // namespace cansync::cli
