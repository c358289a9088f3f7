#include "can/socketcan/socketcan_bus.h"

#include <linux/can.h>

#include <cerrno>

#include "can/socketcan/error_frame.h"
#include "can/socketcan/kernel_frame.h"

namespace can {

SocketcanBus::SocketcanBus(const SocketcanSettings& settings, LinkBoard& board, LinkKernel& links,
                           Kernel& kernel) noexcept
    : kernel_(kernel),
      board_(board),
      links_(links),
      wake_on_frame_(settings.wake_on_frame),
      clock_(kernel),
      guard_(settings.interval) {
  status_.link = LinkState::missing;
  take_up_link();
}

Wake SocketcanBus::sleep(Time deadline, bool wake_on_frame) noexcept {
  if (batch_next_ < batch_size_) return Wake::frame;
  looked_ = false;
  const Time left = deadline - kernel_.monotonic();
  if (left <= Time{0}) return Wake::deadline;
  if (wake_on_frame && socket_ >= 0) {
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
    if (looked_ || socket_ < 0) return false;
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
  if (socket_ < 0 || status_.link != LinkState::up) return SendResult::interface_down;
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

/// An interface that has come back has another socket. Were it back before anybody has seen that it was gone, it
/// counts as missing for once: what was on the way is lost, and so is what its nodes knew.
void SocketcanBus::take_up_link() noexcept {
  const LinkBoard::Link link = board_.link();
  status_.bits_per_second = board_.bit_rate();
  status_.link = link.state;
  if (link.socket == socket_) return;
  clock_.forget_hardware();
  drops_seen_ = 0;
  const bool exchanged = socket_ >= 0;
  // What the watch has exchanged once more meanwhile is taken at the next call.
  socket_ = board_.use_socket(link.socket) ? link.socket : -1;
  if (status_.link == LinkState::up && (exchanged || socket_ < 0)) status_.link = LinkState::missing;
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
