#include "rt/realtime_thread.h"

#include <alloca.h>
#include <fcntl.h>
#include <linux/capability.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <system_error>
#include <utility>

#include "rt/thread_stack.h"

namespace rt {
namespace {

/// Stack beyond the prefaulted part and the thread-local data: what a sanitizer makes of every call.
constexpr std::size_t kRoomForWork = std::size_t{1024} * 1024;

constexpr const char* kWaiver = "; or waive it with realtime mode \"ignore\"";

std::string reason(int error) {
  return std::generic_category().message(error);
}

std::string limit_text(rlim_t limit) {
  return limit == RLIM_INFINITY ? std::string("unlimited") : std::to_string(limit);
}

rlim_t soft_limit(__rlimit_resource resource) noexcept {
  rlimit limit{};
  return ::getrlimit(resource, &limit) == 0 ? limit.rlim_cur : 0;
}

/// True when RLIMIT_MEMLOCK does not bind this process. Under a limit, mlockall may succeed now and make
/// every later allocation fail.
bool may_lock_everything() noexcept {
  if (soft_limit(RLIMIT_MEMLOCK) == RLIM_INFINITY) return true;
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  __user_cap_data_struct data[_LINUX_CAPABILITY_U32S_3] = {};
  if (::syscall(SYS_capget, &header, data) != 0) return false;
  return (data[CAP_TO_INDEX(CAP_IPC_LOCK)].effective & CAP_TO_MASK(CAP_IPC_LOCK)) != 0;
}

/// Touches every page of the stack that the work will use, so that it never faults later.
[[gnu::noinline]] void touch_stack(std::size_t bytes) noexcept {
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  auto* stack = static_cast<volatile std::uint8_t*>(alloca(bytes));
  for (std::size_t i = 0; i < bytes; i += page) stack[i] = 0;
}

std::string joined(const std::vector<std::string>& sentences) {
  std::string text;
  for (const std::string& sentence : sentences) text += (text.empty() ? "" : "\n") + sentence;
  return text;
}

void check(const RealtimeSettings& settings) {
  if (settings.priority < 0 || settings.priority > highest_priority()) {
    throw std::invalid_argument("realtime priority " + std::to_string(settings.priority) +
                                ": allowed are 1.." + std::to_string(highest_priority()) +
                                ", or 0 for normal scheduling");
  }
  if (settings.cpu < -1 || settings.cpu >= CPU_SETSIZE) {
    throw std::invalid_argument("processor " + std::to_string(settings.cpu) + ": allowed are 0.." +
                                std::to_string(CPU_SETSIZE - 1) + ", or -1 for any");
  }
}

}  // namespace

int highest_priority() noexcept {
  return ::sched_get_priority_max(SCHED_FIFO) - 1;
}

RealtimeThread::RealtimeThread(const RealtimeSettings& settings, std::function<void()> work)
    : settings_(settings), work_(std::move(work)) {
  check(settings_);
  lock_memory();

  // A stack of its own size: with locked memory the usual 8 MiB would all be resident.
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, settings_.prefaulted_stack + kRoomForWork + thread_local_bytes());
  const int error = pthread_create(&thread_, &attributes, &RealtimeThread::entry, this);
  pthread_attr_destroy(&attributes);
  if (error != 0) {
    throw std::system_error(error, std::generic_category(), "the realtime thread cannot be created");
  }
  joinable_ = true;
  wait_while(Start::preparing);

