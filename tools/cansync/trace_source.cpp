#include "cansync/trace_source.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <optional>
#include <system_error>
#include <utility>

namespace cansync::cli {
namespace {

constexpr int kLookMs = 50;

/// A text log, read without ever holding more than one line.
class LogSource final : public TraceSource {
 public:
  explicit LogSource(const std::string& path) : path_(path) {
    descriptor_ = path == "-" ? STDIN_FILENO : ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor_ < 0) throw std::system_error(errno, std::generic_category(), path);
  }
  ~LogSource() override {
    if (descriptor_ > STDIN_FILENO) ::close(descriptor_);
  }
  LogSource(const LogSource&) = delete;
  LogSource& operator=(const LogSource&) = delete;

  TraceItem next() override {
    for (;;) {
      for (; at_ < size_; ++at_) {
        const char c = buffer_[at_];
        if (c != '\n') {
          if (line_.size() < kLongestTraceLine)
            line_ += c;
          else
            too_long_ = true;
          continue;
        }
        ++at_;
        if (auto item = take_line()) return std::move(*item);
        break;  // a line without content: go on with what is left of the buffer
      }
      if (at_ < size_) continue;
      if (ended_) return TraceEnd{};
      if (!fill()) return TraceNothing{};
      if (!ended_) continue;
      if (auto item = take_line()) return std::move(*item);
      return TraceEnd{};
    }
  }

 private:
  /// False: nothing came for a moment.
  bool fill() {
    pollfd ready{descriptor_, POLLIN, 0};
    const int count = ::poll(&ready, 1, kLookMs);
    if (count == 0 || (count < 0 && errno == EINTR)) return false;
    const ssize_t got = ::read(descriptor_, buffer_.data(), buffer_.size());
    if (got < 0 && errno == EINTR) return false;
    if (got < 0) throw std::system_error(errno, std::generic_category(), path_);
    at_ = 0;
    size_ = static_cast<std::size_t>(got);
    ended_ = got == 0;
    return true;
  }

  /// What the finished line says; nothing for an empty one.
  std::optional<TraceItem> take_line() {
    std::string line = std::exchange(line_, {});
    const bool too_long = std::exchange(too_long_, false);
    if (line.empty() && ended_) return std::nullopt;
    ++number_;
    if (too_long) return TraceProblem{fmt::format("line {}: over {} characters", number_, kLongestTraceLine)};
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty()) return std::nullopt;
    if (line.front() == '#') return TraceRemark{fmt::format("line {}: {}", number_, printable(line))};
    auto parsed = can::parse_candump_line(line);
    if (auto* frame = std::get_if<can::CandumpLine>(&parsed)) return std::move(*frame);
    const auto& error = std::get<can::CandumpError>(parsed);
    return TraceProblem{
        fmt::format("line {}, column {}: {}", number_, error.column, printable(error.message))};
  }

  /// Without what would confuse a terminal.
  static std::string printable(std::string text) {
    for (char& c : text)
      if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7F) c = '?';
    return text;
  }

  std::string path_;
  int descriptor_ = -1;
  std::array<char, 65536> buffer_{};
  std::size_t at_ = 0;
  std::size_t size_ = 0;
  bool ended_ = false;
  std::string line_;
  bool too_long_ = false;
  std::uint64_t number_ = 0;
};

}  // namespace

std::unique_ptr<TraceSource> open_log(const std::string& path) {
  return std::make_unique<LogSource>(path);
}

}  // namespace cansync::cli
