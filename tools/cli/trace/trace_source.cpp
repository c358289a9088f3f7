#include "cli/trace/trace_source.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
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
#include "cli/trace/frame_twins.h"
#include "system/descriptor.h"
#include "text/foreign_file.h"
#include "text/visible.h"

namespace cansync::cli {
namespace {

constexpr int kLookMs = 50;
constexpr std::size_t kShortestBeginning = 4;  ///< of a pcapng capture, which has ends of lines in it
constexpr std::size_t kFirstBytes = 64;  ///< that tell which kind of file it is; a complete line does, too

/// Makes items of the bytes of the file `name`.
class TraceReader {
 public:
  explicit TraceReader(std::string name) : name_(std::move(name)) {}
  virtual ~TraceReader() = default;
  TraceReader(const TraceReader&) = delete;
  TraceReader& operator=(const TraceReader&) = delete;
  virtual void feed(std::string_view bytes) = 0;
  /// The next item; nothing: feed more.
  virtual std::optional<TraceItem> next() = 0;
  /// What the bytes after the last item say; called once, at the end of the file.
  virtual std::optional<TraceItem> finish() = 0;
  /// Where the last item is: "line 7".
  virtual std::string place() const = 0;

 protected:
  const std::string name_;
};

/// A text log, read without ever holding more than one line and what was fed last.
class LogReader final : public TraceReader {
 public:
  using TraceReader::TraceReader;

  void feed(std::string_view bytes) override {
    bytes_.erase(0, at_);
    at_ = 0;
    bytes_ += bytes;
  }

  std::optional<TraceItem> next() override {
    for (std::size_t end = bytes_.find('\n', at_); end != bytes_.npos; end = bytes_.find('\n', at_)) {
      const std::string_view line = std::string_view(bytes_).substr(at_, end - at_);
      at_ = end + 1;
      if (auto item = take_line(line)) return item;
    }
    if (bytes_.size() - at_ > kLongestTraceLine) {
      too_long_ = true;
      at_ = bytes_.size();
    }
    return std::nullopt;
  }

  std::optional<TraceItem> finish() override {
    const std::string_view line = std::string_view(bytes_).substr(at_);
    if (line.empty() && !too_long_) return std::nullopt;
    return take_line(line);
  }

  std::string place() const override { return fmt::format("line {}", number_); }

 private:
  /// What the finished line says; nothing for an empty one.
  std::optional<TraceItem> take_line(std::string_view line) {
    const bool too_long = std::exchange(too_long_, false) || line.size() > kLongestTraceLine;
    ++number_;
    if (number_ == 1) line = text::without_mark(line);
    if (too_long)
      return TraceProblem{fmt::format("{}:{}: over {} characters", name_, number_, kLongestTraceLine)};
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (line.empty()) return std::nullopt;
    if (line.front() == '#')
      return TraceRemark{
          fmt::format("{}:{}: {}", name_, number_, text::visible_ascii(line, kLongestTraceLine))};
    // What `candump -e` says of an error frame on a screen, below it.
    if (after_error_ && line.front() == '\t') return std::nullopt;
    auto parsed = can::parse_candump_line(line);
    if (auto* frame = std::get_if<can::CandumpLine>(&parsed)) {
      after_error_ = frame->frame.error;
      return std::move(*frame);
    }
    const auto& error = std::get<can::CandumpError>(parsed);
    return TraceProblem{fmt::format("{}:{}:{}: {}", name_, number_, error.column,
                                    text::visible_ascii(error.message, kLongestTraceLine))};
  }

  std::string bytes_;
  std::size_t at_ = 0;        ///< of the first line that was not taken yet
  bool too_long_ = false;     ///< the beginning of this line was dropped
  bool after_error_ = false;  ///< the last frame was an error frame
  std::uint64_t number_ = 0;
};

/// A pcapng capture.
class CaptureReader final : public TraceReader {
 public:
  using TraceReader::TraceReader;

  void feed(std::string_view bytes) override {
    if (!stopped_) reader_.feed(bytes);
  }

  std::optional<TraceItem> next() override {
    auto item = reader_.next();
    if (!item) return std::nullopt;
    if (auto* line = std::get_if<can::CandumpLine>(&*item)) {
      ++frames_;
      return std::move(*line);
    }
    const auto& error = std::get<can::PcapngError>(*item);
    stopped_ = stopped_ || error.fatal;
    return TraceProblem{fmt::format("{}: {}", name_, error.message)};
  }

  std::optional<TraceItem> finish() override {
    if (stopped_ || reader_.unfinished() == 0) return std::nullopt;
    return TraceProblem{fmt::format("{}: the capture ends in the middle of a block", name_)};
  }

  std::string place() const override { return fmt::format("frame {}", frames_); }

 private:
  can::PcapngReader reader_;
  std::uint64_t frames_ = 0;
  bool stopped_ = false;
};

/// A file of either kind; its first bytes tell which.
class FileSource final : public TraceSource {
 public:
  explicit FileSource(const std::string& path) : path_(path) {
    if (path == "-") return;
    file_.reset(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (!file_.is_open()) throw std::system_error(errno, std::generic_category(), path);
    struct stat found {};
    if (::fstat(file_.number(), &found) == 0 && S_ISREG(found.st_mode))
      size_ = static_cast<std::uint64_t>(found.st_size);
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

  std::string place() const override { return reader_ ? reader_->place() : std::string(); }
  TraceProgress progress() const noexcept override { return {read_, size_}; }

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
    read_ += static_cast<std::uint64_t>(got);
    first_.append(buffer_.data(), static_cast<std::size_t>(got));
    if (!reader_ &&
        (ended_ || first_.size() >= kFirstBytes || first_.find('\n', kShortestBeginning) != first_.npos))
      choose_reader();
    if (reader_) reader_->feed(std::exchange(first_, {}));
    return true;
  }

  /// Throws std::runtime_error for a file that is neither kind.
  void choose_reader() {
    const std::string name = path_ == "-" ? "standard input" : text::visible(path_);
    if (can::is_pcapng(first_)) {
      reader_ = std::make_unique<CaptureReader>(name);
      return;
    }
    // The first line alone: what is damaged behind it costs its own lines.
    const auto end = first_.find('\n', kShortestBeginning);
    const std::string foreign =
        text::recognized_text(std::string_view(first_).substr(0, end == first_.npos ? end : end + 1));
    if (!foreign.empty())
      throw std::runtime_error(
          fmt::format("{}: {}; allowed: a candump text log (candump -L) or a pcapng capture", name, foreign));
    reader_ = std::make_unique<LogReader>(name);
  }

  std::string path_;
  sys::Descriptor file_;  ///< none: standard input
  std::array<char, 65536> buffer_{};
  std::string first_;  ///< read, and not yet handed to the reader
  std::uint64_t read_ = 0;
  std::uint64_t size_ = 0;
  bool ended_ = false;
  bool finished_ = false;
  std::unique_ptr<TraceReader> reader_;
};

/// A recording that is there already; what comes through a pipe is shown as it comes.
bool is_regular_file(const std::string& path) {
  struct stat found = {};
  const int failed = path == "-" ? ::fstat(STDIN_FILENO, &found) : ::stat(path.c_str(), &found);
  return failed == 0 && S_ISREG(found.st_mode);
}

}  // namespace

std::unique_ptr<TraceSource> open_log(const std::string& path) {
  auto log = std::make_unique<FileSource>(path);
  if (!is_regular_file(path)) return log;
  return each_frame_once(std::move(log), path == "-" ? "standard input" : text::visible(path));
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
