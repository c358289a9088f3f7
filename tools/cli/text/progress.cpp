#include "cli/text/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>

namespace cansync::cli {
namespace {

constexpr unsigned kDefaultWidth = 80;

}  // namespace

unsigned terminal_width(std::FILE* file) {
  winsize size{};
  const bool known = ::ioctl(::fileno(file), TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return known ? size.ws_col : kDefaultWidth;
}

std::string progress_line(std::uint64_t done, std::uint64_t total, unsigned width) {
  const std::uint64_t counted = std::min(done, total);
  const std::uint64_t percent = total == 0 ? 100 : counted * 100 / total;
  const std::string numbers = fmt::format(" {:3d} %  {} of {} B", percent, counted, total);
  if (numbers.size() + 3 > width) return numbers.substr(1, width);
  const std::size_t inner = width - numbers.size() - 2;
  const std::size_t full = inner * percent / 100;
  return "[" + std::string(full, '#') + std::string(inner - full, '.') + "]" + numbers;
}

ProgressBar::ProgressBar(std::FILE* file) : file_(file), terminal_(::isatty(::fileno(file)) == 1) {}

ProgressBar::~ProgressBar() {
  clear();
}

void ProgressBar::clear() {
  if (drawn_) static_cast<void>(std::fputs("\r\x1b[K", file_));
  drawn_ = false;
}

void ProgressBar::update(std::uint64_t done, std::uint64_t total) {
  if (!terminal_) return;
  // The last column stays free: some terminals wrap as soon as it is written.
  const std::string line = progress_line(done, total, terminal_width(file_) - 1);
  drawn_ = true;
  static_cast<void>(std::fputs(("\r\x1b[K" + line).c_str(), file_));
  static_cast<void>(std::fflush(file_));
}

}  // namespace cansync::cli
