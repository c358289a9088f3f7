#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "can/frame.h"
#include "layer2/bounded_queue.h"

/// Internal to lib/client.
namespace cansync::client::detail {

/// An interrupt of a queue (Saia 4.2.3).
struct QueueInterrupt {
  int routine = 0;
  std::uint16_t parameter = 0;
  bool enabled = false;
};

/// How the queues of the Basic Services are set up.
struct SaiaQueueSettings {
  std::uint32_t identifier = 0;
  std::uint32_t mask = 0;  ///< bits of the identifier that count
  bool extended = false;   ///< of both queues
  std::size_t receive_depth = 1;
  std::size_t send_depth = 1;
  QueueInterrupt received;    ///< a frame came to an empty queue
  QueueInterrupt sent_empty;  ///< the last frame was sent
};

/// The receive and the send queue of the Basic Services (Saia 4.2.3): what comes to a full one is refused.
/// One thread.
class SaiaQueues {
 public:
  /// A frame that waits to be sent.
  struct Waiting {
    can::Frame frame;
    bool by_identifier = false;
  };
  /// Frames that the daemon has at a time; those by identifier find room beyond them.
  static constexpr std::size_t kHandedOver = 40;
  static constexpr std::size_t kUrgentHandedOver = 50;

  /// Anew; what waited is gone, but for what the daemon has.
  void configure(const SaiaQueueSettings& settings) {
    settings_ = settings;
    received_.emplace(settings.receive_depth);
    sending_.emplace(settings.send_depth);
    overrun_ = false;
  }
  /// There are no queues any more.
  void remove() noexcept {
    received_.reset();
    sending_.reset();
  }
  bool configured() const noexcept { return received_.has_value(); }
  const SaiaQueueSettings& settings() const noexcept { return settings_; }

  /// A frame came. True: the queue had been empty, and took it.
  bool receive(const can::Frame& frame) {
    if (!received_ || frame.remote || frame.extended != settings_.extended) return false;
    if (((frame.id ^ settings_.identifier) & settings_.mask) != 0) return false;
    const bool was_empty = received_->empty();
    if (!received_->push(frame).taken) overrun_ = true;
    return was_empty;
  }
  /// Frames were lost on the way here.
  void missed() noexcept { overrun_ = overrun_ || received_; }
  /// The oldest frame.
  std::optional<can::Frame> take() {
    if (!received_ || received_->empty()) return std::nullopt;
    return received_->pop();
  }
  /// A frame was lost since the last call.
  bool take_overrun() noexcept { return std::exchange(overrun_, false); }

  /// False: the queue is full, the frame is dropped.
  bool send(const Waiting& one) {
    if (handed_over_ + sending_->size() >= sending_->depth()) return false;
    std::size_t at = sending_->size();
    if (one.by_identifier) {
      // The first element is never overtaken; when the daemon has some, that one is there.
      at = handed_over_ > 0 || sending_->empty() ? 0 : 1;
      while (at < sending_->size() && (*sending_)[at].frame.id <= one.frame.id) ++at;
    }
    (void)sending_->insert(at, one);
    return true;
  }
  /// Hands frames over: `begin(waiting)` is true when the daemon has it.
  template <class Begin>
  void hand_over(Begin&& begin) {
    while (sending_ && !sending_->empty()) {
      const Waiting& first = (*sending_)[0];
      if (handed_over_ >= (first.by_identifier ? kUrgentHandedOver : kHandedOver) || !begin(first)) return;
      (void)sending_->pop();
      ++handed_over_;
    }
  }
  /// One that was handed over has ended. True: it was the last.
  bool ended() noexcept {
    if (handed_over_ > 0) --handed_over_;
    return handed_over_ == 0 && sending_ && sending_->empty();
  }
  /// What waits is not sent any more.
  void clear_sending() noexcept {
    if (sending_) sending_->clear();
  }

 private:
  SaiaQueueSettings settings_;
  std::optional<layer2::BoundedQueue<can::Frame>> received_;
  std::optional<layer2::BoundedQueue<Waiting>> sending_;
  std::size_t handed_over_ = 0;
  bool overrun_ = false;
};

}  // namespace cansync::client::detail
