#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "profile/profile.h"

/// Drive passports: the values of a drive's parameters as text (docs/passport.md). Pure functions, but for
/// memory.
namespace profile {

/// One parameter of a passport. What the profile says of it is written down too, so that files can be
/// compared without it.
struct PassportEntry {
  std::uint16_t number = 0;
  std::string name;
  Format format = Format::word;
  std::optional<std::uint32_t> raw;  ///< nothing: volatile ones, and what could not be read
  std::string value;                 ///< in engineering units; empty without `raw`
  std::string unit;
  bool read_only = false;
  bool is_volatile = false;
  Identity identity = Identity::none;
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
PassportEntry passport_entry(const Parameter& parameter, std::optional<std::uint32_t> raw);

/// The passport's file: the same values give the same text, and one changed value changes one line beside the
/// checksum.
std::string passport_text(const Passport& passport);

/// What came of reading a passport.
struct PassportReading {
  std::optional<Passport> passport;
  bool changed = false;  ///< the checksum is missing or does not fit: it is not as it was written
  std::size_t line = 0;  ///< of the problem, from 1
  std::string problem;   ///< why it is no passport; empty otherwise
  /// "LINE: what is wrong; the line is left out", at most kMostLeftOut; with one it counts as changed.
  std::vector<std::string> left_out;
  std::size_t more_left_out = 0;  ///< that are not kept
};

/// Most lines that are left out one by one.
inline constexpr std::size_t kMostLeftOut = 1000;

/// Reads a passport's text. A line that cannot be read is left out, and both lines of a parameter that is there
/// twice with different values; without bus, slave, profile or any parameter it is no passport.
PassportReading parse_passport(std::string_view content);

/// Most bytes of a passport; one with every number has a third.
inline constexpr std::size_t kPassportLimit = std::size_t{2} * 1024 * 1024;

/// The passport in `path`, with one whatever it says. Throws std::runtime_error with file and line when it is none.
PassportReading read_passport(const std::string& path);

}  // namespace profile
