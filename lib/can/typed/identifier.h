#pragma once

#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "can/frame.h"

namespace can {

/// An identifier as a person types it.
struct TypedIdentifier {
  std::uint32_t value = 0;  ///< 0..0x7FF, or 0..0x1FFFFFFF when it is extended
  bool extended = false;
};

/// What an identifier is typed like, for messages.
inline constexpr std::string_view kTypedIdentifierForm =
    "hexadecimal with or without 0x, as candump prints it: three digits (000..7FF), or eight for 29 bits (00000000..1FFFFFFF)";

/// An identifier is hexadecimal: three digits are a standard one, eight an extended one, with or without 0x; after 0x a standard
/// one may have fewer digits. Nothing for anything else, such as `80`, which may be meant as a decimal number. `mask`: eight
/// digits may be any number up to 0xFFFFFFFF. Thread-safe; does not allocate.
inline std::optional<TypedIdentifier> typed_identifier(std::string_view text, bool mask = false) noexcept {
  const bool prefix = text.starts_with("0x") || text.starts_with("0X");
  if (prefix) text.remove_prefix(2);
  const bool extended = text.size() == 8;
  const bool standard = prefix ? !text.empty() && text.size() <= 3 : text.size() == 3;
  if (!extended && !standard) return std::nullopt;
  TypedIdentifier identifier{0, extended};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), identifier.value, 16);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  const std::uint32_t largest =
      extended ? (mask ? UINT32_MAX : kExtendedIdentifierMask) : kStandardIdentifierMask;
  if (identifier.value > largest) return std::nullopt;
  return identifier;
}

/// What to tell the person of an identifier that may have been meant as a decimal number: "080 is read as hexadecimal: 0x080".
/// Empty when it has 0x, a letter or eight digits. `text` is one that `typed_identifier` accepts.
inline std::string read_as_hexadecimal(std::string_view text) {
  if (text.size() != 3 || text.find_first_not_of("0123456789") != std::string_view::npos) return "";
  return std::string(text) + " is read as hexadecimal: 0x" + std::string(text);
}

}  // namespace can
