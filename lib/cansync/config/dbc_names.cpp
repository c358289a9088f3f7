#include "cansync/config/dbc_names.h"

#include <fmt/format.h>

#include <algorithm>

namespace cansyncd {
namespace {

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}
bool is_digit(char c) {
  return c >= '0' && c <= '9';
}
bool continues(char c) {
  return (static_cast<unsigned char>(c) & 0xC0) == 0x80;
}

}  // namespace

std::string DbcNames::take(std::string_view wanted) {
  std::string base;
  for (const char c : wanted) {
    if (continues(c)) continue;  // one '_' for a character of several bytes
    base += is_letter(c) || is_digit(c) ? c : '_';
  }
  if (base.empty() || is_digit(base.front())) base.insert(0, 1, '_');
  base.resize(std::min(base.size(), kDbcNameLimit));
  std::string name = base;
  for (unsigned number = 2; taken_.contains(name); ++number) {
    const std::string suffix = fmt::format("_{}", number);
    name = base.substr(0, kDbcNameLimit - suffix.size()) + suffix;
  }
  taken_.insert(name);
  return name;
}

std::string dbc_string(std::string_view utf8) {
  std::string out;
  for (std::size_t i = 0; i < utf8.size(); ++i) {
    const auto c = static_cast<unsigned char>(utf8[i]);
    const bool pair = (c == 0xC2 || c == 0xC3) && i + 1 < utf8.size() && continues(utf8[i + 1]);
    if (pair) {
      const auto low = static_cast<unsigned char>(utf8[++i]);
      const int character = ((c & 0x03) << 6) | (low & 0x3F);
      out += character < 0xA0 ? '?' : static_cast<char>(character);
    } else if (c == '"') {
      out += '\'';
    } else if (c >= 0x20 && c < 0x7F) {
      // A reader may take a backslash for the beginning of an escape.
      out += c == '\\' ? '/' : static_cast<char>(c);
    } else if (!continues(utf8[i])) {
      out += '?';
    }
  }
  return out;
}

}  // namespace cansyncd
