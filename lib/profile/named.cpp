#include "profile/named.h"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

#include "profile/folders.h"
#include "profile/reader.h"

namespace profile {

namespace {

/// A reading that has a profile.
NamedProfile named(Reading reading) {
  NamedProfile out{std::make_shared<const Profile>(std::move(*reading.profile)), ""};
  for (const config::Problem& problem : reading.problems)
    out.left_out.push_back(config::to_string(problem) + (problem.key.starts_with("parameter.")
                                                             ? "; the parameter is left out"
                                                             : "; this is left out"));
  return out;
}

}  // namespace

NamedProfile load(const std::string& path) {
  Reading reading = read(path);
  if (reading.profile) return named(std::move(reading));
  throw std::runtime_error(config::problems_message(reading.problems));
}

NamedProfile load_typed(const std::string& name_or_path, const std::string& folder) {
  if (is_path(name_or_path)) return load(name_or_path);
  std::vector<std::string> folders = standard_folders();
  if (!folder.empty()) folders.insert(folders.begin(), folder);
  const FoundFile file = find_file(name_or_path, folders);
  if (file.path.empty()) throw std::runtime_error("--profile: " + file.problem);
  return load(file.path);
}

NamedProfile find_named(std::string_view name, std::string_view hash, const std::vector<std::string>& folders,
                        const Remedies& remedies) {
  const FoundFile file = find_file(name, folders);
  if (file.path.empty()) {
    return {nullptr, fmt::format("the daemon uses profile '{}', which is not on this computer ({}); copy its "
                                 "file from the daemon's computer, or name its folder with {}",
                                 name, file.problem, remedies.folder)};
  }
  NamedProfile found;
  try {
    found = load(file.path);
  } catch (const std::runtime_error& error) {
    return {nullptr, error.what()};
  }
  if (found.profile->hash == hash) return found;
  constexpr std::size_t kShown = 12;
  const std::string instead =
      remedies.file.empty() ? "" : fmt::format(", or give {} {} to use this one", remedies.file, file.path);
  return {
      nullptr,
      fmt::format("{} is another version of profile '{}' than the daemon uses (SHA-256 {} here, {} there); "
                  "copy the daemon's file, or reload the daemon{}",
                  file.path, name, found.profile->hash.substr(0, kShown), hash.substr(0, kShown), instead)};
}

NamedProfile from_daemon(std::string_view name, std::string_view hash, std::string_view text) {
  Reading reading = parse(text, fmt::format("profile '{}' of the daemon", name));
  if (!reading.profile) {
    return {nullptr, fmt::format("what the daemon passes on as profile '{}' is none here: {}", name,
                                 config::problems_message(reading.problems))};
  }
  if (reading.profile->hash != hash)
    return {nullptr,
            fmt::format("what the daemon passes on as profile '{}' has another SHA-256 than it says", name)};
  return named(std::move(reading));
}

}  // namespace profile
