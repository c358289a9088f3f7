#include "cli/record/record_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <limits>
#include <system_error>

#include "cli/base/files.h"
#include "cli/text/values.h"
#include "text/counts.h"

namespace cansync::cli {

std::uint64_t parse_size(std::string_view text, std::string_view what) {
  constexpr std::string_view kUnits = "KMG";
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const std::string_view unit = text.substr(static_cast<std::size_t>(end - text.data()));
  const std::size_t power = unit.empty() ? 0 : kUnits.find(unit.front()) + 1;
  const bool known = unit.empty() || (unit.size() == 1 && kUnits.find(unit.front()) != kUnits.npos);
  const std::uint64_t factor = std::uint64_t{1} << (10 * power % 64);
  if (error == std::errc() && known && number != 0 &&
      number <= std::numeric_limits<std::int64_t>::max() / factor)
    return number * factor;
  throw UsageError(fmt::format("{}: found '{}'; allowed: bytes such as 65536, 64K, 100M or 2G", what, text));
}

void expect_new_files(const std::string& path, const RecordBounds& bounds, bool force) {
  expect_new_file(path, "FILE", force);
  for (unsigned age = 1; age <= bounds.older; ++age)
    expect_new_file(fmt::format("{}.{}", path, age), fmt::format("FILE.{} of --rotate", age), force);
}

RecordFile::RecordFile(std::string path, std::string header, const RecordBounds& bounds)
    : path_(std::move(path)), header_(std::move(header)), bounds_(bounds) {
  constexpr std::uint64_t kLeast = 4096;
  if (bounds_.bytes != 0 && bounds_.bytes < kLeast)
    throw UsageError(fmt::format("--max-size: found {}; allowed: {} and more",
                                 text::counted(bounds_.bytes, "byte"), kLeast));
  open();
}

void RecordFile::open() {
  if (path_ != "-") {
    file_.reset(::open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
    if (!file_.is_open()) throw std::system_error(errno, std::generic_category(), path_);
  }
  size_ = 0;
  put(header_);
}

void RecordFile::put(std::string_view text) {
  if (file_.is_open())
    write_all(file_.number(), text, path_);
  else
    write_all(STDOUT_FILENO, text, "standard output");
  size_ += text.size();
}

bool RecordFile::write(std::string_view lines) {
  while (!lines.empty() && !full_) {
    // As many lines at once as there is room for.
    std::size_t length = lines.size();
    if (bounds_.bytes != 0 && size_ + length > bounds_.bytes) {
      const std::size_t first = lines.find('\n') + 1;
      if (!make_room(first)) break;
      const auto room = static_cast<std::size_t>(bounds_.bytes - size_);
      length = room >= lines.size() ? lines.size() : std::max(lines.rfind('\n', room - 1) + 1, first);
    }
    put(lines.substr(0, length));
    lines.remove_prefix(length);
  }
  return !full_;
}

bool RecordFile::make_room(std::size_t size) {
  if (size_ + size <= bounds_.bytes) return true;
  full_ = bounds_.older == 0 || header_.size() + size > bounds_.bytes;
  if (!full_) rotate();
  return !full_;
}

void RecordFile::rotate() {
  const auto name = [this](unsigned age) { return age == 0 ? path_ : fmt::format("{}.{}", path_, age); };
  for (unsigned age = bounds_.older; age > 0; --age) {
    if (std::rename(name(age - 1).c_str(), name(age).c_str()) != 0 && errno != ENOENT)
      throw std::system_error(errno, std::generic_category(), name(age - 1));
  }
  open();
}

}  // namespace cansync::cli
