#include "cli/base/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>

#include "cli/text/values.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

[[noreturn]] void fail(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), what);
}

/// True for a file with these bytes, and when there is none.
bool has_contents(const std::string& path, std::span<const std::uint8_t> data) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
  if (file == nullptr) return errno == ENOENT;
  std::array<std::uint8_t, 65536> part{};
  while (true) {
    const std::size_t count = std::fread(part.data(), 1, part.size(), file.get());
    if (count == 0) return data.empty() && std::ferror(file.get()) == 0;
    if (count > data.size() ||
        !std::equal(part.begin(), part.begin() + static_cast<std::ptrdiff_t>(count), data.begin()))
      return false;
    data = data.subspan(count);
  }
}

/// Gives a file the first name PATH.1, PATH.2, ... that is free, and returns that. At every instant the file is
/// there under one of its names.
std::string keep_file(const std::string& path) {
  for (unsigned number = 1;; ++number) {
    std::string name = fmt::format("{}.{}", path, number);
    if (::link(path.c_str(), name.c_str()) == 0) return name;
    if (errno == EEXIST) continue;
    // A file system without second names, such as that of a USB stick.
    if (::access(name.c_str(), F_OK) == 0) continue;
    if (::rename(path.c_str(), name.c_str()) == 0) return name;
    fail(name);
  }
}

/// Permissions a newly created file gets.
mode_t new_file_mode() {
  const mode_t mask = ::umask(0);
  ::umask(mask);
  return 0666 & ~mask;
}

}  // namespace

std::vector<std::uint8_t> read_file(const std::string& path, std::size_t most) {
  const bool standard_input = path == "-";
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> opened(
      standard_input ? nullptr : std::fopen(path.c_str(), "rb"), &std::fclose);
  std::FILE* file = standard_input ? stdin : opened.get();
  if (file == nullptr) fail(path);
  std::vector<std::uint8_t> data;
  std::array<std::uint8_t, 65536> part{};
  for (std::size_t count = 1; count != 0 && data.size() <= most;) {
    count = std::fread(part.data(), 1, part.size(), file);
    data.insert(data.end(), part.begin(), part.begin() + static_cast<std::ptrdiff_t>(count));
  }
  if (std::ferror(file) != 0) fail(path);
  if (data.empty()) throw UsageError(fmt::format("FILE: '{}' is empty; allowed: 1..{} bytes", path, most));
  if (data.size() > most)
    throw UsageError(fmt::format("FILE: '{}' is too long; allowed: 1..{} bytes", path, most));
  return data;
}

void expect_new_file(const std::string& path, std::string_view what, bool force) {
  struct stat found {};
  if (force || path == "-" || ::stat(path.c_str(), &found) != 0) return;
  if (!S_ISREG(found.st_mode) || found.st_size == 0) return;
  throw UsageError(
      fmt::format("{}: '{}' is there already, with {}; allowed: another name, or --force to replace it", what,
                  path, text::counted(static_cast<std::uint64_t>(found.st_size), "byte")));
}

void write_all(int descriptor, std::string_view data, const std::string& name) {
  while (!data.empty()) {
    const ssize_t written = ::write(descriptor, data.data(), data.size());
    if (written < 0 && errno != EINTR) fail(name);
    if (written > 0) data.remove_prefix(static_cast<std::size_t>(written));
  }
}

ReplacementFile::ReplacementFile(std::string target, std::optional<mode_t> mode)
    : target_(std::move(target)), temporary_(target_ + ".XXXXXX"), mode_(mode) {
  // A device or a folder must not be replaced by a file.
  struct stat found {};
  if (::stat(target_.c_str(), &found) == 0 && !S_ISREG(found.st_mode))
    throw UsageError(
        fmt::format("FILE: '{}' is no file; allowed: a file, or - for standard output", target_));
  file_.reset(::mkstemp(temporary_.data()));
  if (!file_.is_open()) fail(target_);
}

ReplacementFile::~ReplacementFile() {
  if (file_.is_open()) ::unlink(temporary_.c_str());
}

void ReplacementFile::commit(std::span<const std::uint8_t> data) {
  take_place(data, false);
}

std::string ReplacementFile::commit_and_keep(std::span<const std::uint8_t> data) {
  take_place(data, true);
  return kept_;
}

void ReplacementFile::take_place(std::span<const std::uint8_t> data, bool keep) {
  write_all(file_.number(), {reinterpret_cast<const char*>(data.data()), data.size()}, target_);
  if (::fchmod(file_.number(), mode_ ? *mode_ : new_file_mode()) != 0 || ::fsync(file_.number()) != 0)
    fail(target_);
  if (keep && !has_contents(target_, data)) kept_ = keep_file(target_);
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) fail(target_);
  file_.reset();
}

}  // namespace cansync::cli
