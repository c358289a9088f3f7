#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <deque>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "can/bus.h"
#include "can/candump.h"
#include "can/frame.h"
#include "sim/node.h"
#include "sim/trace.h"

namespace sim::test {

/// A frame in candump's notation: "17F#0011".
inline can::Frame frame(std::string_view text) {
  const auto parsed = can::parse_candump_frame(text);
  if (const auto* error = std::get_if<can::CandumpError>(&parsed)) {
    ADD_FAILURE() << text << ": " << error->message;
    return {};
  }
  return std::get<can::Frame>(parsed);
}

/// A frame as text, for comparisons that read well when they fail.
inline std::string text(const can::Frame& frame) {
  std::array<char, can::kCandumpLineLimit> buffer;
  const std::size_t size = can::write_candump_line({}, "x", frame, buffer);
  const std::string line(buffer.data(), size - 1);
  return line.substr(line.rfind(' ') + 1);
}

inline can::Time us(double microseconds) {
  return can::Time(static_cast<std::int64_t>(microseconds * 1000));
}

/// A node that knows what comes: `node.expect("105#00").reply("585#00", us(20))`. A frame that is not
/// expected next fails the test, and so does the destructor when the script is not used up.
class ScriptedNode final : public Node {
 public:
  explicit ScriptedNode(unsigned number) : number_(static_cast<NodeNumber>(number)) {}
  ~ScriptedNode() override {
    for (const Step& step : script_) {
      ADD_FAILURE() << "node " << unsigned{number_} << " still expects " << step.expected;
    }
  }
  ScriptedNode(const ScriptedNode&) = delete;
  ScriptedNode& operator=(const ScriptedNode&) = delete;

  /// The next frame that comes must be `expected`.
  ScriptedNode& expect(std::string_view expected) {
    script_.push_back({std::string(expected), std::nullopt, {}});
    return *this;
  }
  /// The frame expected last is answered with `answer`, ready `after` its end.
  ScriptedNode& reply(std::string_view answer, can::Time after = {}) {
    script_.back().answer = frame(answer);
    script_.back().after = after;
    return *this;
  }

  NodeNumber node_number() const noexcept override { return number_; }
  bool accepts(const can::Frame&) const noexcept override { return true; }
  void on_sync(can::Time) noexcept override {}
  std::optional<Transmission> on_frame(const can::Frame& received, can::Time end) noexcept override {
    const std::string found = text(received);
    if (script_.empty()) {
      ADD_FAILURE() << "node " << unsigned{number_} << " expects nothing, got " << found;
      return std::nullopt;
    }
    const Step step = script_.front();
    script_.pop_front();
    EXPECT_EQ(found, step.expected) << "node " << unsigned{number_};
    if (!step.answer) return std::nullopt;
    return Transmission{*step.answer, end + step.after};
  }

 private:
  struct Step {
    std::string expected;
    std::optional<can::Frame> answer;
    can::Time after{};
  };
  NodeNumber number_;
  std::deque<Step> script_;
};

/// A node that accepts some identifiers, notes what it hears, and answers nothing.
class ListeningNode final : public Node {
 public:
  struct Heard {
    std::string frame;
    can::Time end;
  };
  explicit ListeningNode(unsigned number, std::uint32_t identifier = 0, std::uint32_t mask = 0)
      : number_(static_cast<NodeNumber>(number)), identifier_(identifier), mask_(mask) {}

  bool every_kind = false;  ///< remote and extended frames too
  std::vector<Heard> heard;
  std::vector<can::Time> syncs;

  NodeNumber node_number() const noexcept override { return number_; }
  bool accepts(const can::Frame& frame) const noexcept override {
    return (frame.id & mask_) == (identifier_ & mask_) && (every_kind || frame.is_standard_data());
  }
  void on_sync(can::Time now) noexcept override { syncs.push_back(now); }
  std::optional<Transmission> on_frame(const can::Frame& received, can::Time end) noexcept override {
    heard.push_back({text(received), end});
    return std::nullopt;
  }

 private:
  NodeNumber number_;
  std::uint32_t identifier_;
  std::uint32_t mask_;
};

/// Notes everything on the line, one text each: "12.500 master 105#0011", "0.000 SYNC".
class RecordingTrace final : public TraceSink {
 public:
  std::vector<std::string> lines;
  std::vector<TracedFrame> frames;
  std::vector<can::Time> syncs;

  void frame(const TracedFrame& traced) noexcept override {
    frames.push_back(traced);
    std::string who = "foreign";
    if (traced.sender.kind == Sender::Kind::master) who = "master";
    if (traced.sender.kind == Sender::Kind::node) who = "slave " + std::to_string(traced.sender.node);
    lines.push_back(std::to_string(traced.start.count()) + " " + who + " " + text(traced.frame));
  }
  void sync(can::Time at) noexcept override {
    syncs.push_back(at);
    lines.push_back(std::to_string(at.count()) + " SYNC");
  }
};

/// Takes everything the master has received.
inline std::vector<can::ReceivedFrame> receive_all(can::Bus& bus) {
  std::vector<can::ReceivedFrame> all;
  can::ReceivedFrame received;
  while (bus.receive(received)) all.push_back(received);
  return all;
}

/// Lets the bus run until `instant` and returns all the master has received by then.
inline std::vector<can::ReceivedFrame> run_until(can::Bus& bus, can::Time instant) {
  std::vector<can::ReceivedFrame> all;
  while (true) {
    const can::Wake wake = bus.wait_until(instant);
    for (const can::ReceivedFrame& received : receive_all(bus)) all.push_back(received);
    if (wake == can::Wake::deadline && bus.now() >= instant) return all;
  }
}

}  // namespace sim::test
