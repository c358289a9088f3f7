#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <string>

#include "require.h"

namespace fuzz {

/// A file in memory that can be opened by its path.
class MemoryFile {
 public:
  MemoryFile(const std::uint8_t* data, std::size_t size) : descriptor_(memfd_create("input", MFD_CLOEXEC)) {
    require(descriptor_ >= 0, "a file in memory");
    require(::write(descriptor_, data, size) == static_cast<ssize_t>(size), "it takes the input");
    path_ = "/proc/self/fd/" + std::to_string(descriptor_);
  }
  ~MemoryFile() { ::close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  const char* path() const noexcept { return path_.c_str(); }

 private:
  int descriptor_;
  std::string path_;
};

/// What a program writes to a FILE.
class MemoryOutput {
 public:
  MemoryOutput() : file_(::fdopen(memfd_create("output", MFD_CLOEXEC), "w+")) {
    require(file_ != nullptr, "a file in memory");
  }
  ~MemoryOutput() { std::fclose(file_); }
  MemoryOutput(const MemoryOutput&) = delete;
  MemoryOutput& operator=(const MemoryOutput&) = delete;

  std::FILE* file() noexcept { return file_; }
  /// All that was written, also past the FILE's buffer.
  std::string text() {
    std::fflush(file_);
    const off_t size = ::lseek(::fileno(file_), 0, SEEK_END);
    require(size >= 0, "it has a size");
    std::string out(static_cast<std::size_t>(size), '\0');
    require(::pread(::fileno(file_), out.data(), out.size(), 0) == size, "it is read back");
    return out;
  }

 private:
  std::FILE* file_;
};

}  // namespace fuzz
