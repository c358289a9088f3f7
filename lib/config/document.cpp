#include "config/document.h"

#include <toml++/toml.h>

#include <algorithm>
#include <cstdint>
#include <sstream>
#include <utility>
#include <variant>

#include "config/toml_guard.h"
#include "text/foreign_file.h"
#include "text/text_file.h"

namespace config {
namespace {

using Path = std::vector<Node::Step>;

Position position(const toml::source_region& region, const std::string& file) {
  return {file, region.begin.line, region.begin.column};
}

std::optional<Scalar> to_scalar(const toml::node& node) {
  if (const auto* flag = node.as_boolean()) return Scalar(flag->get());
  if (const auto* number = node.as_integer()) return Scalar(number->get());
  if (const auto* number = node.as_floating_point()) return Scalar(number->get());
  if (const auto* text = node.as_string()) return Scalar(text->get());
  return std::nullopt;
}

/// A value of a type that no option has: dates, nested or mixed lists.
Value other_value(const toml::node& node) {
  Value value;
  std::ostringstream text;
  text << "a value of type " << node.type();
  value.text = text.str();
  return value;
}

Value to_value(const toml::node& node) {
  if (std::optional<Scalar> scalar = to_scalar(node)) return scalar_value(std::move(*scalar));
  const toml::array* list = node.as_array();
  if (list == nullptr) return other_value(node);
  std::vector<Scalar> items;
  for (const toml::node& item : *list) {
    std::optional<Scalar> scalar = to_scalar(item);
    if (!scalar) return other_value(node);
    items.push_back(std::move(*scalar));
  }
  return list_value(std::move(items));
}

Problem too_deep(const Position& where, const Wording& wording) {
  return {where, "",
          "found a key of more than " + std::to_string(kMostKeyParts) +
              " parts; allowed: " + std::string(wording.allowed)};
}

/// Files of editors that save in two bytes a character: a byte order mark, or a zero beside the first one.
bool is_utf16(std::string_view content) {
  if (content.starts_with("\xFF\xFE") || content.starts_with("\xFE\xFF")) return true;
  return content.size() >= 2 && (content[0] == '\0') != (content[1] == '\0');
}

/// What the parser says, with the remedy where it speaks of bytes.
std::string parser_text(const toml::parse_error& error) {
  std::string text(error.description());
  if (text.find("utf-8") != std::string::npos) text += " (save the file as UTF-8)";
  return text;
}

/// Turns toml++'s tree into the flat list.
class Flattener {
 public:
  Flattener(Document& document, std::string file, const Wording& wording)
      : document_(document), file_(std::move(file)), wording_(wording) {}

  void table(const toml::table& table, const Path& path) {
    for (const auto& [key, node] : table) {
      Path inner = path;
      inner.push_back({std::string(key.str()), -1});
      entry(node, std::move(inner), position(key.source(), file_));
    }
  }

 private:
  void entry(const toml::node& node, Path path, const Position& key) {
    const Position where = position(node.source(), file_);
    if (path.size() > kMostKeyParts) {
      document_.problems.push_back(too_deep(key, wording_));
      return;
    }
    if (const toml::table* section = node.as_table()) {
      document_.nodes.push_back({Node::Kind::section, path, {}, key, where, {}});
      table(*section, path);
    } else if (node.is_array_of_tables()) {
      document_.nodes.push_back({Node::Kind::sections, path, {}, key, where, {}});
      sections(*node.as_array(), path);
    } else {
      document_.nodes.push_back(
          {Node::Kind::value, std::move(path), to_value(node), key, where, items(node)});
    }
  }

  std::vector<Position> items(const toml::node& node) const {
    std::vector<Position> out;
    if (const toml::array* list = node.as_array()) {
      for (const toml::node& item : *list) out.push_back(position(item.source(), file_));
    }
    return out;
  }

  void sections(const toml::array& array, Path path) {
    int index = 0;
    for (const toml::node& node : array) {
      const Position where = position(node.source(), file_);
      path.back().index = index++;
      document_.nodes.push_back({Node::Kind::section, path, {}, where, where, {}});
      table(*node.as_table(), path);
    }
  }

  Document& document_;
  std::string file_;
  const Wording& wording_;
};

}  // namespace

Document parse_document(std::string_view toml, const std::string& file, const Wording& wording) {
  Document document;
  if (is_utf16(toml)) {
    document.problems.push_back(
        {{file, 1, 1},
         "",
         std::string(wording.no_toml) +
             "the file is UTF-16; save it as UTF-8; allowed: " + std::string(wording.allowed)});
    return document;
  }
  if (const auto place = too_deep_key(toml)) {
    const Position where{file, static_cast<std::uint32_t>(place->line),
                         static_cast<std::uint32_t>(place->column)};
    document.problems.push_back(too_deep(where, wording));
    return document;
  }
  try {
    const toml::table root = toml::parse(toml, file);
    Flattener(document, file, wording).table(root, {});
    if (!document.problems.empty()) document.nodes.clear();
  } catch (const toml::parse_error& error) {
    document.nodes.clear();
    const Position where = position(error.source(), file);
    // What is of another kind altogether is already none in its first line.
    const std::string recognized = where.line <= 1 ? text::recognized_in_place_of_own(toml) : std::string();
    document.problems.push_back({where, "",
                                 std::string(wording.no_toml) +
                                     (recognized.empty() ? parser_text(error) : recognized) +
                                     "; allowed: " + std::string(wording.allowed)});
  }
  return document;
}

namespace {

/// Lines of a text, which can be made blank without moving the others.
class SectionText {
 public:
  explicit SectionText(std::string_view text) : text_(text) {
    for (std::size_t at = 0; at < text_.size();) {
      lines_.push_back(at);
      at = std::min(text_.find('\n', at), text_.size() - 1) + 1;
    }
  }

