#include "text/unit_name.h"

#include <fmt/format.h>

#include <algorithm>

namespace text {
namespace {

bool is_alphanumeric(char c) noexcept {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

}  // namespace

std::string unit_instance(std::string_view name) {
  std::string out;
  for (const char c : name) {
    // A name that begins with a dot would be that of a hidden file.
    const bool stays = is_alphanumeric(c) || c == ':' || c == '_' || (c == '.' && !out.empty());
    if (c == '/')
      out += '-';
    else if (stays)
      out += c;
    else
      out += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
  }
  return out;
}

std::string shell_word(std::string_view word) {
  constexpr std::string_view kPlain = "%+,-./:=@_";
  const bool plain = !word.empty() && std::all_of(word.begin(), word.end(), [&](char c) {
    return is_alphanumeric(c) || kPlain.find(c) != std::string_view::npos;
  });
  if (plain) return std::string(word);
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

}  // namespace text
