#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "sim/trace.h"

namespace sim::test {

/// Judges every telegram of a slave on a line by the rules of the manual (M 3.1.1.1, 3.2.0.1), with the
/// manual's own numbers; it uses nothing of the decoder and the slot times under test. The line's edges stand
/// at whole intervals from 0 on.
class SlotJudge final : public TraceSink {
 public:
  explicit SlotJudge(std::uint32_t bits_per_second) : rule_(rule_of(bits_per_second)) {}

  /// What was wrong, in words; empty: nothing.
  std::vector<std::string> wrong;
  /// Frames by channel, that is, the identifier without the slave's number.
  std::map<std::uint32_t, unsigned> count;
  std::vector<TracedFrame> responses;

  void sync(can::Time) noexcept override {}
  void frame(const TracedFrame& traced) noexcept override {
    if (traced.frame.error) return;
    begin_interval(traced.start.count() / (rule_.interval * 1000));
    const std::uint32_t number = traced.frame.id % 128;
    const std::uint32_t channel = traced.frame.id - number;
    ++count[channel];
    switch (channel) {
      case 0x100:
        return asked(0, number);
      case 0x180:
        return asked(1, number);
      case 0x300:
        return actual(0, number, traced, rule_.rdc1);
      case 0x380:
        return actual(1, number, traced, rule_.rdc2);
      case 0x500:
        commands_[number] = traced.end;
        return;
      case 0x580:
        responses.push_back(traced);
        return response(number, traced);
      default:
        return;
    }
  }

 private:
  /// The manual's table, in microseconds after the falling edge.
  struct Rule {
    std::int64_t interval, rc, rdc1, rdc2, cc, rspto;
  };
  static Rule rule_of(std::uint32_t bits_per_second) {
    switch (bits_per_second) {
      case 125'000:
        return {8000, 1920, 4310, 6640, 7680, 2100};
      case 250'000:
        return {4000, 900, 2100, 3290, 3810, 1100};
      case 500'000:
        return {2000, 460, 1060, 1630, 1890, 600};
      default:
        return {1000, 210, 520, 820, 950, 300};
    }
  }

  void begin_interval(std::int64_t interval) {
    if (interval == interval_) return;
    had_references_ = references_ && interval == interval_ + 1;
    references_ = false;
    asked_ = {-1, -1};
    interval_ = interval;
  }
  std::int64_t since(can::Time at) const { return at.count() - interval_ * rule_.interval * 1000; }
  void asked(unsigned channel, std::uint32_t number) {
    references_ = true;
    asked_[channel] = number;
  }
  void say(const TracedFrame& traced, const std::string& what) {
    if (wrong.size() < 20) {
      wrong.push_back("interval " + std::to_string(interval_) + ", " + std::to_string(since(traced.start)) +
                      " ns, identifier " + std::to_string(traced.frame.id) + ": " + what);
    }
  }
  void actual(unsigned channel, std::uint32_t number, const TracedFrame& traced, std::int64_t latest) {
    if (asked_[channel] != static_cast<std::int64_t>(number))
      say(traced, "not asked in this interval, or asked once and answered twice");
    asked_[channel] = -1;
    if (since(traced.start) > latest * 1000) say(traced, "after its slot");
  }
  void response(std::uint32_t number, const TracedFrame& traced) {
    const auto command = commands_.find(number);
    if (command == commands_.end()) return say(traced, "no command was there, or it was answered");
    if (traced.start - command->second > can::Time(rule_.rspto * 1000)) say(traced, "after tRSPTO");
    commands_.erase(command);
    const bool set_up = !references_ && !had_references_;
    if (since(traced.start) > (set_up ? rule_.cc : rule_.rc) * 1000) say(traced, "after its slot");
  }

  Rule rule_;
  std::int64_t interval_ = -1;
  bool references_ = false;
  bool had_references_ = false;
  std::array<std::int64_t, 2> asked_ = {-1, -1};
  std::map<std::uint32_t, can::Time> commands_;
};

}  // namespace sim::test