  const std::string& text() const noexcept { return text_; }

  /// The line, from 0, in which the section of `line` begins: that of its [header], or 0.
  std::size_t begin_of(std::size_t line) const {
    line = std::min(line, lines_.size() - 1);
    while (line > 0 && !is_header(line)) --line;
    return line;
  }

  /// The text without the section that begins in `line`; the same text when nothing is in it.
  SectionText without(std::size_t line) const {
    SectionText out = *this;
    std::size_t next = line + 1;
    while (next < lines_.size() && !is_header(next)) ++next;
    const std::size_t end = next < lines_.size() ? lines_[next] : text_.size();
    std::replace_if(
        out.text_.begin() + static_cast<std::ptrdiff_t>(lines_[line]),
        out.text_.begin() + static_cast<std::ptrdiff_t>(end), [](char c) { return c != '\n'; }, ' ');
    return out;
  }

 private:
  bool is_header(std::size_t line) const {
    const std::size_t at = text_.find_first_not_of(" \t", lines_[line]);
    return at != text_.npos && text_[at] == '[';
  }

  std::string text_;
  std::vector<std::size_t> lines_;  ///< where each begins
};

Document read_and_parse(const Source& source, const Wording& wording,
                        Document (*parse)(std::string_view, const std::string&, const Wording&)) {
  const std::string& file = source.path;
  if (source.text) return parse(*source.text, file, wording);
  const auto content = text::read_file(file);
  if (const auto* problem = std::get_if<text::FileProblem>(&content)) {
    return {{}, {{{file, 0, 0}, "", std::string(wording.unreadable) + problem->text}}};
  }
  return parse(std::get<std::string>(content), file, wording);
}

}  // namespace

Document parse_document_in_part(std::string_view toml, const std::string& file, const Wording& wording) {
  Document document = parse_document(toml, file, wording);
  if (document.problems.empty() || toml.empty()) return document;
  SectionText text(toml);
  std::vector<Problem> left_out;
  while (!document.problems.empty()) {
    const Problem& first = document.problems.front();
    left_out.push_back(first);
    const std::size_t line = first.where.line;
    if (line == 0 || left_out.size() > kMostDamagedSections) return {{}, std::move(left_out)};
    // What does not end shows in the header of the next section: the one without which more can be read is to
    // blame.
    const std::size_t own = text.begin_of(line - 1);
    SectionText without_own = text.without(own);
    Document rest = parse_document(without_own.text(), file, wording);
    const auto reach = [](const Document& one) {
      return one.problems.empty() ? UINT32_MAX : one.problems.front().where.line;
    };
    if (own > 0 && reach(rest) != UINT32_MAX) {
      SectionText without_previous = text.without(text.begin_of(own - 1));
      Document other = parse_document(without_previous.text(), file, wording);
      if (reach(other) > reach(rest)) {
        without_own = std::move(without_previous);
        rest = std::move(other);
      }
    }
    if (without_own.text() == text.text()) return {{}, std::move(left_out)};
    text = std::move(without_own);
    document = std::move(rest);
  }
  document.problems = std::move(left_out);
  return document;
}

Source read_source(const std::string& path) {
  auto content = text::read_file(path);
  if (auto* text = std::get_if<std::string>(&content)) return {path, std::move(*text)};
  return path;
}

Document read_document(const Source& source, const Wording& wording) {
  return read_and_parse(source, wording, parse_document);
}

Document read_document_in_part(const Source& source, const Wording& wording) {
  return read_and_parse(source, wording, parse_document_in_part);
}

std::optional<Value> parse_value(const std::string& text) {
  const Document document = parse_document("value = " + text + "\n", "");
  if (document.nodes.size() != 1 || document.nodes.front().kind != Node::Kind::value) return std::nullopt;
  return document.nodes.front().value;
}

Content::Content(const Document& document, const Node* section) {
  const std::size_t depth = section == nullptr ? 0 : section->path.size();
  if (section != nullptr) where_ = section->where;
  const std::size_t first =
      section == nullptr ? 0 : static_cast<std::size_t>(section - document.nodes.data()) + 1;
  for (std::size_t i = first; i < document.nodes.size() && document.nodes[i].path.size() > depth; ++i) {
    const Node& node = document.nodes[i];
    if (node.path.size() != depth + 1) continue;
    (node.path.back().index < 0 ? nodes_ : repeated_).push_back(&node);
  }
}

const Node* Content::find(std::string_view key) const noexcept {
  for (const Node* node : nodes_) {
    if (node->name() == key) return node;
  }
  return nullptr;
}

std::vector<const Node*> Content::each(std::string_view name) const {
  std::vector<const Node*> out;
  for (const Node* node : repeated_) {
    if (node->name() == name) out.push_back(node);
  }
  return out;
}

}  // namespace config
