#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "can/frame.h"
#include "cansync/ask/question.h"
#include "cansync/channel/parameter_job.h"
#include "cansync/settings/timing.h"
#include "cansync/supervision/answer_balance.h"
#include "cansync/telegram/telegram.h"

namespace cansync::ask {

/// How a question ended.
struct Answer {
  /// What came, if anything.
  enum class Kind : std::uint8_t {
    silent,   ///< nothing came
    value,    ///< a read: the value
    taken,    ///< the slave began the upload, or closed it
    refused,  ///< an error code came
    busy,     ///< the slave went on being busy
  };
  Kind kind = Kind::silent;
  std::uint32_t value = 0;  ///< of a read, raw
  bool doubleword = false;  ///< of a read, as it came
  std::uint16_t error = 0;  ///< with `refused`: the slave's code
  std::uint16_t length =
      0;  ///< with `taken`: length that the slave fixed for the block; 0: it takes the one asked
};

/// Asks one question after the other, without any SYNC: at most one telegram in an interval of the bit rate,
/// each at most `kTries` times, and once an interval while the slave is busy. The manuals leave open whether
/// a drive answers while no SYNC runs: one that does not is silent here. Sans-IO: it is told the time, in any
/// clock that never falls. Nothing allocates, blocks or throws; not thread safe.
class Asker {
 public:
  static constexpr unsigned kTries = 2;
  /// Longest time for which a busy slave is asked again.
  static constexpr Duration kBusyTime = std::chrono::seconds(3);

  /// A line of this bit rate.
  explicit Asker(BitRate rate) noexcept;

  /// The next question; what is left of one before is forgotten.
  void ask(const Question& question, Duration now) noexcept;

  /// The frame to send now, if there is one; it counts as sent.
  std::optional<can::Frame> take(Duration now) noexcept;

  /// The frame of `take` could not be handed over: it is taken again an interval later.
  void left_out() noexcept;

  /// A frame of somebody else.
  void receive(const can::Frame& frame, Duration now) noexcept;

  /// How the question ended; nothing: it is not over at `now`.
  std::optional<Answer> answer(Duration now) noexcept;

  /// When to look again, if no frame comes.
  Duration next() const noexcept;

  /// How often this slave has answered more than it was asked. Two drives of one number do so with each question;
  /// a frame that comes twice after a disturbance counts, too.
  unsigned answers_too_many(SlaveNumber slave) const noexcept { return too_many_[slave.value()]; }

  /// Somebody sends what a master alone sends: nothing more may be asked.
  bool master_heard() const noexcept { return master_heard_; }

 private:
  void weigh(const Telegram& telegram, Duration now) noexcept;
  IntervalNumber interval(Duration now) const noexcept {
    return static_cast<IntervalNumber>(now / interval_);
  }
  bool fits(const Telegram& telegram) const noexcept;
  void parameter(const ParameterReply& reply, Duration now) noexcept;
  void transfer(const TransferReply& reply, Duration now) noexcept;
  void again(Duration now) noexcept;
  void end(const Answer& answer) noexcept { answer_ = answer; }

  Duration interval_;
  Duration patience_;  ///< from a telegram until it is without an answer
  Question question_;
  ParameterJob read_;
  std::optional<Answer> answer_;
  bool open_ = false;     ///< a question was asked
  bool waiting_ = false;  ///< its telegram went out, and no answer came yet
  unsigned tries_ = 0;
  Duration began_{};
  Duration sent_at_{};
  Duration free_at_{};  ///< the next telegram may go out
  bool master_heard_ = false;
  AnswerBalance balance_;
  std::array<unsigned, kSlaves> too_many_ = {};
};

}  // namespace cansync::ask
