#pragma once

#include <map>
#include <optional>
#include <string>

/// What `setup` changes in a configuration: lines are put in, or replaced; everything else stays as it is.
namespace cansync::cli {

/// What is to stand in the configuration.
struct SetupAnswers {
  std::map<unsigned, std::string> names;   ///< by slave number; slaves that are not here stay as they are
  std::optional<std::string> sync_output;  ///< none, gpio, phc or can
  std::optional<std::string> target;       ///< setup or active
};

/// The text of the configuration with the answers in it. Throws std::runtime_error when `text` is no TOML.
std::string edited_configuration(const std::string& text, const SetupAnswers& answers);

}  // namespace cansync::cli
