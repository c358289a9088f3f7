#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <string>
#include <vector>

#include "support/long_wait.h"

/// A program under test with its output. Ends it when the test leaves it running.
class Program {
 public:
  /// Where its output goes: a pipe, or a terminal.
  enum class Output : bool { pipe, terminal };

  /// Starts `path`; `environment` is added to the test's own.
  Program(const std::string& path, std::vector<std::string> arguments,
          const std::vector<std::string>& environment = {}, Output output = Output::pipe) {
    arguments.insert(arguments.begin(), path);
    std::vector<std::string> variables = environment;
    for (char** variable = ::environ; *variable != nullptr; ++variable) variables.emplace_back(*variable);
    std::array<int, 2> ends{};
    if (output == Output::pipe) {
      EXPECT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0);
    } else {
      EXPECT_EQ(::openpty(&ends[0], &ends[1], nullptr, nullptr, nullptr), 0);
    }
    posix_spawn_file_actions_t actions;
    ::posix_spawn_file_actions_init(&actions);
    ::posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    ::posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
    EXPECT_EQ(::posix_spawn(&pid_, path.c_str(), &actions, nullptr, pointers(arguments).data(),
                            pointers(variables).data()),
              0);
    ::posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    output_ = ends[0];
  }
  ~Program() {
    if (pid_ > 0) {
      ::kill(pid_, SIGKILL);
      (void)exit_code();
    }
    ::close(output_);
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// Reads what the program writes until `text` stands anywhere in it; false when the program ends before, or
  /// has not written it after 60 s.
  bool says(const std::string& text) {
    const auto end = std::chrono::steady_clock::now() + gateway::kLongWait;
    while (text_.find(text) == std::string::npos) {
      if (std::chrono::steady_clock::now() > end || !read_more()) return false;
    }
    return true;
  }

  void signal(int number) const { ::kill(pid_, number); }

  /// Waits for the end; the exit code, or -1 when a signal ended the program.
  int exit_code() {
    while (read_more()) {
    }
    int status = 0;
    ::waitpid(pid_, &status, 0);
    pid_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  /// Everything it has written so far, standard error included.
  const std::string& text() const { return text_; }

 private:
  static std::vector<char*> pointers(std::vector<std::string>& strings) {
    std::vector<char*> out;
    out.reserve(strings.size() + 1);
    for (std::string& string : strings) out.push_back(string.data());
    out.push_back(nullptr);
    return out;
  }

  bool read_more() {
    pollfd ready{output_, POLLIN, 0};
    if (::poll(&ready, 1, static_cast<int>(std::chrono::milliseconds(gateway::kLongWait).count())) <= 0)
      return false;
    std::array<char, 4096> buffer{};
    const ssize_t count = ::read(output_, buffer.data(), buffer.size());
    if (count <= 0) return false;
    text_.append(buffer.data(), static_cast<std::size_t>(count));
    return true;
  }

  pid_t pid_ = 0;
  int output_ = -1;
  std::string text_;
};
