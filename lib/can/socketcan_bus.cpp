#include "can/socketcan_bus.h"

#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/net_tstamp.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "can/error_frame.h"
#include "can/kernel_frame.h"

namespace can {
namespace {

int opened(Kernel& kernel) {
  const int socket = kernel.open_socket();
  if (socket >= 0) return socket;
  const char* what = socket == -EAFNOSUPPORT || socket == -EPROTONOSUPPORT
                         ? "SocketCAN: the kernel has none; load it with: modprobe can-raw"
                         : "SocketCAN: opening a socket";
  throw std::system_error(-socket, std::generic_category(), what);
}

std::vector<can_filter> to_filters(const std::vector<FrameFilter>& filters) {
  std::vector<can_filter> out;
  out.reserve(filters.size());
  for (const FrameFilter& filter : filters) out.push_back(to_kernel(filter));
  return out;
}

}  // namespace

SocketcanBus::SocketcanBus(const SocketcanSettings& settings, LinkBoard& board, LinkKernel& links,
                           Kernel& kernel)
    : kernel_(kernel),
      board_(board),
      links_(links),
      wake_on_frame_(settings.wake_on_frame),
      filters_(to_filters(settings.filters)),
      socket_(opened(kernel)),
      clock_(kernel),
      guard_(settings.interval) {
  try {
    set_options();
  } catch (...) {
    kernel_.close_socket(socket_);
    throw;
  }
  status_.link = LinkState::missing;
  take_up_link();
}

SocketcanBus::~SocketcanBus() {
  kernel_.close_socket(socket_);
}

void SocketcanBus::set_options() {
  const auto must = [](int result, const char* what) {
    if (result < 0) throw std::system_error(-result, std::generic_category(), what);
  };
  const auto set = [this](int level, int name, int value) {
    return kernel_.set_option(socket_, level, name, &value, sizeof(value));
  };
  must(set_filters(), "SocketCAN: setting the identifier filter");
  const can_err_mask_t errors = CAN_ERR_MASK;
  must(kernel_.set_option(socket_, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof(errors)),
       "SocketCAN: switching error frames on");
  must(set(SOL_CAN_RAW, CAN_RAW_LOOPBACK, 1), "SocketCAN: switching the loopback on");
  must(set(SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, 1), "SocketCAN: reading own frames back");
  must(set(SOL_SOCKET, SO_RXQ_OVFL, 1), "SocketCAN: counting drops");
  must(set(SOL_SOCKET, SO_TIMESTAMPING,
           SOF_TIMESTAMPING_RX_SOFTWARE | SOF_TIMESTAMPING_SOFTWARE | SOF_TIMESTAMPING_RX_HARDWARE |
               SOF_TIMESTAMPING_RAW_HARDWARE),
       "SocketCAN: switching time stamps on");
  // The kernel's least: a handful of frames. What does not leave in time is to be seen, not queued.
  must(set(SOL_SOCKET, SO_SNDBUF, 0), "SocketCAN: setting the send buffer");
}

int SocketcanBus::set_filters() noexcept {
  return kernel_.set_option(socket_, SOL_CAN_RAW, CAN_RAW_FILTER, filters_.data(),
                            filters_.size() * sizeof(can_filter));
}

Wake SocketcanBus::sleep(Time deadline, bool wake_on_frame) noexcept {
  if (batch_next_ < batch_size_) return Wake::frame;
  looked_ = false;
  const Time left = deadline - kernel_.monotonic();
  if (left <= Time{0}) return Wake::deadline;
  if (wake_on_frame && bound_ != 0) {
    const int ready = kernel_.wait_readable(socket_, left);
    if (ready > 0) return Wake::frame;
    if (ready < 0) return Wake::interrupted;
    if (kernel_.monotonic() >= deadline) return Wake::deadline;
  }
  return kernel_.sleep_until(deadline) == 0 ? Wake::deadline : Wake::interrupted;
}

bool SocketcanBus::receive(ReceivedFrame& out) noexcept {
  while (true) {
    while (batch_next_ < batch_size_) {
      const bool last = batch_next_ + 1 == batch_size_;
      const bool taken = take(batch_.message(batch_next_++), out);
      if (last) {
        const bool everything = batch_size_ < ReceiveBatch::kFrames;
        clock_.end_batch(everything);
        guard_.end_look(everything && status_.state != ControllerState::bus_off);
      }
      if (taken) return true;
    }
    if (looked_ || bound_ == 0) return false;
    look();
  }
}

/// The one look at the kernel that each sleep allows. What a full batch leaves behind is taken after the
/// next.
void SocketcanBus::look() noexcept {
  looked_ = true;
  batch_size_ = batch_next_ = 0;
  guard_.begin_look(clock_.begin_batch(), board_.one_shot());
  const int count = batch_.receive(kernel_, socket_);
  if (count > 0) {
    batch_size_ = static_cast<unsigned>(count);
  } else if (count == -EAGAIN) {
    clock_.end_batch(true);
    guard_.end_look(status_.state != ControllerState::bus_off);
  } else if (count == -ENETDOWN) {
    went_down(kernel_.monotonic());
  }
}

bool SocketcanBus::take(const RawMessage& message, ReceivedFrame& out) noexcept {
  if (message.drops) count_drops(*message.drops);
  if (!message.whole) return false;
  if ((message.frame.can_id & CAN_ERR_FLAG) != 0) {
    account(message.frame);
    return false;
  }
  const StampedTime time = clock_.translate(message.stamps);
  source_ = time.source;
  out = {from_kernel(message.frame), time.at, message.own};
  if (message.own) guard_.echo(out.frame);
  return true;
}

void SocketcanBus::count_drops(std::uint32_t total) noexcept {
  if (total != drops_seen_) guard_.echoes_lost();
  status_.dropped += static_cast<std::uint32_t>(total - drops_seen_);
  drops_seen_ = total;
}

void SocketcanBus::account(const can_frame& frame) noexcept {
  const ErrorFrame error = read_error_frame(frame);
  ++status_.error_frames;
  if (error.not_acknowledged) ++status_.acknowledge_errors;
  if (error.restarted) {
    ++status_.restarts;
    guard_.emptied(kernel_.monotonic());
  }
  if (error.overrun) ++status_.overruns;
  if (error.counters) {
    status_.transmit_errors = error.counters->transmit;
    status_.receive_errors = error.counters->receive;
  }
  if (error.state) {
    status_.state = *error.state;
    board_.begin_era();
  }
}

SendResult SocketcanBus::send(const Frame& frame) noexcept {
  if (bound_ == 0 || status_.link != LinkState::up) return SendResult::interface_down;
  if (status_.state == ControllerState::bus_off) return SendResult::bus_off;
  // Where reading the clock is a system call, each reading delays the telegrams behind it.
  if (!guard_.may_send(guard_.wants_time() ? kernel_.monotonic() : Time{0})) return SendResult::not_delivered;
  switch (kernel_.send_frame(socket_, to_kernel(frame))) {
    case -ENETDOWN:
    case -ENODEV:
    case -ENXIO:
      went_down(kernel_.monotonic());
      return SendResult::interface_down;
    case static_cast<int>(sizeof(can_frame)):
      guard_.handed_over(frame);
      return SendResult::queued;
    default:  // no room, or a reason that does not last either
      guard_.queue_full();
      ++status_.queue_full;
      return SendResult::queue_full;
  }
}

ControllerStatus SocketcanBus::status() noexcept {
  take_up_link();
  if (const auto controller = board_.controller()) {
    status_.state = controller->state;
    status_.transmit_errors = controller->transmit_errors;
    status_.receive_errors = controller->receive_errors;
  }
  guard_controller();
  status_.delivery = guard_.delivery();
  status_.unacknowledged = guard_.unacknowledged();
  return status_;
}

/// The socket tells it once, before anything else can be handed over, also when the interface is up again:
/// its queues were emptied.
void SocketcanBus::went_down(Time now) noexcept {
  down_seen_ = true;
  guard_.emptied(now);
}

/// Tells the guard when the controller has been emptied, and has it reset when the guard wants that.
void SocketcanBus::guard_controller() noexcept {
  const bool bus_off = status_.state == ControllerState::bus_off;
  const bool emptied = status_.link != LinkState::up || (was_bus_off_ && !bus_off);
  was_bus_off_ = bus_off;
  if (!emptied && !reset_asked_ && !guard_.wants_reset()) return;
  const Time now = kernel_.monotonic();
  if (emptied) guard_.emptied(now);
  if (reset_asked_) {
    const ResetResult result = reset_result();
    reset_asked_ = result == ResetResult::pending;
    if (result == ResetResult::done && !down_seen_) guard_.emptied(now);
    if (result == ResetResult::not_permitted || result == ResetResult::unavailable) {
      guard_.reset_failed();
      next_reset_ = now + EchoGuard::kPause;
    }
  }
  if (guard_.wants_reset() && !reset_asked_ && now >= next_reset_) reset();
}

/// An interface that has gone takes the socket's filters along: both are set anew on the one that came back.
void SocketcanBus::take_up_link() noexcept {
  const LinkBoard::Link link = board_.link();
  status_.bits_per_second = board_.bit_rate();
  status_.link = link.state;
  if (link.index == bound_) return;
  bound_ = 0;
  if (link.index == 0) return;
  clock_.forget_hardware();
  const bool bound = set_filters() >= 0 && kernel_.bind_to(socket_, static_cast<int>(link.index)) >= 0;
  if (bound) {
    bound_ = link.index;
  } else {
    status_.link = LinkState::missing;  // gone again; tried anew at the next call
  }
}

ResetResult SocketcanBus::reset() noexcept {
  if (reset_result() == ResetResult::pending) return ResetResult::pending;
  reset_asked_ = true;
  down_seen_ = false;
  board_.want_reset(++resets_);
  links_.interrupt();
  return ResetResult::pending;
}

ResetResult SocketcanBus::reset_result() noexcept {
  if (resets_ == 0) return ResetResult::done;
  return board_.reset_result(resets_).value_or(ResetResult::pending);
}

}  // namespace can
