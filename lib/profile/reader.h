#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/problem.h"
#include "profile/profile.h"

/// Reads profiles from TOML files (docs/profiles.md). Main thread (reads files, allocates).
namespace profile {

/// Most bytes of a profile: one that names every number takes about half of it.
inline constexpr std::size_t kFileLimit = std::size_t{2} * 1024 * 1024;

/// What came of reading a profile.
struct Reading {
  std::optional<Profile> profile;         ///< nothing: it has no name, or no parameter that can be used
  std::vector<config::Problem> problems;  ///< everything that is wrong, in the order of the file
};

/// Reads TOML text; `file` is what problems name. Everything that can be wrong with a profile is found here:
/// unknown keys, types, names, numbers and names that are there twice, limits against each other and the
/// format, scaling. A parameter with a problem is left out whole: half of it would write wrong values.
Reading parse(std::string_view toml, const std::string& file);

/// Reads the regular file `path` of at most `kFileLimit` bytes. Beside what `parse` finds: a file that cannot
/// be read, and one that is not called like the profile in it.
Reading read(const std::string& path);

/// Is this a name: 1..64 lower-case letters, digits and '-', beginning with a letter?
bool is_name(std::string_view text) noexcept;

}  // namespace profile
