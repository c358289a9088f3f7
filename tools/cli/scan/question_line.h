#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "cansync/ask/asker.h"
#include "cli/scan/line_port.h"

namespace cansync::cli {

/// Asks questions on a line and waits for their answers. What it sends are questions and nothing else: it has
/// no function that takes a frame.
class QuestionLine {
 public:
  /// `stop` ends it between two questions; all outlive it.
  QuestionLine(LinePort& port, BitRate rate, const std::atomic<bool>& stop)
      : port_(port), asker_(rate), stop_(stop), interval_(slot_times(rate).interval) {}

  /// The answer; nothing when it was stopped before. Throws std::runtime_error when a master is heard, and when the
  /// line takes no frames, with the remedy. In each of these cases a `CloseQuestion` is asked all the same, and
  /// follows on a `BlockQuestion` that had gone out.
  std::optional<ask::Answer> ask(const ask::Question& question);

  /// Time from one question to the next at least.
  Duration interval() const noexcept { return interval_; }
  /// Two drives answer as this slave: it has answered twice, and again.
  bool two_answer(SlaveNumber slave) const noexcept { return asker_.answers_too_many(slave) >= kTwoDrives; }
  /// Telegrams that were sent.
  std::uint64_t sent() const noexcept { return sent_; }

 private:
  static constexpr unsigned kTwoDrives = 2;  ///< once, a frame may come twice

  std::optional<ask::Answer> wait_for_answer(const ask::Question& question);
  void close(SlaveNumber slave) noexcept;
  void take_frames();
  void send(const can::Frame& frame);

  LinePort& port_;
  ask::Asker asker_;
  const std::atomic<bool>& stop_;
  Duration interval_;
  std::uint64_t sent_ = 0;
  std::uint64_t error_frames_ = 0;
  unsigned refused_ = 0;  ///< times in a row that a frame was not taken
};

}  // namespace cansync::cli
