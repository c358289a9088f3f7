#include "cli/setup/configuration_edit.h"

#include <fmt/format.h>

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

/// Sets `key` in a section: in the place of its line, else behind `behind`.
void set_option(EditedLines& lines, const config::Content& section, std::string_view key,
                const std::string& value, std::uint32_t behind) {
  const std::string line = fmt::format("{} = {}", key, toml_quoted(value));
  if (const config::Node* known = section.find(key))
    lines.replace(known->key.line, line);
  else
    lines.put_behind(behind, line);
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
  set_option(lines, section, key, *value, section.where().line);
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
    if (name != answers.names.end()) set_option(lines, slave, "name", name->second, number->key.line);
  }
  set_in_section(lines, document, "sync", "output", answers.sync_output);
  set_in_section(lines, document, "startup", "target", answers.target);
  return lines.text();
}

}  // namespace cansync::cli
