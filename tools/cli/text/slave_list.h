#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

/// Lists of slaves as a person types them. Not for the realtime thread.
namespace cansync::cli {

/// Slaves that a line can have; their numbers are 0..31.
inline constexpr unsigned kSlaves = 32;

/// What a list needs to know of the line; asked only when numbers do not tell all.
struct SlaveDirectory {
  /// Number of the slave with exactly this name; -1: nobody has it.
  std::function<int(std::string_view name)> find;
  /// Mask of the configured slaves.
  std::function<std::uint32_t()> configured;
  /// Why there is no such slave, with the names there are.
  std::function<std::string(std::string_view name)> problem;
};

/// True when numbers and ranges of numbers are all that `text` has ("3", "1,3,5-9"), right or wrong ones:
/// they are never names.
bool is_number_list(std::string_view text) noexcept;

/// Is `all`, every configured slave, in the list?
bool names_all(std::string_view text) noexcept;

/// Throws UsageError when a number or range of `text` is wrong. Asks for nothing.
void check_slave_list(std::string_view text);

/// Mask of a list of numbers 0..31, ranges of numbers, names and `all` (every configured slave), with commas
/// between ("1,3,5-9,winder"). A list or range that is a slave's name, too, is refused: a configuration takes
/// no such name, and an older daemon may have one. Numbers are checked before the directory is asked. Never
/// empty. Throws UsageError; not that a number is not configured.
std::uint32_t parse_slave_list(std::string_view text, const SlaveDirectory& directory);

/// `pattern` with `{slave}` replaced by the number and `{name}` by the name of a slave. Throws UsageError
/// when the name is wanted and has a '/', which no file name can hold.
std::string file_of_slave(std::string_view pattern, unsigned slave, std::string_view name);

/// Does the file name tell slaves apart?
bool is_file_pattern(std::string_view pattern) noexcept;

}  // namespace cansync::cli
