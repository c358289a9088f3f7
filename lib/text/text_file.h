#pragma once

#include <cstddef>
#include <string>
#include <variant>

/// Reading of files that people write.
namespace text {

/// Most bytes of a configuration or fault script; the longest one with every option of 32 slaves has a
/// fourth.
inline constexpr std::size_t kFileLimit = std::size_t{256} * 1024;

/// Why a file was not read, in words: what was found, and what is allowed where that helps.
struct FileProblem {
  std::string text;
};

/// The content of the regular file `path` with at most `most` bytes. Neither blocks (a pipe nobody writes
/// to) nor reads without end (a device). Allocates; not for the realtime thread.
std::variant<std::string, FileProblem> read_file(const std::string& path, std::size_t most = kFileLimit);

}  // namespace text
