#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <string_view>

/// Texts of DBC files. Main thread (allocates).
namespace cansyncd {

/// Longest identifier in a DBC file.
inline constexpr std::size_t kDbcNameLimit = 32;

/// Identifiers that are taken in one name space of a DBC file.
class DbcNames {
 public:
  /// An identifier like `wanted` (UTF-8) that is not taken yet, and takes it: 1..32 letters, digits and '_',
  /// no digit first. What does not fit becomes '_'; a number is added when the name is taken.
  std::string take(std::string_view wanted);

 private:
  std::set<std::string, std::less<>> taken_;
};

/// `utf8` as a string of a DBC file in ISO-8859-1, without its quotes: quotes become ', characters outside
/// that set and control characters '?'.
std::string dbc_string(std::string_view utf8);

}  // namespace cansyncd
