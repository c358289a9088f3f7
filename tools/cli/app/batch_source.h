#pragma once

#include <cstdio>
#include <memory>
#include <optional>
#include <string>

namespace cansync::cli {

/// The lines of a file, one after the other. Main thread only.
class BatchSource {
 public:
  /// `path`: "-" is standard input. Throws std::system_error when it cannot be opened.
  explicit BatchSource(const std::string& path);
  ~BatchSource();
  BatchSource(const BatchSource&) = delete;
  BatchSource& operator=(const BatchSource&) = delete;

  /// The next line without its end, as soon as it is there; nothing at the end, or at Ctrl-C. Throws
  /// std::system_error, and UsageError for a line of more than 64 KiB or a file of more than 100000 lines.
  std::optional<std::string> next();
  /// Number of the line that `next` gave last, from 1.
  std::size_t number() const noexcept { return number_; }

 private:
  std::string path_;
  std::FILE* file_;
  std::size_t number_ = 0;
};

}  // namespace cansync::cli
