#include "cli/base/afterwards.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <string_view>
#include <system_error>

namespace cansync::cli {
namespace {

/// A word as the shell takes it.
std::string quoted_word(const std::string& word) {
  std::string out = "'";
  for (const char one : word) out += one == '\'' ? std::string("'\\''") : std::string(1, one);
  return out + "'";
}

std::string script_of(const std::vector<std::vector<std::string>>& commands) {
  std::string out = "read -r over || {\n";
  for (const auto& words : commands) {
    for (const std::string& word : words) out += quoted_word(word) + " ";
    out += "\n";
  }
  return out + "}";
}

}  // namespace

Afterwards::Afterwards(const std::vector<std::vector<std::string>>& commands) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
  const sys::Descriptor read(ends[0]);
  end_.reset(ends[1]);
  posix_spawn_file_actions_t actions{};
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, read.number(), STDIN_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawnattr_t attributes{};
  posix_spawnattr_init(&attributes);
  // What the terminal sends to this process does not reach it.
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);
  std::string shell = "sh";
  std::string option = "-c";
  std::string script = script_of(commands);
  std::array<char*, 4> words{shell.data(), option.data(), script.data(), nullptr};
  const int error = ::posix_spawnp(&shell_, shell.c_str(), &actions, &attributes, words.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw std::system_error(error, std::generic_category(), shell);
}

Afterwards::~Afterwards() {
  constexpr std::string_view kOver = "over\n";
  // A shell that has ended has run nothing: it reads until then.
  if (::write(end_.number(), kOver.data(), kOver.size()) < 0) return;
  int status = 0;
  while (::waitpid(shell_, &status, 0) < 0 && errno == EINTR) continue;
}

}  // namespace cansync::cli
