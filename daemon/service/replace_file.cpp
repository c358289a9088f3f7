#include "daemon/service/replace_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <string_view>
#include <system_error>

namespace cansyncd {
namespace {

/// 0, or the error number.
int write_all(int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(file, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

int write_new(const std::string& path, std::string_view text, const Replacement& how) {
  constexpr mode_t kEverybodyReads = 0644;
  // A name that somebody else may have put there, perhaps as a link, is not written through.
  if (::unlink(path.c_str()) != 0 && errno != ENOENT) return errno;
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kEverybodyReads);
  if (file < 0) return errno;
  int error = write_all(file, text);
  if (error == 0 && how.for_everybody && ::fchmod(file, kEverybodyReads) != 0) error = errno;
  if (error == 0 && how.durable && ::fsync(file) != 0) error = errno;
  // Some file systems tell only here that there was no room.
  return ::close(file) != 0 && error == 0 ? errno : error;
}

/// A name is on the disk only when its folder is. Where folders cannot be put there by themselves the file system has
/// its own way, which is no fault of the file.
int sync_folder_of(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  const int file = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) return errno == EACCES ? 0 : errno;
  const int error = ::fsync(file) != 0 && errno != EINVAL ? errno : 0;
  (void)::close(file);
  return error;
}

}  // namespace

std::optional<std::string> replace_file(const std::string& path, const std::string& text,
                                        const Replacement& how) {
  const std::string beside = path + ".new";
  int error = write_new(beside, text, how);
  if (error == 0 && std::rename(beside.c_str(), path.c_str()) != 0) error = errno;
  if (error == 0 && how.durable) error = sync_folder_of(path);
  if (error == 0) return std::nullopt;
  ::unlink(beside.c_str());
  return std::generic_category().message(error);
}

}  // namespace cansyncd
