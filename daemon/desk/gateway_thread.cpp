#include "daemon/desk/gateway_thread.h"

#include <poll.h>
#include <pthread.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include "dds/malformed.h"

namespace cansyncd {
namespace {

/// Milliseconds from now to `due`, rounded up, at least 0.
int milliseconds_to(SteadyTime due) {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(due - std::chrono::steady_clock::now());
  return static_cast<int>(std::max<std::int64_t>(left.count(), 0));
}

}  // namespace

GatewayThread::GatewayThread(rt::WakeSignal& wake, gateway::dds::DataSignal& signal, Pass pass,
                             std::function<void()> end)
    : wake_(wake), signal_(signal), pass_(std::move(pass)), end_(std::move(end)) {}

GatewayThread::~GatewayThread() {
  stop();
}

void GatewayThread::start() {
  gateway::dds::count_malformed();
  thread_ = std::thread([this] {
    pthread_setname_np(pthread_self(), "cansync-gateway");  // for `top -H` and whoever measures
    run();
  });
}

void GatewayThread::stop() noexcept {
  if (!thread_.joinable()) return;
  stop_ = true;
  wake_.signal();
  thread_.join();
}

void GatewayThread::run() {
  std::array<pollfd, 2> wake{{{wake_.descriptor(), POLLIN, 0}, {signal_.fd(), POLLIN, 0}}};
  bool samples_may_wait = true;
  while (!stop_) {
    const SteadyTime due = pass_(samples_may_wait);
    passes_.fetch_add(1, std::memory_order_relaxed);
    // An interrupted or failed poll only means one pass too many.
    const int ready = ::poll(wake.data(), wake.size(), milliseconds_to(due));
    if (ready > 0 && wake[0].revents != 0) wake_.clear();
    samples_may_wait = ready <= 0 || wake[1].revents != 0;
    if (samples_may_wait) signal_.clear();
  }
  end_();
}

void PostedEvents::post(const EventText& event) {
  const std::lock_guard lock(mutex_);
  if (posted_.size() < kMost) posted_.push_back(event);
}

void PostedEvents::publish(EventPublisher& events, SteadyTime now) {
  std::vector<EventText> taken;
  {
    const std::lock_guard lock(mutex_);
    taken.swap(posted_);
  }
  for (const EventText& event : taken) events.publish(event, now);
}

}  // namespace cansyncd
