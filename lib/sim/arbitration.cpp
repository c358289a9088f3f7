#include "sim/arbitration.h"

#include <algorithm>

namespace sim {

std::uint32_t arbitration_key(const can::Frame& frame) noexcept {
  const std::uint32_t request = frame.remote ? 1 : 0;
  // From the top: 11 bits of base identifier, RTR or SRR, IDE, 18 bits of identifier extension, RTR.
  if (!frame.extended) return ((frame.id & 0x7FFu) << 21) | (request << 20);
  const std::uint32_t base = (frame.id >> 18) & 0x7FFu;
  return (base << 21) | (3u << 19) | ((frame.id & 0x3FFFFu) << 1) | request;
}

bool PendingFrames::push(const PendingFrame& frame) noexcept {
  if (frames_.size() == capacity_) return false;
  frames_.push_back(frame);
  return true;
}

std::optional<can::Time> PendingFrames::earliest() const noexcept {
  if (frames_.empty()) return std::nullopt;
  can::Time first = frames_.front().ready;
  for (const PendingFrame& frame : frames_) first = std::min(first, frame.ready);
  return first;
}

const PendingFrame* PendingFrames::winner(can::Time start) const noexcept {
  const PendingFrame* best = nullptr;
  for (const PendingFrame& frame : frames_) {
    if (frame.ready <= start && (best == nullptr || wins(frame, *best))) best = &frame;
  }
  return best;
}

void PendingFrames::remove(const PendingFrame& frame) noexcept {
  const auto at = &frame - frames_.data();
  frames_[static_cast<std::size_t>(at)] = frames_.back();
  frames_.pop_back();
}

unsigned PendingFrames::count(std::uint8_t sender) const noexcept {
  return static_cast<unsigned>(
      std::count_if(frames_.begin(), frames_.end(),
                    [sender](const PendingFrame& frame) { return frame.sender == sender; }));
}

void PendingFrames::drop(std::uint8_t sender) noexcept {
  std::erase_if(frames_, [sender](const PendingFrame& frame) { return frame.sender == sender; });
}

void TransmitQueue::push(const PendingFrame& frame) noexcept {
  frames_[(first_ + size_) % frames_.size()] = frame;
  ++size_;
}

void TransmitQueue::push_front(const PendingFrame& frame) noexcept {
  first_ = (first_ + frames_.size() - 1) % frames_.size();
  frames_[first_] = frame;
  ++size_;
}

void TransmitQueue::pop() noexcept {
  first_ = (first_ + 1) % frames_.size();
  --size_;
}

}  // namespace sim
