#include "cli/base/child_process.h"

#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>

#include "cli/base/files.h"
#include "system/descriptor.h"

namespace cansync::cli {
namespace {

constexpr std::size_t kMostErrors = 4096;

[[noreturn]] void fail(int error, const std::string& what) {
  throw std::system_error(error, std::generic_category(), what);
}

/// A file in memory: the child can write as much as it wants without waiting for us.
class MemoryFile {
 public:
  explicit MemoryFile(const char* name) : file_(::memfd_create(name, MFD_CLOEXEC)) {
    if (!file_.is_open()) fail(errno, "memory for another program");
  }

  int descriptor() const noexcept { return file_.number(); }
  void write(std::string_view text) const {
    write_all(descriptor(), text, "memory for another program");
    ::lseek(descriptor(), 0, SEEK_SET);
  }
  std::string read() const {
    std::string out;
    std::array<char, 65536> part{};
    ::lseek(descriptor(), 0, SEEK_SET);
    for (ssize_t count = 1; count > 0;) {
      count = ::read(descriptor(), part.data(), part.size());
      if (count > 0) out.append(part.data(), static_cast<std::size_t>(count));
    }
    return out;
  }

 private:
  sys::Descriptor file_;
};

/// What the child's standard streams are.
class Streams {
 public:
  Streams(int input, int output, int errors) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_adddup2(&actions_, input, STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions_, output, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions_, errors, STDERR_FILENO);
  }
  ~Streams() { posix_spawn_file_actions_destroy(&actions_); }
  Streams(const Streams&) = delete;
  Streams& operator=(const Streams&) = delete;
  const posix_spawn_file_actions_t* get() const noexcept { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_{};
};

int wait_for(pid_t child) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0)
    if (errno != EINTR) fail(errno, "waiting for another program");
  return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

}  // namespace

ChildResult run_child(const std::vector<std::string>& arguments, const std::string& input) {
  const MemoryFile in("input");
  const MemoryFile out("output");
  const MemoryFile errors("errors");
  in.write(input);
  const Streams streams(in.descriptor(), out.descriptor(), errors.descriptor());
  std::vector<std::string> words = arguments;
  std::vector<char*> pointers;
  pointers.reserve(words.size() + 1);
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  pid_t child = 0;
  const int error = ::posix_spawnp(&child, pointers[0], streams.get(), nullptr, pointers.data(), environ);
  if (error == ENOENT) throw NoProgram(arguments[0] + ": not found");
  if (error != 0) fail(error, arguments[0]);
  ChildResult result;
  result.status = wait_for(child);
  result.output = out.read();
  result.errors = errors.read().substr(0, kMostErrors);
  return result;
}

}  // namespace cansync::cli
