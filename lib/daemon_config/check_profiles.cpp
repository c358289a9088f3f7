#include "daemon_config/check_profiles.h"

#include <filesystem>
#include <utility>

#include "profile/folders.h"
#include "profile/reader.h"

namespace cansyncd {

LoadedProfile ProfileFiles::load(const std::string& name_or_path, bool typed) {
  std::filesystem::path path = name_or_path;
  if (!profile::is_path(name_or_path)) {
    if (!profile::is_name(name_or_path)) {
      return {nullptr,
              "found \"" + name_or_path +
                  "\"; allowed: 1..64 lower-case letters, digits and '-', or a file with '/' or .toml",
              {}};
    }
    std::vector<std::string> folders = profile::standard_folders();
    folders.insert(folders.begin(), (std::filesystem::path(folder_) / "profiles").string());
    const profile::FoundFile found = profile::find_file(name_or_path, folders);
    if (found.path.empty()) return {nullptr, found.problem, {}};
    path = found.path;
  } else if (path.is_relative() && !typed) {
    path = std::filesystem::path(folder_) / path;
  }
  const auto [place, fresh] = read_.try_emplace(path.string(), nullptr);
  LoadedProfile loaded;
  if (fresh) {
    profile::Reading reading = profile::read(path.string());
    if (reading.profile) {
      place->second = std::make_shared<const profile::Profile>(std::move(*reading.profile));
    }
    loaded.problems = std::move(reading.problems);
  }
  loaded.profile = place->second;
  return loaded;
}

}  // namespace cansyncd
