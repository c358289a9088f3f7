#include "cli/learn/configuration_text.h"

#include <fmt/format.h>

namespace cansync::cli {

std::string toml_boolean(bool value) {
  return value ? "true" : "false";
}

std::string toml_quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7F) continue;
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

void ConfigurationText::section(std::string_view name) {
  out_ += fmt::format("\n{}\n", name);
}

void ConfigurationText::comment(std::string_view text) {
  out_ += fmt::format("# {}\n", text);
}

void ConfigurationText::option(std::string_view key, std::string_view value, std::string_view how) {
  out_ += fmt::format("{} = {}  # {}\n", key, value, how);
}

void ConfigurationText::left_out(std::string_view key, std::string_view value, std::string_view how) {
  out_ += fmt::format("# {} = {}  # {}\n", key, value, how);
}

}  // namespace cansync::cli
