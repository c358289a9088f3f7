// Lines of candump's text log (lib/can/candump.h): what is read is written and read again as the same.
#include <array>

#include "bounded.h"
#include "bytes.h"
#include "can/candump.h"
#include "require.h"

namespace {

using fuzz::require;

bool same(const can::CandumpLine& a, const can::CandumpLine& b) {
  return a.time == b.time && a.interface == b.interface && a.frame == b.frame;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text = fuzz::text_of(data, size);
  const auto parsed = fuzz::bounded(size, fuzz::kOfText, [&] { return can::parse_candump_line(text); });
  if (const auto* error = std::get_if<can::CandumpError>(&parsed)) {
    require(error->column >= 1 && error->column <= size + 2, "an error stands in the line");
    require(!error->message.empty(), "an error says what it is");
    return 0;
  }
  const auto& line = std::get<can::CandumpLine>(parsed);
  require(line.frame.dlc <= 8, "no more than 8 data bytes");
  require(can::is_interface_name(line.interface), "the interface can be written again");
  std::array<char, can::kCandumpLineLimit> out{};
  const std::size_t length = can::write_candump_line(line.time, line.interface, line.frame, out);
  require(length > 0 && out[length - 1] == '\n', "the line is whole");
  const auto again = can::parse_candump_line({out.data(), length});
  const auto* second = std::get_if<can::CandumpLine>(&again);
  require(second != nullptr && same(line, *second), "a written line reads as the same");
  return 0;
}
