#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "profile/profile.h"

/// Reads profiles from TOML files (docs/profiles.md). Main thread (reads files, allocates).
namespace profile {

/// Most bytes of a profile: one that names every number takes about half of it.
inline constexpr std::size_t kFileLimit = std::size_t{2} * 1024 * 1024;

/// Something wrong with a profile, in words that name what was found and what is allowed.
struct Problem {
  std::size_t line = 0;  ///< from 1; 0: the file as a whole
  std::size_t column = 0;
  std::string key;  ///< e.g. "parameter.name"; empty when no key is concerned
  std::string text;
};

/// What came of reading a profile: a profile, or everything that is wrong with it in the order of the file.
struct Reading {
  std::optional<Profile> profile;
  std::vector<Problem> problems;
};

/// Reads TOML text. Everything that can be wrong with a profile is found here: unknown keys, types, names,
/// numbers and names that are there twice, limits against each other and the format, scaling.
Reading parse(std::string_view toml);

/// Reads the regular file `path` of at most `kFileLimit` bytes. Beside what `parse` finds: a file that cannot
/// be read, and one that is not called like the profile in it.
Reading read(const std::string& path);

/// The problems for people, one a line as "FILE:LINE:COLUMN: KEY: TEXT", at most 20 and then how many more.
std::string problems_text(const std::vector<Problem>& problems, std::string_view file);

/// Is this a name: 1..64 lower-case letters, digits and '-', beginning with a letter?
bool is_name(std::string_view text) noexcept;

}  // namespace profile
