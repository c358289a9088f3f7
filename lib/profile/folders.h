#pragma once

#include <string>
#include <string_view>
#include <vector>

/// Where profiles are looked for. Main thread (looks at files, allocates).
namespace profile {

/// Folders of every program, in this order: /etc/cansync/profiles, /usr/local/share/cansync/profiles,
/// /usr/share/cansync/profiles.
std::vector<std::string> standard_folders();

/// Is this the path of a file (with '/' or ending in ".toml"), and not the name of a profile?
bool is_path(std::string_view name_or_path) noexcept;

/// A file, or why there is none.
struct FoundFile {
  std::string path;
  std::string problem;  ///< names every folder that was looked into; empty when found
};

/// The first `FOLDER/NAME.toml` that is there.
FoundFile find_file(std::string_view name, const std::vector<std::string>& folders);

}  // namespace profile
