#include "cli/layer2/send_frames.h"

#include <fmt/format.h>

#include <string>
#include <variant>

#include "can/candump.h"
#include "cli/text/values.h"

namespace cansync::cli {
namespace {

/// `text` without the dots between its bytes, which can-utils allow; as it is when one stands elsewhere.
std::string without_dots(std::string_view text) {
  const std::size_t data = text.find('#') + 1;
  std::string out(text.substr(0, data));
  for (std::size_t i = data, digits = 0; data != 0 && i < text.size(); ++i) {
    if (text[i] != '.') {
      out += text[i];
      ++digits;
    } else if (digits == 0 || digits % 2 != 0 || i + 1 == text.size() || text[i + 1] == '.') {
      return std::string(text);
    }
  }
  return data == 0 ? std::string(text) : out;
}

}  // namespace

can::Frame parse_sent_frame(std::string_view text) {
  const auto refuse = [text](std::string_view why) {
    throw UsageError(fmt::format(
        "FRAME: found '{}', {}; allowed: ID#DATA with three hexadecimal digits, or eight for 29 bits, and up to "
        "8 bytes, such as 123#0102FF, 18DAF110#, or 123#R3 for a remote frame of length 3",
        text, why));
  };
  const bool prefix = text.starts_with("0x") || text.starts_with("0X");
  const auto parsed = can::parse_candump_frame(without_dots(prefix ? text.substr(2) : text));
  if (const auto* wrong = std::get_if<can::CandumpError>(&parsed)) refuse(wrong->message);
  const auto* frame = std::get_if<can::Frame>(&parsed);
  if (frame->error) refuse("which is an error frame");
  return *frame;
}

}  // namespace cansync::cli
