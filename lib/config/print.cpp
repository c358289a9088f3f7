#include "config/print.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <vector>

namespace config {
namespace {

constexpr std::size_t kCommentWidth = 100;

/// What holds without the option: the default, or words without their brackets.
std::string default_text(const Option& option) {
  if (option.has_initial()) return fmt::format("`{}`", option.initial);
  return std::string(option.initial.substr(1, option.initial.size() - 2));
}

/// '|' would end the table's cell.
std::string cell(std::string_view text) {
  std::string out;
  for (const char c : text) out += c == '|' ? std::string("\\|") : std::string(1, c);
  return out;
}

std::string comment(const std::string& text) {
  std::string out;
  std::string line = "#";
  std::size_t from = 0;
  while (from < text.size()) {
    const std::size_t end = std::min(text.find(' ', from), text.size());
    const std::string word = text.substr(from, end - from);
    if (line.size() + 1 + word.size() > kCommentWidth) {
      out += line + "\n";
      line = "#";
    }
    line += " " + word;
    from = end + 1;
  }
  return out + line + "\n";
}

std::string option_lines(const Option& option) {
  std::string text = std::string(option.help) + " Allowed: " + allowed(option) + ".";
  if (!option.has_initial()) text += " Default: " + default_text(option) + ".";
  if (option.numbers_section())
    return comment(text) + fmt::format("{} = {}\n", option.name(), option.minimum);
  if (option.has_initial()) return comment(text) + fmt::format("{} = {}\n", option.name(), option.initial);
  return comment(text) + fmt::format("# {} = {}\n", option.name(), option.example);
}

}  // namespace

std::string options_markdown(const Table& table, std::string_view head) {
  std::string out(head);
  for (const Section& section : table.sections()) {
    out += fmt::format("\n## {}\n", title(section));
    if (!section.help.empty()) out += fmt::format("{}\n", section.help);
    out += "\n| option | default | allowed | changes while | meaning |\n|---|---|---|---|---|\n";
    for (const Option& option : table.options()) {
      if (option.section() != section.name) continue;
      out += fmt::format("| `{}` | {} | {} | {} | {} |\n", option.name(), cell(default_text(option)),
                         cell(allowed(option)), option.reload ? "running" : "restarting", cell(option.help));
    }
  }
  return out;
}

std::string default_file(const Table& table, std::string_view head) {
  std::string out(head);
  for (const Section& section : table.sections()) {
    out += fmt::format("\n{}\n", title(section));
    if (!section.help.empty()) out += comment(std::string(section.help));
    for (const Option& option : table.options()) {
      if (option.section() == section.name) out += option_lines(option);
    }
  }
  return out;
}

}  // namespace config
