#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "profile/profile.h"

/// The profile that a daemon names for a slave, on this computer. Reads files, allocates.
namespace profile {

/// A profile, or why there is none.
struct NamedProfile {
  std::shared_ptr<const Profile> profile;  ///< null: none
  std::string problem;                     ///< with a remedy; empty when there is one
  /// "FILE:LINE:COLUMN: what is wrong, and what is left out for it"; empty: nothing is.
  std::vector<std::string> left_out = {};
};

/// How a program's users help themselves, for problems.
struct Remedies {
  std::string_view folder;  ///< names a folder of profiles, e.g. "--profiles"
  std::string_view file;    ///< takes a file whatever the daemon uses, e.g. "--profile"; empty: nothing does
};

/// Reads the file. Throws std::runtime_error that names everything wrong with it when nothing can be used.
NamedProfile load(const std::string& path);

/// The profile of a name, in `folder` (empty: none) or a standard one, or of a file. Throws
/// std::runtime_error that names everything wrong with it when nothing can be used, or where it was looked for.
NamedProfile load_typed(const std::string& name_or_path, const std::string& folder);

/// The profile `name` in the first of `folders` that has it; a problem when its file is not the one whose
/// SHA-256 is `hash`.
NamedProfile find_named(std::string_view name, std::string_view hash, const std::vector<std::string>& folders,
                        const Remedies& remedies);

/// The profile that a daemon passes on: `text` is its file. A problem when that is not what `hash` says, or
/// is no profile.
NamedProfile from_daemon(std::string_view name, std::string_view hash, std::string_view text);

}  // namespace profile
