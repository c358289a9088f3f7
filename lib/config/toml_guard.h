#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace config {

/// Most parts of a dotted key, e.g. three in `outer.inner.name`.
inline constexpr std::size_t kMostKeyParts = 16;

/// A place in a text; line and column count from 1, columns in bytes.
struct Place {
  std::size_t line = 1;
  std::size_t column = 1;
};

/// Where a TOML text has the first key of more than `kMostKeyParts` parts. toml++ up to 3.3 makes a table in
/// a table of each part and takes stack for each of them, without a limit of its own. In a text that is not
/// TOML the answer may be wrong in both directions, but no key that the parser accepts is longer.
std::optional<Place> too_deep_key(std::string_view toml);

}  // namespace config
