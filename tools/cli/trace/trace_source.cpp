#include "cli/trace/trace_source.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

#include "can/pcapng_reader.h"
#include "system/descriptor.h"

namespace cansync::cli {
namespace {

constexpr int kLookMs = 50;
constexpr std::size_t kFirstBytes = 4;  ///< that tell which kind of file it is

/// Makes items of a file's bytes.
class TraceReader {
 public:
  TraceReader() = default;
  virtual ~TraceReader() = default;
  TraceReader(const TraceReader&) = delete;
  TraceReader& operator=(const TraceReader&) = delete;
  virtual void feed(std::string_view bytes) = 0;
  /// The next item; nothing: feed more.
  virtual std::optional<TraceItem> next() = 0;
  /// What the bytes after the last item say; called once, at the end of the file.
  virtual std::optional<TraceItem> finish() = 0;
};

/// A text log, read without ever holding more than one line and what was fed last.
class LogReader final : public TraceReader {
 public:
  void feed(std::string_view bytes) override {
    bytes_.erase(0, at_);
    at_ = 0;
    bytes_ += bytes;
  }

  std::optional<TraceItem> next() override {
    while (at_ < bytes_.size()) {
      const char c = bytes_[at_++];
      if (c == '\n') {
        if (auto item = take_line()) return item;
      } else if (line_.size() < kLongestTraceLine) {
        line_ += c;
      } else {
        too_long_ = true;
      }
    }
    return std::nullopt;
  }

  std::optional<TraceItem> finish() override {
    if (line_.empty()) return std::nullopt;
    return take_line();
  }

 private:
  /// What the finished line says; nothing for an empty one.
  std::optional<TraceItem> take_line() {
    std::string line = std::exchange(line_, {});
    const bool too_long = std::exchange(too_long_, false);
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

  std::string bytes_;
  std::size_t at_ = 0;
  std::string line_;
  bool too_long_ = false;
  std::uint64_t number_ = 0;
};

/// A pcapng capture.
class CaptureReader final : public TraceReader {
 public:
  void feed(std::string_view bytes) override {
    if (!stopped_) reader_.feed(bytes);
  }

  std::optional<TraceItem> next() override {
    auto item = reader_.next();
    if (!item) return std::nullopt;
    if (auto* line = std::get_if<can::CandumpLine>(&*item)) return std::move(*line);
    auto& error = std::get<can::PcapngError>(*item);
    stopped_ = stopped_ || error.fatal;
    return TraceProblem{std::move(error.message)};
  }

  std::optional<TraceItem> finish() override {
    if (stopped_ || reader_.unfinished() == 0) return std::nullopt;
    return TraceProblem{"the capture ends in the middle of a block"};
  }

 private:
  can::PcapngReader reader_;
  bool stopped_ = false;
};

/// A file of either kind; its first bytes tell which.
class FileSource final : public TraceSource {
 public:
  explicit FileSource(const std::string& path) : path_(path) {
    if (path == "-") return;
    file_.reset(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (!file_.is_open()) throw std::system_error(errno, std::generic_category(), path);
  }

  TraceItem next() override {
    for (;;) {
      if (reader_) {
        if (auto item = reader_->next()) return std::move(*item);
      }
      if (finished_) return TraceEnd{};
      if (ended_) {
        finished_ = true;
        if (auto item = reader_->finish()) return std::move(*item);
        continue;
      }
      if (!read_on()) return TraceNothing{};
    }
  }

 private:
  /// False: nothing came for a moment.
  bool read_on() {
    const int descriptor = file_.is_open() ? file_.number() : STDIN_FILENO;
    pollfd ready{descriptor, POLLIN, 0};
    const int count = ::poll(&ready, 1, kLookMs);
    if (count == 0 || (count < 0 && errno == EINTR)) return false;
    const ssize_t got = ::read(descriptor, buffer_.data(), buffer_.size());
    if (got < 0 && errno == EINTR) return false;
    if (got < 0) throw std::system_error(errno, std::generic_category(), path_);
    ended_ = got == 0;
    first_.append(buffer_.data(), static_cast<std::size_t>(got));
    if (!reader_ && (ended_ || first_.size() >= kFirstBytes)) {
      if (can::is_pcapng(first_))
        reader_ = std::make_unique<CaptureReader>();
      else
        reader_ = std::make_unique<LogReader>();
    }
    if (reader_) reader_->feed(std::exchange(first_, {}));
    return true;
  }

  std::string path_;
  sys::Descriptor file_;  ///< none: standard input
  std::array<char, 65536> buffer_{};
  std::string first_;  ///< read, and not yet handed to the reader
  bool ended_ = false;
  bool finished_ = false;
  std::unique_ptr<TraceReader> reader_;
};

}  // namespace

std::unique_ptr<TraceSource> open_log(const std::string& path) {
  return std::make_unique<FileSource>(path);
}

bool is_trace_file(const std::string& source) {
  std::error_code ignored;
  return source == "-" || source.find('/') != std::string::npos || std::filesystem::exists(source, ignored);
}

std::unique_ptr<TraceSource> open_trace_source(const std::string& source, std::uint32_t sync,
                                               HeardFrames frames) {
  std::error_code ignored;
  const bool file = is_trace_file(source);
  if (!file && !std::filesystem::exists("/sys/class/net/" + source, ignored)) {
    throw std::runtime_error(
        source +
        ": there is no such file here, and no such interface; `ip -br link show type can` "
        "lists those there are");
  }
  return file ? open_log(source) : open_interface(source, sync, frames);
}

}  // namespace cansync::cli
