#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/config/value.h"

namespace cansyncd {

/// One thing in a TOML file: a section, an array of sections, or a value.
struct Node {
  enum class Kind : std::uint8_t {
    section,   ///< [bus]
    sections,  ///< all [[slave]] together; each of them follows as a `section` with an index
    value,
  };
  /// One part of a path: "slave", with the place in the array for a part of an array of sections (from 0).
  struct Step {
    std::string name;
    int index = -1;
  };
  Kind kind = Kind::value;
  std::vector<Step> path;
  Value value;     ///< with `value`
  Position key;    ///< where the key stands
  Position where;  ///< where the value stands
};

/// A TOML file as a flat list, in the order of the file; what belongs to a section follows it.
struct Document {
  std::vector<Node> nodes;
  std::vector<Problem> problems;  ///< the file cannot be read or is not TOML; `nodes` is empty then
};

/// Reads `file`, a regular file of up to text::kFileLimit bytes. Allocates; main thread.
Document read_document(const std::string& file);

/// Reads TOML text; `file` is what positions name.
Document parse_document(std::string_view toml, const std::string& file);

/// Reads one value in TOML's notation; nothing when it is none.
std::optional<Value> parse_value(const std::string& text);

}  // namespace cansyncd