  grants_.scheduling = scheduling_error_ == 0;
  grants_.affinity = affinity_error_ == 0;
  if (!grants_.scheduling) {
    const std::string wanted = std::to_string(settings_.priority);
    grants_.missing.push_back("realtime priority " + wanted + " was not granted (" +
                              reason(scheduling_error_) + "), allowed are up to " +
                              limit_text(soft_limit(RLIMIT_RTPRIO)) + ": set LimitRTPRIO=" + wanted +
                              " in the service unit or rtprio in /etc/security/limits.conf" + kWaiver);
  }
  if (!grants_.affinity) {
    grants_.missing.push_back(
        "processor " + std::to_string(settings_.cpu) + " was not granted (" + reason(affinity_error_) +
        "): choose one that is online and in CPUAffinity=/AllowedCPUs=" + " of the service unit" + kWaiver);
  }
  if (settings_.enforce && !(grants_.scheduling && grants_.affinity && grants_.memory_locked)) {
    move_to(Start::give_up);
    join();
    throw RealtimeError(joined(grants_.missing));
  }
  // Never a reason to refuse, so it is not asked for before.
  hold_cpu_awake();
  move_to(Start::go);
}

RealtimeThread::~RealtimeThread() {
  join();
}

void RealtimeThread::join() noexcept {
  if (!joinable_) return;
  pthread_join(thread_, nullptr);
  joinable_ = false;
  latency_.reset();
}

void RealtimeThread::lock_memory() {
  if (!settings_.lock_memory) {
    grants_.memory_locked = true;
    return;
  }
  const bool unlimited = may_lock_everything();
  const int result = ::mlockall(unlimited ? MCL_CURRENT | MCL_FUTURE : MCL_CURRENT);
  const int error = errno;
  grants_.memory_locked = unlimited && result == 0;
  if (grants_.memory_locked) return;
  grants_.missing.push_back("locked memory was not granted (" +
                            (result == 0 ? std::string("present memory only") : reason(error)) +
                            "), allowed are " + limit_text(soft_limit(RLIMIT_MEMLOCK)) +
                            " bytes: set LimitMEMLOCK=infinity in the service unit or memlock in "
                            "/etc/security/limits.conf" +
                            kWaiver);
}

void RealtimeThread::hold_cpu_awake() {
  if (!settings_.hold_cpu_awake) {
    grants_.cpu_held_awake = true;
    return;
  }
  const std::int32_t latency_us = 0;
  latency_.reset(::open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC));
  const int error = errno;
  grants_.cpu_held_awake =
      latency_.is_open() && ::write(latency_.number(), &latency_us, sizeof latency_us) == sizeof latency_us;
  if (grants_.cpu_held_awake) return;
  grants_.missing.push_back("processor sleep states stay on, /dev/cpu_dma_latency was not granted (" +
                            reason(error) +
                            "): give the daemon's user write access to it; wake-ups may be later without");
}

void* RealtimeThread::entry(void* self) noexcept {
  auto& thread = *static_cast<RealtimeThread*>(self);
  thread.prepare();
  thread.move_to(Start::prepared);
  thread.wait_while(Start::prepared);
  if (thread.start_.load(std::memory_order_acquire) == Start::go) thread.work_();
  return nullptr;
}

void RealtimeThread::prepare() noexcept {
  pthread_setname_np(pthread_self(), "cansync-rt");
  if (settings_.cpu >= 0) {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(static_cast<std::size_t>(settings_.cpu), &set);
    affinity_error_ = pthread_setaffinity_np(pthread_self(), sizeof set, &set);
  }
  if (settings_.priority > 0) {
    sched_param parameters{};
    parameters.sched_priority = settings_.priority;
    scheduling_error_ = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
  }
  // Without realtime scheduling a sleep may be prolonged by 50 us; ask for the finest there is.
  ::prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);
  touch_stack(settings_.prefaulted_stack);
}

void RealtimeThread::move_to(Start start) noexcept {
  // notify_all wakes nobody when it sees no waiter. A mere release may become visible after that look: the
  // waiter would then have missed both. With seq_cst on all of it either we see the waiter or it sees the
  // value.
  start_.store(start, std::memory_order_seq_cst);
  start_.notify_all();
}

void RealtimeThread::wait_while(Start start) const noexcept {
  start_.wait(start, std::memory_order_acquire);
}

}  // namespace rt
