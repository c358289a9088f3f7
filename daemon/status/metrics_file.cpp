#include "daemon/status/metrics_file.h"

#include <fmt/format.h>
#include <pthread.h>
#include <unistd.h>

#include <utility>

#include "daemon/service/replace_file.h"
#include "text/counts.h"

namespace cansyncd {
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
  const auto problem = replace_file(path_, text, {.for_everybody = true});
  if (problem) {
    failures_.fetch_add(1, std::memory_order_relaxed);
    if (++in_a_row_ != 1) return;
    return tell_({gateway_SEVERITY_WARNING, "metrics_not_written", -1,
                  fmt::format("the metrics file {} cannot be written: {}; create its folder for the daemon's "
                              "user, or set metrics.file",
                              path_, *problem),
                  std::nullopt});
  }
  if (in_a_row_ == 0) return;
  tell_({gateway_SEVERITY_INFO, "metrics_written_again", -1,
         fmt::format("the metrics file {} is written again; {} it was not", path_,
                     text::counted(in_a_row_, "time")),
         std::nullopt});
  in_a_row_ = 0;
}

}  // namespace cansyncd
