#include <fmt/format.h>

#include <cctype>

#include "config/print.h"

namespace config {
namespace {

/// Plain text for roff: what it would take for a command, an escape or a hyphen is written as itself.
std::string plain(std::string_view text) {
  std::string out;
  if (text.starts_with('.') || text.starts_with('\'')) out += "\\&";
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool number = text[i] == '-' && i + 1 < text.size() &&
                        (std::isdigit(static_cast<unsigned char>(text[i + 1])) != 0 || text[i + 1] == '-');
    if (text[i] == '\\')
      out += "\\e";
    else if (number)
      out += "\\-";
    else
      out += text[i];
  }
  return out;
}

/// One sentence a line, as roff wants it.
std::string sentences(std::string_view text) {
  std::string out;
  for (std::size_t end = 0; (end = text.find(". ")) != std::string_view::npos; text.remove_prefix(end + 2))
    out += plain(text.substr(0, end + 1)) + "\n";
  return out + plain(text) + "\n";
}

/// What holds without the option: the default, or words without their brackets.
std::string default_of(const Option& option) {
  const std::string_view initial = option.initial;
  return plain(option.has_initial() ? initial : initial.substr(1, initial.size() - 2));
}

std::string item(const Option& option) {
  return fmt::format(".It Cm {}\n{}Allowed: {}.\nDefault: {}.\n{}", option.name(), sentences(option.help),
                     plain(allowed(option)), default_of(option),
                     option.reload ? "Changes while running.\n" : "");
}

}  // namespace

std::string options_man(const Table& table, std::string_view head) {
  std::string out(head);
  for (const Section& section : table.sections()) {
    out += fmt::format(".Ss {}\n{}", title(section), section.help.empty() ? "" : sentences(section.help));
    out += ".Bl -tag -width Ds\n";
    for (const Option& option : table.options())
      if (option.section() == section.name) out += item(option);
    out += ".El\n";
  }
  return out;
}

}  // namespace config
