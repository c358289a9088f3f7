#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cansync/telegram/telegram.h"
#include "daemon/cansync/exchange.h"
#include "plan.h"
#include "reference_truth.h"
#include "sent_truth.h"
#include "sim/line.h"
#include "stage_bus.h"
#include "stop_truth.h"

namespace cansyncd::campaign {

/// A telegram that the realtime loop handed to its bus.
struct HandOver {
  can::Frame frame;
  std::optional<cansync::Telegram> telegram;  ///< empty: the frame is none
  can::Time at{};
  bool accepted = false;
  cansync::IntervalNumber interval = 0;  ///< of the last SYNC edge
  can::Time due{};                       ///< when that edge was due
};

/// A SYNC edge.
struct Edge {
  cansync::IntervalNumber number = 0;
  can::Time due{};
  can::Time made{};
};

/// A frame of the master as it stood on the bus.
struct MasterFrame {
  can::Frame frame;
  can::Time since_edge{};
  std::uint64_t edge = 0;  ///< edges before, as the line counts them
};

/// An actual value telegram that reached the master.
struct Arrival {
  cansync::ActualTelegram telegram;
  can::Time start{};
  can::Time end{};
};

/// A reference telegram that asks a slave for its actual values, on the bus.
struct Question {
  cansync::Channel channel = cansync::Channel::one;
  std::uint8_t polled = cansync::kPollNobody;
  cansync::IntervalNumber interval = 0;  ///< in which it was handed over
  can::Frame frame;
  can::Time start = can::Time::max();  ///< on the bus; not yet, or never: the greatest time
};

/// Writes down what happens: what the loop does with its bus, and what stands on it. What concerns one
/// interval is kept until `forget_interval`.
class Witness final : public BusObserver, private sim::TraceSink {
 public:
  explicit Witness(const Plan& plan) : plan_(plan) {}

  sim::TraceSink& trace() noexcept { return *this; }
  /// Follows a line's edges from here on; the line must outlive the witness.
  void follow(const sim::Line& line) noexcept { line_ = &line; }

  /// Called when the loop has done what there was to do and waits.
  std::function<void(can::Time now)> on_wait = [](can::Time) {};
  /// Called with every frame on the bus and every edge, in words; null: nobody wants to know.
  std::function<void(const std::string&)> on_line;

  // --- of the running interval
  std::vector<HandOver> handed;
  std::vector<Edge> edges;
  std::vector<MasterFrame> frames;

  // --- since the start
  std::optional<Edge> last_edge;
  std::deque<Edge> recent_edges;   ///< the last few
  std::deque<Arrival> arrivals;    ///< likewise
  std::deque<Question> questions;  ///< likewise
  std::array<std::array<std::uint64_t, cansync::kChannels>, cansync::kSlaves> arrived = {};
  std::uint64_t edges_made = 0;
  std::uint64_t accepted = 0;     ///< telegrams the bus took
  std::uint64_t refused = 0;      ///< and those it refused
  std::uint64_t frames_seen = 0;  ///< frames on the bus
  ReferenceTruth references;
  StopTruth stops;
  SentTruth sent;

  void forget_interval() noexcept {
    handed.clear();
    edges.clear();
    frames.clear();
  }
  /// A number that depends on everything that happened.
  std::uint64_t digest() const noexcept { return digest_; }
  void digest(std::uint64_t more) noexcept { digest_ = (digest_ ^ more) * 0x100000001B3u + (digest_ >> 29); }

 private:
  // the loop's side
  void waits(can::Time now) noexcept override { on_wait(now); }
  void edge(can::Time due, can::Time now) noexcept override;
  void handed_over(const can::Frame& frame, can::Time now, can::SendResult result) noexcept override;
  void received(const can::ReceivedFrame& frame) noexcept override;
  // the line's side
  void frame(const sim::TracedFrame& traced) noexcept override;
  void sync(can::Time at) noexcept override;

  struct Begun {
    can::Frame frame;
    can::Time start{};
    can::Time end{};
  };

  const Plan& plan_;
  const sim::Line* line_ = nullptr;
  std::deque<Begun> begun_;  ///< actual value telegrams whose start is known
  can::Time last_start_{};   ///< of a frame of the master on the bus
  can::Time last_end_{};     ///< of that frame
  std::uint64_t digest_ = 0xCBF29CE484222325u;
};

}  // namespace cansyncd::campaign
