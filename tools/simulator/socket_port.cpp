#include "simulator/socket_port.h"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <system_error>
#include <utility>

#include "system/clock.h"

namespace cansync_sim {
namespace {

constexpr can::Time kLookAgain = std::chrono::milliseconds(100);

std::atomic<bool> stop_wanted{false};
static_assert(std::atomic<bool>::is_always_lock_free);

extern "C" void want_stop(int) {
  stop_wanted.store(true);
}

sigset_t stop_signals() noexcept {
  sigset_t signals;
  ::sigemptyset(&signals);
  ::sigaddset(&signals, SIGTERM);
  ::sigaddset(&signals, SIGINT);
  return signals;
}

/// A wish to stop that the handler has seen, or that waits outside of `wait`.
bool stop_asked() noexcept {
  if (stop_wanted.load()) return true;
  sigset_t pending;
  return ::sigpending(&pending) == 0 &&
         (::sigismember(&pending, SIGTERM) == 1 || ::sigismember(&pending, SIGINT) == 1);
}

void listen_for_stop() noexcept {
  struct sigaction action {};
  action.sa_handler = want_stop;
  ::sigaction(SIGTERM, &action, nullptr);
  ::sigaction(SIGINT, &action, nullptr);
  // Blocked but for `wait`, so that no signal falls between the look at the wish and the sleep.
  const sigset_t signals = stop_signals();
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
}

}  // namespace

SocketPort::SocketPort(std::string interface) : interface_(std::move(interface)) {
  listen_for_stop();
  look();
}

SocketPort::SocketPort(std::string interface, int descriptor) : interface_(std::move(interface)) {
  listen_for_stop();
  socket_.adopt(descriptor);
  look();
}

std::string SocketPort::obstacle() const {
  if (opened_ == can::SocketResult::no_can)
    return "this kernel has no CAN sockets; as root: modprobe can-raw";
  if (opened_ == can::SocketResult::failed) {
    return fmt::format("{}: no CAN socket: {}; is it a CAN interface (`ip -details link show {}`)?",
                       interface_, std::generic_category().message(socket_.error()), interface_);
  }
  return {};
}

can::Time SocketPort::now() noexcept {
  return sys::read_clock(CLOCK_MONOTONIC);
}

void SocketPort::take(can::SocketResult result) noexcept {
  if (result == can::SocketResult::interface_down) link_ = Link::down;
  if (result == can::SocketResult::interface_gone || result == can::SocketResult::failed) {
    dropped_ += socket_.dropped();
    socket_.close();
    link_ = Link::missing;
  }
}

void SocketPort::look() noexcept {
  looked_at_ = now();
  if (!socket_.is_open()) {
    opened_ = socket_.open(interface_);
    if (opened_ != can::SocketResult::done) return;
  }
  const can::SocketResult result = socket_.link();
  if (result == can::SocketResult::done) link_ = Link::up;
  take(result);
}

bool SocketPort::wait(can::Time deadline) noexcept {
  if (link_ != Link::up) deadline = std::min(deadline, looked_at_ + kLookAgain);
  const can::Time until = deadline == can::Time::max() ? deadline : std::max(can::Time{0}, deadline - now());
  const timespec timeout = deadline == can::Time::max() ? timespec{} : sys::to_timespec(until);
  sigset_t mask;
  ::pthread_sigmask(SIG_SETMASK, nullptr, &mask);
  ::sigdelset(&mask, SIGTERM);
  ::sigdelset(&mask, SIGINT);
  pollfd ready{socket_.descriptor(), POLLIN, 0};
  // A socket whose interface is down would be ready for ever with its error: only time is waited for then.
  ::ppoll(&ready, link_ == Link::up ? 1 : 0, deadline == can::Time::max() ? nullptr : &timeout, &mask);
  // Linux delivers a signal to `ppoll` only when no descriptor is ready: with a frame waiting it stays
  // pending.
  if (stop_asked()) return false;
  if (link_ != Link::up && now() >= looked_at_ + kLookAgain) look();
  return true;
}

bool SocketPort::receive(can::ReceivedFrame& out) noexcept {
  if (link_ != Link::up) return false;
  // Under a flood of frames `wait` may not be reached for long.
  if (stop_asked()) return false;
  const can::SocketResult result = socket_.receive(out);
  take(result);
  return result == can::SocketResult::done;
}

can::SendResult SocketPort::send(const can::Frame& frame) noexcept {
  if (link_ != Link::up) return can::SendResult::interface_down;
  const can::SocketResult result = socket_.send(frame);
  take(result);
  if (result == can::SocketResult::done) return can::SendResult::queued;
  return result == can::SocketResult::queue_full ? can::SendResult::queue_full
                                                 : can::SendResult::interface_down;
}

}  // namespace cansync_sim
