#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

/// Progress of a transfer for a person who waits.
namespace cansync::cli {

/// Columns of the terminal behind `file`; 80 when it is none.
unsigned terminal_width(std::FILE* file);

/// One line of `width` characters at most: bar, percentage and bytes. `total` 0 counts as done.
std::string progress_line(std::uint64_t done, std::uint64_t total, unsigned width);

/// A bar that is redrawn in one line; says nothing when `file` is no terminal.
class ProgressBar {
 public:
  explicit ProgressBar(std::FILE* file);
  /// Takes the bar away.
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void update(std::uint64_t done, std::uint64_t total);
  /// Takes the bar away until the next `update`, so that other lines find an empty one.
  void clear();

 private:
  std::FILE* file_;
  bool terminal_;
  bool drawn_ = false;
};

}  // namespace cansync::cli
