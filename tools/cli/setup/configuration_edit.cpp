#include "cli/setup/configuration_edit.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "cli/learn/configuration_text.h"
#include "config/document.h"

namespace cansync::cli {
namespace {

/// The lines of a file, and lines that are put in behind others.
class EditedLines {
 public:
  explicit EditedLines(const std::string& text) {
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) lines_.push_back(std::move(line));
  }
  /// `number` from 1.
  const std::string& line(std::uint32_t number) const { return lines_.at(number - 1); }
  void replace(std::uint32_t number, std::string line) { lines_.at(number - 1) = std::move(line); }
  void put_behind(std::uint32_t number, const std::string& line) { lines_.at(number - 1) += "\n" + line; }
  void put_at_end(const std::string& line) { lines_.push_back(line); }
  std::string text() const {
    std::string out;
    for (const std::string& line : lines_) out += line + "\n";
    return out;
  }

 private:
  std::vector<std::string> lines_;
};

/// Where the value that begins at `at` ends: a string with its closing quotation mark, or all up to the next separator. npos: it
/// does not end on this line.
std::size_t end_of_value(std::string_view line, std::size_t at) {
  if (at >= line.size()) return std::string_view::npos;
  const char quote = line[at];
  if (quote != '"' && quote != '\'') return std::min(line.find_first_of(" \t,}#", at), line.size());
  if (line.substr(at).starts_with(std::string(3, quote))) return std::string_view::npos;
  for (std::size_t i = at + 1; i < line.size(); ++i) {
    if (quote == '"' && line[i] == '\\') {
      ++i;
    } else if (line[i] == quote) {
      return i + 1;
    }
  }
  return std::string_view::npos;
}

[[noreturn]] void edit_by_hand(const config::Position& where, std::string_view what) {
  throw std::runtime_error(fmt::format(
      "line {}: this form of TOML is not edited here; nothing was written. Set `{}` there by hand, and call "
      "`cansync setup` without that answer",
      where.line, what));
}

/// Puts `value` in the place of the value of `known`, and leaves everything else of its line, such as a comment, an inline table or
/// a dotted key. Throws std::runtime_error with the line to edit by hand.
void replace_value(EditedLines& lines, const config::Node& known, std::string_view key,
                   const std::string& value) {
  const std::string& line = lines.line(known.where.line);
  const std::size_t begin = known.where.column - 1;
  const std::size_t end = end_of_value(line, begin);
  if (known.where.column == 0 || end == std::string_view::npos)
    edit_by_hand(known.key, fmt::format("{} = {}", key, toml_quoted(value)));
  lines.replace(known.where.line, line.substr(0, begin) + toml_quoted(value) + line.substr(end));
}

/// True when `line` is `[name]` or `[[name]]`, so that a line behind it belongs to that section.
bool is_heading(std::string_view line, std::string_view name) {
  const std::size_t begin = line.find_first_not_of(" \t[");
  return line.find_first_not_of(" \t") != std::string_view::npos &&
         line[line.find_first_not_of(" \t")] == '[' && begin != std::string_view::npos &&
         line.substr(begin).starts_with(name);
}

/// Sets `key` in a section: in the place of its value, else on a line of its own behind `behind`, which must stand by itself.
/// Throws std::runtime_error with the line to edit by hand.
void set_option(EditedLines& lines, const config::Content& section, std::string_view key,
                const std::string& value, const config::Position& behind, bool own_line) {
  if (const config::Node* known = section.find(key)) return replace_value(lines, *known, key, value);
  const std::string line = fmt::format("{} = {}", key, toml_quoted(value));
  if (!own_line) edit_by_hand(behind, line);
  lines.put_behind(behind.line, line);
}

/// The same for a section that may not be there.
void set_in_section(EditedLines& lines, const config::Document& document, std::string_view name,
                    std::string_view key, const std::optional<std::string>& value) {
  if (!value) return;
  const config::Node* node = config::Content(document, nullptr).find(name);
  if (node == nullptr) {
    lines.put_at_end(fmt::format("\n[{}]\n{} = {}", name, key, toml_quoted(*value)));
    return;
  }
  const config::Content section(document, node);
  if (is_heading(lines.line(section.where().line), name))
    return set_option(lines, section, key, *value, section.where(), true);
  // Of dotted keys another one may follow; an inline table has no lines of its own.
  const std::string& line = lines.line(section.where().line);
  const bool dotted = line.find('{') == std::string::npos;
  if (section.find(key) != nullptr || !dotted)
    return set_option(lines, section, key, *value, section.where(), false);
  lines.put_behind(section.where().line, fmt::format("{}.{} = {}", name, key, toml_quoted(*value)));
}

bool has_text(const config::Node* node, const std::string& text) {
  const std::string* value = node == nullptr ? nullptr : config::scalar<std::string>(node->value);
  return value != nullptr && *value == text;
}

bool has_in_section(const config::Document& document, std::string_view name, std::string_view key,
                    const std::optional<std::string>& value) {
  if (!value) return true;
  const config::Node* node = config::Content(document, nullptr).find(name);
  return node != nullptr && has_text(config::Content(document, node).find(key), *value);
}

/// Are the answers in the file? What looks like one form of TOML may be another.
bool has_answers(const std::string& text, const SetupAnswers& answers) {
  const config::Document document = config::parse_document(text, "configuration");
  if (!document.problems.empty()) return false;
  for (const config::Node* node : config::Content(document, nullptr).each("slave")) {
    const config::Content slave(document, node);
    const config::Node* number = slave.find("number");
    const auto* value = number == nullptr ? nullptr : config::scalar<std::int64_t>(number->value);
    if (value == nullptr) continue;
    const auto name = answers.names.find(static_cast<unsigned>(*value));
    if (name != answers.names.end() && !has_text(slave.find("name"), name->second)) return false;
  }
  return has_in_section(document, "sync", "output", answers.sync_output) &&
         has_in_section(document, "startup", "target", answers.target);
}

}  // namespace

std::string edited_configuration(const std::string& text, const SetupAnswers& answers) {
  const config::Document document = config::parse_document(text, "configuration");
  if (!document.problems.empty()) throw std::runtime_error(config::to_string(document.problems.front()));
  EditedLines lines(text);
  for (const config::Node* node : config::Content(document, nullptr).each("slave")) {
    const config::Content slave(document, node);
    const config::Node* number = slave.find("number");
    const auto* value = number == nullptr ? nullptr : std::get_if<std::int64_t>(&number->value.items.front());
    if (value == nullptr) continue;
    const auto name = answers.names.find(static_cast<unsigned>(*value));
    if (name == answers.names.end()) continue;
    // In an inline table the number is not at the beginning of its line.
    const std::string& line = lines.line(number->key.line);
    const bool own_line = line.find_first_not_of(" \t") + 1 == number->key.column;
    set_option(lines, slave, "name", name->second, number->key, own_line);
  }
  set_in_section(lines, document, "sync", "output", answers.sync_output);
  set_in_section(lines, document, "startup", "target", answers.target);
  std::string edited = lines.text();
  if (!has_answers(edited, answers))
    throw std::runtime_error(
        "the configuration is written in a form that is not edited here; nothing was written. Set the names of slaves, "
        "sync.output and startup.target there by hand, and call `cansync setup` without these answers");
  return edited;
}

}  // namespace cansync::cli
