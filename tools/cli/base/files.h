#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
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

/// Throws UsageError when there is a file with something in it, unless `force`; `what`: the option that names
/// it. Of what is written piece by piece: the old contents could not be compared.
void expect_new_file(const std::string& path, std::string_view what, bool force);

/// A file that replaces its target in one step when it is complete, and leaves no trace otherwise.
class ReplacementFile {
 public:
  /// Creates the temporary file beside `target`, so that a folder that cannot be written is noticed now.
  /// `mode`: permissions that it gets whatever the umask; nothing: as every new file of this process.
  explicit ReplacementFile(std::string target, std::optional<mode_t> mode = std::nullopt);
  /// Removes the temporary file unless `commit` succeeded.
  ~ReplacementFile();
  ReplacementFile(const ReplacementFile&) = delete;
  ReplacementFile& operator=(const ReplacementFile&) = delete;

  /// Writes everything to disk and takes the target's place.
  void commit(std::span<const std::uint8_t> data);

  /// The same; a target of other contents is kept as TARGET.1, or the next number that is free. Returns that
  /// name; empty: there was none, or the contents are the same.
  std::string commit_and_keep(std::span<const std::uint8_t> data);

 private:
  void take_place(std::span<const std::uint8_t> data, bool keep);

  std::string target_;
  std::string temporary_;
  std::optional<mode_t> mode_;
  std::string kept_;
  sys::Descriptor file_;
};

}  // namespace cansync::cli
