#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "system/descriptor.h"

namespace cansync::cli {

/// How large a recording may become.
struct RecordBounds {
  std::uint64_t bytes = 0;  ///< of each file; 0: no bound
  unsigned older = 0;       ///< files that are kept when the newest is full; 0: the recording ends then
};

/// "64M": bytes, with K, M or G for 1024, 1024^2, 1024^3. Throws UsageError.
std::uint64_t parse_size(std::string_view text, std::string_view what);

/// Throws UsageError when `path`, or one of the older files that the recording would replace, is there with
/// something in it, unless `force`.
void expect_new_files(const std::string& path, const RecordBounds& bounds, bool force);

/// The file of a recording, written as rows come, so that what is there survives whatever ends this program.
/// Older ones are FILE.1 (the newest of them), FILE.2 and so on; each begins with the header. Main thread
/// only.
class RecordFile {
 public:
  /// `path`: "-" is standard output. Throws std::system_error.
  RecordFile(std::string path, std::string header, const RecordBounds& bounds);

  /// Whole lines. False: there is no room for them all, and nothing more is taken. Throws std::system_error.
  bool write(std::string_view lines);

 private:
  void open();
  void put(std::string_view text);
  /// Makes room for one line of this size. False: none is left.
  bool make_room(std::size_t size);
  void rotate();

  std::string path_;
  std::string header_;
  RecordBounds bounds_;
  sys::Descriptor file_;  ///< none: standard output
  std::uint64_t size_ = 0;
  bool full_ = false;
};

}  // namespace cansync::cli
