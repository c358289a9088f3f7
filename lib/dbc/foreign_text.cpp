#include "dbc/foreign_text.h"

#include <array>
#include <cstdint>

namespace dbc {
namespace {

/// What Windows-1252 has in 0x80..0x9F; 0: the byte itself, as ISO-8859-1 has it.
constexpr std::array<std::uint16_t, 32> kWindows1252 = {
    0x20AC, 0,      0x201A, 0x0192, 0x201E, 0x2026, 0x2020, 0x2021, 0x02C6, 0x2030, 0x0160,
    0x2039, 0x0152, 0,      0x017D, 0,      0,      0x2018, 0x2019, 0x201C, 0x201D, 0x2022,
    0x2013, 0x2014, 0x02DC, 0x2122, 0x0161, 0x203A, 0x0153, 0,      0x017E, 0x0178};

/// Bytes that a character begun by `lead` has besides; over 3: it cannot begin one.
unsigned following_bytes(unsigned char lead) noexcept {
  if (lead < 0x80) return 0;
  if (lead >= 0xC2 && lead < 0xE0) return 1;
  if (lead >= 0xE0 && lead < 0xF0) return 2;
  if (lead >= 0xF0 && lead < 0xF5) return 3;
  return 4;
}

bool is_utf8(std::string_view text) noexcept {
  for (std::size_t i = 0; i < text.size();) {
    const unsigned more = following_bytes(static_cast<unsigned char>(text[i]));
    if (more > 3 || i + more >= text.size() + (more == 0 ? 1 : 0)) return false;
    for (unsigned k = 1; k <= more; ++k)
      if ((static_cast<unsigned char>(text[i + k]) & 0xC0U) != 0x80U) return false;
    i += more + 1;
  }
  return true;
}

void add_character(std::string& out, unsigned code) {
  if (code < 0x80) {
    out += static_cast<char>(code);
  } else if (code < 0x800) {
    out += static_cast<char>(0xC0U | (code >> 6U));
    out += static_cast<char>(0x80U | (code & 0x3FU));
  } else {
    out += static_cast<char>(0xE0U | (code >> 12U));
    out += static_cast<char>(0x80U | ((code >> 6U) & 0x3FU));
    out += static_cast<char>(0x80U | (code & 0x3FU));
  }
}

}  // namespace

std::string as_utf8(std::string_view text) {
  if (is_utf8(text)) return std::string(text);
  std::string out;
  for (const char c : text) {
    const unsigned byte = static_cast<unsigned char>(c);
    const bool windows = byte >= 0x80 && byte < 0xA0 && kWindows1252[byte - 0x80] != 0;
    add_character(out, windows ? kWindows1252[byte - 0x80] : byte);
  }
  return out;
}

std::string plain_text(std::string_view text) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\\' && i + 1 < text.size() && text[i + 1] == '"') continue;
    if (c == '\r' && i + 1 < text.size() && text[i + 1] == '\n') continue;
    plain += c == '\n' || c == '\r' || c == '\t' ? ' ' : c;
  }
  return as_utf8(plain);
}

}  // namespace dbc
