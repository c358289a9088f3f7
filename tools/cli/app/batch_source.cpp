#include "cli/app/batch_source.h"

#include <fmt/format.h>

#include <cerrno>
#include <system_error>

#include "cli/text/values.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

constexpr std::size_t kLongestLine = 65536;  // bytes
constexpr std::size_t kMostLines = 100000;   // of a file; standard input may go on

}  // namespace

BatchSource::BatchSource(const std::string& path)
    : path_(path), file_(path == "-" ? stdin : std::fopen(path.c_str(), "re")) {
  if (file_ == nullptr) throw std::system_error(errno, std::generic_category(), path);
}

BatchSource::~BatchSource() {
  if (file_ != stdin) static_cast<void>(std::fclose(file_));
}

std::optional<std::string> BatchSource::next() {
  std::string line;
  int c = 0;
  errno = 0;
  while ((c = std::fgetc(file_)) != EOF && c != '\n') {
    if (line.size() == kLongestLine)
      throw UsageError(fmt::format("{}:{}: the line is too long; allowed: {}", path_, number_ + 1,
                                   text::counted(kLongestLine, "byte")));
    line += static_cast<char>(c);
  }
  if (std::ferror(file_) != 0) {
    if (errno == EINTR) return std::nullopt;  // Ctrl-C
    throw std::system_error(errno, std::generic_category(), path_);
  }
  if (c == EOF && line.empty()) return std::nullopt;
  ++number_;
  if (file_ != stdin && number_ > kMostLines)
    throw UsageError(fmt::format("{}: too many lines; allowed: {}", path_, kMostLines));
  return line;
}

}  // namespace cansync::cli
