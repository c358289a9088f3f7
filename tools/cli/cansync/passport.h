#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "profile/profile.h"

/// Drive passports: the values of a drive's parameters as text (docs/passport.md). Pure functions, but for
/// memory.
namespace cansync::cli {

/// One parameter of a passport. What the profile says of it is written down too, so that files can be
/// compared without it.
struct PassportEntry {
  std::uint16_t number = 0;
  std::string name;
  profile::Format format = profile::Format::word;
  std::optional<std::uint32_t> raw;  ///< nothing: volatile ones, and what could not be read
  std::string value;                 ///< in engineering units; empty without `raw`
  std::string unit;
  bool read_only = false;
  bool is_volatile = false;
  profile::Identity identity = profile::Identity::none;
  friend bool operator==(const PassportEntry&, const PassportEntry&) = default;
};

/// The values of one drive.
struct Passport {
  std::string bus;
  unsigned slave = 0;  ///< 0..31
  std::string slave_name;
  std::string profile;
  std::string profile_hash;            ///< SHA-256 of the profile's file
  std::string taken;                   ///< when, as UTC text; empty: not written down
  std::vector<PassportEntry> entries;  ///< by rising number, each number once
  friend bool operator==(const Passport&, const Passport&) = default;

  /// The entry of this number; null when there is none.
  const PassportEntry* find(std::uint32_t number) const noexcept;
};

/// An entry of a parameter with this value (nothing: none).
PassportEntry passport_entry(const profile::Parameter& parameter, std::optional<std::uint32_t> raw);

/// The passport's file: the same values give the same text, and one changed value changes one line beside the
/// checksum.
std::string passport_text(const Passport& passport);

/// What came of reading a passport.
struct PassportReading {
  std::optional<Passport> passport;
  bool changed = false;  ///< the checksum does not fit: somebody has changed the file since it was written
  std::size_t line = 0;  ///< of the problem, from 1
  std::string problem;   ///< why it is no passport; empty otherwise
};

/// Reads a passport's text.
PassportReading parse_passport(std::string_view text);

/// Most bytes of a passport; one with every number has a third.
inline constexpr std::size_t kPassportLimit = std::size_t{2} * 1024 * 1024;

/// The passport in `path`. Throws std::runtime_error with file and line when it is none. `changed` says that
/// its checksum does not fit.
Passport read_passport(const std::string& path, bool& changed);

}  // namespace cansync::cli
