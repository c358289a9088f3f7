#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "can/bus.h"
#include "can/frame_length.h"
#include "sync/sync_wire.h"

namespace cansyncd::test {

/// A bus with a SYNC wire in virtual time for one loop: sends at once, gives back echoes and the answers of
/// `answer`, and can let the thread sleep too long.
class ScriptedBus final : public can::Bus, public sync_line::SyncWire {
 public:
  struct Sent {
    can::Time at{};
    can::Frame frame;
  };

  explicit ScriptedBus(std::uint32_t bits_per_second = 1'000'000) : bits_per_second_(bits_per_second) {}

  /// What somebody answers to a frame of the master, if anything; it follows on the bus at once.
  std::function<std::optional<can::Frame>(const can::Frame&)> answer = [](const can::Frame&) {
    return std::nullopt;
  };
  /// Called whenever the loop sleeps, before time goes on.
  std::function<void(can::Time now)> on_sleep = [](can::Time) {};
  /// How much later than its deadline the thread wakes; asked once for each deadline that is reached.
  std::function<can::Time(can::Time deadline)> lateness = [](can::Time) { return can::Time{0}; };

  bool wakes_on_frame = true;  ///< false: the thread sleeps on to its deadline when a frame comes

  can::SendResult send_result = can::SendResult::queued;
  can::ControllerStatus controller;
  can::ResetResult reset_answer = can::ResetResult::done;
  unsigned resets = 0;

  std::vector<Sent> sent;
  std::vector<Sent> refused;
  std::vector<std::pair<can::Time, can::Time>> edges;  ///< due, and when it was produced

  /// Puts a frame of somebody else on the bus; its last bit stands at `end`.
  void put(const can::Frame& frame, can::Time end) { deliver({frame, end, false}); }

  can::Time now() noexcept override { return now_; }

  can::Wake wait_until(can::Time deadline) noexcept override {
    on_sleep(now_);
    if (deadline <= now_) return can::Wake::deadline;
    if (wakes_on_frame && !arriving_.empty() && arriving_.front().end <= deadline) {
      now_ = std::max(now_, arriving_.front().end);
      return can::Wake::frame;
    }
    now_ = deadline + lateness(deadline);
    return can::Wake::deadline;
  }

  bool receive(can::ReceivedFrame& out) noexcept override {
    if (arriving_.empty() || arriving_.front().end > now_) return false;
    out = arriving_.front();
    arriving_.erase(arriving_.begin());
    return true;
  }

  can::SendResult send(const can::Frame& frame) noexcept override {
    if (send_result != can::SendResult::queued) {
      refused.push_back({now_, frame});
      return send_result;
    }
    sent.push_back({now_, frame});
    const can::Time end = now_ + duration(frame);
    deliver({frame, end, true});
    if (const auto reply = answer(frame)) deliver({*reply, end + duration(*reply), false});
    return send_result;
  }

  void sync_edge(can::Time due) noexcept override { edges.emplace_back(due, now_); }
  can::ControllerStatus status() noexcept override { return controller; }
  can::ResetResult reset() noexcept override {
    ++resets;
    return reset_answer;
  }
  can::ResetResult reset_result() noexcept override { return reset_answer; }
  can::TimestampSource timestamp_source() noexcept override { return can::TimestampSource::simulation; }

 private:
  can::Time duration(const can::Frame& frame) const {
    return can::Time(can::frame_bits(frame) * (1'000'000'000ULL / bits_per_second_));
  }
  void deliver(const can::ReceivedFrame& frame) {
    const auto later =
        std::find_if(arriving_.begin(), arriving_.end(),
                     [&frame](const can::ReceivedFrame& other) { return other.end > frame.end; });
    arriving_.insert(later, frame);
  }

  std::uint32_t bits_per_second_;
  can::Time now_{1'000'000'000};
  std::vector<can::ReceivedFrame> arriving_;
};

}  // namespace cansyncd::test
