#pragma once

#include <cstddef>
#include <optional>
#include <utility>

#include "layer2/bounded_queue.h"
#include "layer2/status_image.h"

/// Internal to lib/client.
namespace cansync::client::detail {

/// What waits between a program's function blocks and the daemon, as in a CAN 300 PRO (Helmholz 6.7.1): 400
/// frames of normal and 20 of high priority in each direction; a full queue deletes its oldest frame, with a
/// bit that stays until it is reset. One thread.
template <class Item>
class ModuleQueues {
 public:
  static constexpr std::size_t kNormal = 400;
  static constexpr std::size_t kHigh = 20;
  /// Frames that the daemon has at a time: other blocks of the connection find room beside them.
  static constexpr std::size_t kHandedOver = 40;

  /// A frame to be sent.
  void send(const Item& item, bool high) { (void)(high ? send_high_ : send_).push(item); }
  /// Hands frames over, those of high priority first: `begin(item, high)` is true when the daemon has it.
  template <class Begin>
  void hand_over(Begin&& begin) {
    while (handed_over_ < kHandedOver && !(send_high_.empty() && send_.empty())) {
      const bool high = !send_high_.empty();
      auto& queue = high ? send_high_ : send_;
      if (!begin(queue[0], high)) return;
      (void)queue.pop();
      ++handed_over_;
    }
  }
  /// One that was handed over has ended.
  void ended() noexcept {
    if (handed_over_ > 0) --handed_over_;
  }

  /// A frame that came.
  void received(const Item& item, bool high) { (void)(high ? received_high_ : received_).push(item); }
  /// Frames were lost on the way here.
  void missed() noexcept { missed_ = true; }
  /// The next frame, of high priority first, and whether it is one.
  std::optional<std::pair<Item, bool>> take() {
    if (!received_high_.empty()) return std::pair{received_high_.pop(), true};
    if (!received_.empty()) return std::pair{received_.pop(), false};
    return std::nullopt;
  }

  /// Every frame is forgotten but those the daemon has; overflow bits stay.
  void clear() noexcept {
    for (auto* queue : {&send_high_, &send_, &received_high_, &received_}) queue->clear();
  }
  /// Takes the overflow bits back.
  void reset_overflow() noexcept {
    for (auto* queue : {&send_high_, &send_, &received_high_, &received_}) queue->reset_overflow();
    missed_ = false;
  }
  /// Nothing waits here to be handed over.
  bool nothing_to_send() const noexcept { return send_high_.empty() && send_.empty(); }

  /// For STAT: "empty" says that no frame waits here or in the daemon.
  layer2::StatusFacts::Queues sending() const noexcept {
    return {.high_half_full = send_high_.half_full(),
            .normal_half_full = send_.half_full(),
            .overflowed = send_high_.overflowed() || send_.overflowed(),
            .empty = nothing_to_send() && handed_over_ == 0};
  }
  /// For STAT, of what came.
  layer2::StatusFacts::Queues receiving() const noexcept {
    return {.high_half_full = received_high_.half_full(),
            .normal_half_full = received_.half_full(),
            .overflowed = received_high_.overflowed() || received_.overflowed() || missed_,
            .empty = received_high_.empty() && received_.empty()};
  }

 private:
  using Queue = layer2::BoundedQueue<Item>;
  Queue send_high_{kHigh, layer2::Overflow::delete_oldest};
  Queue send_{kNormal, layer2::Overflow::delete_oldest};
  Queue received_high_{kHigh, layer2::Overflow::delete_oldest};
  Queue received_{kNormal, layer2::Overflow::delete_oldest};
  std::size_t handed_over_ = 0;
  bool missed_ = false;
};

}  // namespace cansync::client::detail
