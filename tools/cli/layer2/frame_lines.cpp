#include "cli/layer2/frame_lines.h"

#include <cstddef>
#include <cstdint>

namespace cansync::cli {

namespace {

constexpr char kNibbles[] = "0123456789ABCDEF";

}  // namespace

std::string identifier_text(const can::Frame& frame) {
  std::string text(frame.extended ? 8 : 3, '0');
  std::uint32_t rest = frame.id;
  for (std::size_t i = text.size(); i-- > 0; rest >>= 4) text[i] = kNibbles[rest & 0xF];
  return text;
}

std::string data_text(const can::Frame& frame) {
  if (frame.remote) return "remote";
  std::string text;
  for (unsigned i = 0; i < frame.dlc && i < frame.data.size(); ++i) {
    if (i != 0) text += ' ';
    text += kNibbles[frame.data[i] >> 4];
    text += kNibbles[frame.data[i] & 0xF];
  }
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
