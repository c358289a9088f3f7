#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "cansync/telegram/numbers.h"

namespace cansync {

/// One first-in-first-out queue for each slave, all from one pool of fixed size. Memory is taken in the
/// constructor; everything else is realtime safe. Not thread safe.
template <class Job>
class SlaveQueues {
 public:
  /// Takes the memory for `capacity` jobs of all slaves together. Throws std::bad_alloc.
  explicit SlaveQueues(std::size_t capacity) : nodes_(capacity) {
    for (std::size_t i = 0; i < capacity; ++i)
      nodes_[i].next = static_cast<Index>(i + 1 < capacity ? i + 1 : kNone);
    free_ = capacity > 0 ? 0 : kNone;
    head_.fill(kNone);
    tail_.fill(kNone);
  }

  /// Jobs of all slaves together.
  std::size_t size() const noexcept { return size_; }
  /// True when `push` would return null, for every slave.
  bool full() const noexcept { return free_ == kNone; }
  /// Bit n: slave n has at least one job.
  SlaveMask waiting() const noexcept { return waiting_; }

  /// Adds a job behind the others of its slave and returns it; null when the pool is full.
  Job* push(SlaveNumber slave, const Job& job) noexcept {
    if (full()) return nullptr;
    const Index at = free_;
    free_ = nodes_[at].next;
    nodes_[at].job = job;
    nodes_[at].next = kNone;
    Index& head = head_[slave.value()];
    Index& tail = tail_[slave.value()];
    if (head == kNone) {
      head = at;
    } else {
      nodes_[tail].next = at;
    }
    tail = at;
    ++size_;
    waiting_.set(slave);
    return &nodes_[at].job;
  }

  /// The slave's first job; null when it has none.
  Job* front(SlaveNumber slave) noexcept {
    const Index head = head_[slave.value()];
    return head == kNone ? nullptr : &nodes_[head].job;
  }

  /// The same, to look at.
  const Job* front(SlaveNumber slave) const noexcept {
    const Index head = head_[slave.value()];
    return head == kNone ? nullptr : &nodes_[head].job;
  }

  /// Removes the slave's first job.
  void pop(SlaveNumber slave) noexcept {
    if (head_[slave.value()] != kNone) remove(slave, kNone, head_[slave.value()]);
  }

  /// Removes the first job for which `match(job)` holds and which is not first in its queue, or is allowed to
  /// be by `include_front`; calls `removed(job)` before. Returns whether there was one.
  template <class Match, class Removed>
  bool remove_if(Match match, bool include_front, Removed removed) noexcept {
    for (std::uint8_t number = 0; number < kSlaves; ++number) {
      Index before = kNone;
      for (Index at = head_[number]; at != kNone; before = at, at = nodes_[at].next) {
        if ((before == kNone && !include_front) || !match(nodes_[at].job)) continue;
        removed(nodes_[at].job);
        remove(*SlaveNumber::from(number), before, at);
        return true;
      }
    }
    return false;
  }

 private:
  using Index = std::uint32_t;
  static constexpr Index kNone = 0xFFFFFFFF;

  struct Node {
    Job job{};
    Index next = kNone;
  };

  void remove(SlaveNumber slave, Index before, Index at) noexcept {
    Index& head = head_[slave.value()];
    Index& tail = tail_[slave.value()];
    if (before == kNone) {
      head = nodes_[at].next;
    } else {
      nodes_[before].next = nodes_[at].next;
    }
    if (tail == at) tail = before;
    nodes_[at].next = free_;
    free_ = at;
    --size_;
    if (head == kNone) waiting_.set(slave, false);
  }

  std::vector<Node> nodes_;
  Index free_ = kNone;
  std::array<Index, kSlaves> head_;
  std::array<Index, kSlaves> tail_;
  std::size_t size_ = 0;
  SlaveMask waiting_;
};

}  // namespace cansync
