#include "daemon/desk/metrics_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <pthread.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <string_view>
#include <system_error>
#include <utility>

namespace cansyncd {
namespace {

/// 0, or the error number.
int write_all(int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(file, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

int write_new(const std::string& path, std::string_view text) {
  constexpr mode_t kEverybodyReads = 0644;
  // A name that somebody else may have put there, perhaps as a link, is not written through.
  if (::unlink(path.c_str()) != 0 && errno != ENOENT) return errno;
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kEverybodyReads);
  if (file < 0) return errno;
  const int error = write_all(file, text);
  // Some file systems tell only here that there was no room.
  return ::close(file) != 0 && error == 0 ? errno : error;
}

}  // namespace

std::optional<std::string> replace_file(const std::string& path, const std::string& text) {
  const std::string beside = path + ".new";
  int error = write_new(beside, text);
  if (error == 0 && std::rename(beside.c_str(), path.c_str()) != 0) error = errno;
  if (error == 0) return std::nullopt;
  ::unlink(beside.c_str());
  return std::generic_category().message(error);
}

MetricsFile::MetricsFile(std::string path, Tell tell) : path_(std::move(path)), tell_(std::move(tell)) {
  thread_ = std::thread([this] {
    pthread_setname_np(pthread_self(), "cansync-metrics");  // for `top -H` and whoever measures
    run();
  });
}

MetricsFile::~MetricsFile() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  thread_.join();
  ::unlink(path_.c_str());
}

void MetricsFile::write(std::string text) {
  {
    const std::lock_guard lock(mutex_);
    waiting_ = std::move(text);
  }
  wake_.notify_one();
}

void MetricsFile::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return stop_ || waiting_; });
    if (stop_) return;
    const std::string text = *std::exchange(waiting_, std::nullopt);
    lock.unlock();
    replace(text);
    lock.lock();
  }
}

void MetricsFile::replace(const std::string& text) {
  const auto problem = replace_file(path_, text);
  if (problem) {
    failures_.fetch_add(1, std::memory_order_relaxed);
    if (++in_a_row_ != 1) return;
    return tell_({cansync_SEVERITY_WARNING, "metrics_not_written", -1,
                  fmt::format("the metrics file {} cannot be written: {}; create its folder for the daemon's "
                              "user, or set metrics.file",
                              path_, *problem),
                  std::nullopt});
  }
  if (in_a_row_ == 0) return;
  tell_({cansync_SEVERITY_INFO, "metrics_written_again", -1,
         fmt::format("the metrics file {} is written again; {} times it was not", path_, in_a_row_),
         std::nullopt});
  in_a_row_ = 0;
}

}  // namespace cansyncd
