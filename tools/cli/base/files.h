#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "system/descriptor.h"

/// What is read and written whole. Errors are std::system_error with the file's name, or UsageError.
namespace cansync::cli {

/// The bytes of a file, of standard input for "-". Throws UsageError when there are none or more than `most`.
std::vector<std::uint8_t> read_file(const std::string& path, std::size_t most);

/// Writes all of `data`, also when a signal comes while it waits for room. `name`: what an error calls the
/// file.
void write_all(int descriptor, std::string_view data, const std::string& name);

/// A file that replaces its target in one step when it is complete, and leaves no trace otherwise.
class ReplacementFile {
 public:
  /// Creates the temporary file beside `target`, so that a folder that cannot be written is noticed now.
  explicit ReplacementFile(std::string target);
  /// Removes the temporary file unless `commit` succeeded.
  ~ReplacementFile();
  ReplacementFile(const ReplacementFile&) = delete;
  ReplacementFile& operator=(const ReplacementFile&) = delete;

  /// Writes everything to disk and takes the target's place.
  void commit(std::span<const std::uint8_t> data);

 private:
  std::string target_;
  std::string temporary_;
  sys::Descriptor file_;
};

}  // namespace cansync::cli
