#pragma once

#include <string>
#include <string_view>

/// The text of a configuration of cansyncd, with a comment at each option. Pure, but for memory.
namespace cansync::cli {

/// "true" or "false".
std::string toml_boolean(bool value);

/// A text as TOML has it; what does not print is left out.
std::string toml_quoted(std::string_view text);

/// Puts a configuration together, line by line.
class ConfigurationText {
 public:
  /// "[bus]" or "[[slave]]", after an empty line.
  void section(std::string_view name);
  /// A line of comment.
  void comment(std::string_view text);
  /// An option that stands in any case, and how its value is known.
  void option(std::string_view key, std::string_view value, std::string_view how);
  /// One whose value is not known: with its default, as a comment.
  void left_out(std::string_view key, std::string_view value, std::string_view how);
  /// The text; nothing may be added afterwards.
  std::string take() { return std::move(out_); }

 private:
  std::string out_;
};

}  // namespace cansync::cli
