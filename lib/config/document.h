#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/problem.h"
#include "config/value.h"

/// The one reader of TOML files. Allocates; main thread.
namespace config {

/// One thing in a TOML file: a section, an array of sections, or a value.
struct Node {
  enum class Kind : std::uint8_t {
    section,   ///< [section]
    sections,  ///< all [[section]] of one name together; each of them follows as a `section` with an index
    value,
  };
  /// One part of a path: its name, with the place in the array for a part of an array of sections (from 0).
  struct Step {
    std::string name;
    int index = -1;
  };
  Kind kind = Kind::value;
  std::vector<Step> path;
  Value value;                  ///< with `value`
  Position key;                 ///< where the key stands
  Position where;               ///< where the value stands
  std::vector<Position> items;  ///< where each item of a list stands

  /// The last part of the path.
  const std::string& name() const noexcept { return path.back().name; }
};

/// A TOML file as a flat list; what belongs to a section follows it, sorted by key.
struct Document {
  std::vector<Node> nodes;
  /// The file cannot be read or is not TOML; `nodes` is empty then, but with `parse_document_in_part`.
  std::vector<Problem> problems;
};

/// How the problems of a kind of file are worded. All must be literals.
struct Wording {
  std::string_view unreadable = "cannot read this file: ";
  std::string_view no_toml = "this is not TOML: ";
  std::string_view allowed = "[section], [[section]], key = value, # comment";
};

/// A file by its path, with its text when that is already there: as it was read, or as it was at another time.
struct Source {
  // Implicit: a path alone is a file that is still to be read.
  Source(std::string file) : path(std::move(file)) {}
  Source(const char* file) : path(file) {}
  Source(std::string file, std::optional<std::string> content)
      : path(std::move(file)), text(std::move(content)) {}

  std::string path;                 ///< what positions name, and relative paths in the file start from
  std::optional<std::string> text;  ///< nothing: still to be read
};

/// The file with its text as it is on disk now; without one when it cannot be read.
Source read_source(const std::string& path);

/// Reads `source`; without a text its file, a regular one of up to text::kFileLimit bytes.
Document read_document(const Source& source, const Wording& wording = {});

/// Reads TOML text; `file` is what positions name.
Document parse_document(std::string_view toml, const std::string& file, const Wording& wording = {});

/// Most sections that `parse_document_in_part` leaves out.
inline constexpr std::size_t kMostDamagedSections = 64;

/// The same of a file of which every section counts by itself: one that is not TOML is left out whole, and
/// is among the problems. Without nodes when there is nothing but damage, or more than `kMostDamagedSections`.
Document parse_document_in_part(std::string_view toml, const std::string& file, const Wording& wording = {});

/// Reads `source` so; without a text its file, as `read_document`.
Document read_document_in_part(const Source& source, const Wording& wording = {});

/// Reads one value in TOML's notation; nothing when it is none.
std::optional<Value> parse_value(const std::string& text);

/// What stands directly in one section of a document, which must outlive it.
class Content {
 public:
  /// Of the section `section`, one of the document's nodes; null: what stands in no section, and sections.
  Content(const Document& document, const Node* section);

  /// Values and sections, all [[section]] of one name as one node.
  const std::vector<const Node*>& nodes() const noexcept { return nodes_; }

  /// The node of a key; null when there is none.
  const Node* find(std::string_view key) const noexcept;

  /// Each [[section]] of the name.
  std::vector<const Node*> each(std::string_view name) const;

  /// Where the section stands; not known for what stands in no section.
  const Position& where() const noexcept { return where_; }

 private:
  std::vector<const Node*> nodes_;
  std::vector<const Node*> repeated_;
  Position where_;
};

}  // namespace config
