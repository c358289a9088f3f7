#include "text/text_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "system/descriptor.h"

namespace text {
namespace {

FileProblem system_problem() {
  return {std::generic_category().message(errno)};
}

FileProblem too_long(std::size_t most) {
  return {fmt::format("it has over {} bytes; allowed: a text file of up to {} bytes", most, most)};
}

}  // namespace

std::variant<std::string, FileProblem> read_file(const std::string& path, std::size_t most) {
  // O_NONBLOCK: opening a pipe does not wait for somebody who writes.
  const sys::Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  if (file.number() < 0) return system_problem();
  struct stat found {};
  if (::fstat(file.number(), &found) != 0) return system_problem();
  if (S_ISDIR(found.st_mode)) return FileProblem{"it is a folder"};
  if (!S_ISREG(found.st_mode)) return FileProblem{"it is a device, pipe or socket; allowed: a text file"};
  std::string content;
  if (found.st_size > static_cast<off_t>(most)) return too_long(most);
  // Files of /proc say that they are empty, and a file may grow: one byte more tells.
  content.resize(most + 1);
  std::size_t size = 0;
  while (size < content.size()) {
    const ssize_t got = ::read(file.number(), content.data() + size, content.size() - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return system_problem();
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
  }
  if (size > most) return too_long(most);
  content.resize(size);
  return content;
}

}  // namespace text
