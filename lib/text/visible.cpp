#include "text/visible.h"

#include <fmt/format.h>

namespace text {

std::string visible(std::string_view text, std::string_view kept) {
  const auto is_obeyed = [&](std::size_t at) {
    const auto byte = static_cast<unsigned char>(text[at]);
    if (byte < 0x20 || byte == 0x7F) return kept.find(text[at]) == kept.npos;
    if (byte != 0xC2 || at + 1 == text.size()) return false;
    const auto second = static_cast<unsigned char>(text[at + 1]);
    return second >= 0x80 && second < 0xA0;  // C1 in UTF-8
  };
  std::string out;
  std::size_t taken = 0;
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (!is_obeyed(at)) continue;
    out += text.substr(taken, at - taken);
    if (text[at] == '\xC2') ++at;
    out += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[at]));
    taken = at + 1;
  }
  return out += text.substr(taken);
}

std::string visible_ascii(std::string_view text, std::size_t longest) {
  std::string out;
  for (const char character : text) {
    const auto byte = static_cast<unsigned char>(character);
    const bool printable = byte >= 0x20 && byte < 0x7F;
    const std::string shown = printable ? std::string(1, character) : fmt::format("\\x{:02x}", byte);
    if (out.size() + shown.size() > longest) break;
    out += shown;
  }
  return out;
}

}  // namespace text
