#pragma once

#include <algorithm>
#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "can/candump.h"
#include "simulator/bench.h"
#include "simulator/port.h"

/// Frames as candump writes them, `identifier#data`.
inline can::Frame frame(const std::string& text) {
  return std::get<can::Frame>(can::parse_candump_frame(text));
}

inline std::string frame_text(const can::Frame& frame) {
  std::array<char, can::kCandumpLineLimit> line{};
  const std::size_t size = can::write_candump_line({}, "x", frame, line);
  const std::string all(line.data(), size);
  const std::size_t at = all.rfind(' ') + 1;
  return all.substr(at, all.size() - at - 1);
}

/// Drives of these numbers at 500 kbit/s (an interval of 2 ms), which lock after 10 ms.
inline std::vector<std::unique_ptr<sim::Drive>> drives(const std::vector<unsigned>& numbers) {
  std::vector<std::unique_ptr<sim::Drive>> out;
  for (const unsigned number : numbers) {
    sim::DriveSettings settings;
    settings.slave.number = *cansync::SlaveNumber::from(number);
    settings.slave.bit_rate = cansync::BitRate::kbit500;
    settings.lock_time = std::chrono::milliseconds(10);
    settings.processing_delay = cansync::Duration{0};
    out.push_back(std::make_unique<sim::Drive>(settings));
  }
  return out;
}

inline cansync_sim::BenchSettings bench_settings(std::vector<sim::Fault> faults = {}) {
  cansync_sim::BenchSettings settings;
  settings.sync_identifier = 0x080;
  settings.bit_rate = cansync::BitRate::kbit500;
  settings.faults = std::move(faults);
  return settings;
}

/// An interface in virtual time: delivers what a script holds ready, keeps what is sent.
class ScriptedPort final : public cansync_sim::Port {
 public:
  struct Sent {
    can::Time at;
    std::string frame;
    friend bool operator==(const Sent&, const Sent&) = default;
  };

  /// `frame` arrives at `at`; instants must not fall.
  void arrives(can::Time at, const std::string& text) { incoming_.push_back({frame(text), at, false}); }
  /// From `at` on the link is in this state.
  void link_becomes(can::Time at, cansync_sim::Link link) { links_.emplace_back(at, link); }
  /// Frames sent from `at` on meet this result.
  void sending_becomes(can::Time at, can::SendResult result) { results_.emplace_back(at, result); }
  /// The wish to stop comes at `at`.
  void stops(can::Time at) { stop_ = at; }

  const std::vector<Sent>& sent() const { return sent_; }

  can::Time now() noexcept override { return now_; }
  bool wait(can::Time deadline) noexcept override {
    can::Time until = std::min(deadline, stop_);
    if (!incoming_.empty()) until = std::min(until, incoming_.front().end);
    for (const auto& change : links_) {
      if (change.first > now_) until = std::min(until, change.first);
    }
    now_ = std::max(now_, until);
    return now_ < stop_;
  }
  bool receive(can::ReceivedFrame& out) noexcept override {
    if (incoming_.empty() || incoming_.front().end > now_) return false;
    out = incoming_.front();
    incoming_.pop_front();
    return true;
  }
  can::SendResult send(const can::Frame& frame) noexcept override {
    const can::SendResult result = as_of(results_, can::SendResult::queued);
    if (result == can::SendResult::queued) sent_.push_back({now_, frame_text(frame)});
    return result;
  }
  cansync_sim::Link link() noexcept override { return as_of(links_, cansync_sim::Link::up); }
  std::uint64_t dropped() noexcept override { return 0; }

 private:
  template <class State>
  State as_of(const std::vector<std::pair<can::Time, State>>& changes, State state) const {
    for (const auto& change : changes) {
      if (change.first <= now_) state = change.second;
    }
    return state;
  }

  can::Time now_{};
  can::Time stop_ = can::Time::max();
  std::deque<can::ReceivedFrame> incoming_;
  std::vector<std::pair<can::Time, cansync_sim::Link>> links_;
  std::vector<std::pair<can::Time, can::SendResult>> results_;
  std::vector<Sent> sent_;
};
