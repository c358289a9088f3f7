#include "profile/folders.h"

#include <fmt/format.h>

#include <filesystem>

namespace profile {

std::vector<std::string> standard_folders() {
  return {"/etc/cansync/profiles", "/usr/local/share/cansync/profiles", "/usr/share/cansync/profiles"};
}

bool is_path(std::string_view name_or_path) noexcept {
  return name_or_path.find('/') != std::string_view::npos || name_or_path.ends_with(".toml");
}

FoundFile find_file(std::string_view name, const std::vector<std::string>& folders) {
  std::string looked;
  for (const std::string& folder : folders) {
    const std::filesystem::path file = std::filesystem::path(folder) / (std::string(name) + ".toml");
    std::error_code error;
    if (std::filesystem::exists(file, error)) return {file.string(), ""};
    looked += (looked.empty() ? "" : ", ") + folder;
  }
  return {"", fmt::format("no profile '{}': there is no {}.toml in {}", name, name, looked)};
}

}  // namespace profile
