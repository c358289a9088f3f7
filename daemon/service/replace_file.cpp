#include "daemon/service/replace_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
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

int write_new(const std::string& path, std::string_view text) {
  constexpr mode_t kEverybodyReads = 0644;
  // A name that somebody else may have put there, perhaps as a link, is not written through.
  if (::unlink(path.c_str()) != 0 && errno != ENOENT) return errno;
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kEverybodyReads);
  if (file < 0) return errno;
  const int error = write_all(file, text);
  // Some file systems tell only here that there was no room.
  return ::close(file) != 0 && error == 0 ? errno : error;
}

}  // namespace

std::optional<std::string> replace_file(const std::string& path, const std::string& text) {
  const std::string beside = path + ".new";
  int error = write_new(beside, text);
  if (error == 0 && std::rename(beside.c_str(), path.c_str()) != 0) error = errno;
  if (error == 0) return std::nullopt;
  ::unlink(beside.c_str());
  return std::generic_category().message(error);
}

}  // namespace cansyncd
