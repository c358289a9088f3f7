#include "daemon/host_watch.h"

#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <string>

#include "text/build_info.h"

namespace cansyncd {

using std::chrono::steady_clock;

HostWatch::HostWatch()
    : files_("/", std::string(text::package_version())),
      disk_due_(steady_clock::now() + kDiskPeriod),
      inhibitors_(make_logind(), [this] {
        shuts_down_.store(true, std::memory_order_relaxed);
        (void)::kill(::getpid(), SIGTERM);  // the main thread waits for signals
      }) {}

void HostWatch::step(std::span<Segment* const> segments) {
  inhibitors_.set_in_run(
      std::any_of(segments.begin(), segments.end(), [](const Segment* one) { return one->in_run(); }));
  if (const InhibitorState state = inhibitors_.state(); state != told_) {
    for (Segment* const segment : segments) segment->tell_inhibitors(told_, state);
    told_ = state;
  }
  if (steady_clock::now() >= disk_due_) look_again(segments);
}

void HostWatch::look_again(std::span<Segment* const> segments) {
  disk_due_ = steady_clock::now() + kDiskPeriod;
  const PendingRestart pending = files_.look();
  for (Segment* const segment : segments) segment->set_pending_restart(pending);
}

}  // namespace cansyncd
