#pragma once

#include <cstddef>
#include <string>
#include <string_view>

/// The files of profiles that this process has read, to be passed on as they are. Any thread; allocates.
namespace profile {

/// Files up to this many bytes are kept.
inline constexpr std::size_t kLongestSource = 65536;

/// A file; one that is longer than `kLongestSource`, or that was read before the last 64 others, without its
/// text.
struct Source {
  std::size_t size = 0;  ///< bytes; 0: not known
  std::string text;
};

/// The file with this SHA-256.
Source source_of(std::string_view hash);

/// Keeps a file for `source_of`.
void keep_source(std::string_view hash, std::string_view text);

}  // namespace profile
