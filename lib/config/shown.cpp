#include "config/shown.h"

#include <fmt/format.h>

#include "text/counts.h"

namespace config {

std::string shown(std::string_view text) {
  constexpr std::size_t kLongest = 80;
  if (text.size() <= kLongest) return std::string(text);
  std::size_t end = kLongest - 20;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0u) == 0x80u) --end;
  return fmt::format("{}... ({})", text.substr(0, end), text::counted(text.size(), "byte"));
}

}  // namespace config
