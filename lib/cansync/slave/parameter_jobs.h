#pragma once

#include <bitset>
#include <cstdint>
#include <optional>

#include "cansync/slave/parameter_table.h"
#include "cansync/slave/slave.h"
#include "cansync/telegram/errors.h"
#include "cansync/telegram/numbers.h"

namespace cansync {

/// A parameter access of the master that an application is to answer (M 3.2.3.7).
struct AskedParameter {
  std::uint64_t id = 0;  ///< never given twice; 0 is none
  bool write = false;
  ParameterNumber number;
  Element element = kValueElement;
  SubSlave sub_slave;
  bool doubleword = false;  ///< write: its format
  std::uint32_t value = 0;  ///< write: the raw value
  friend bool operator==(const AskedParameter&, const AskedParameter&) = default;
};

/// Is told of the accesses that wait for an application. Called on the slave's thread; must not allocate,
/// block or throw, nor call back.
class ParameterJobsListener {
 public:
  virtual ~ParameterJobsListener() = default;
  /// An access waits for `answer`. The master is told that it takes longer.
  virtual void asked(const AskedParameter& job) noexcept = 0;
  /// The access is not wanted any more: the master asked for something else, the application that owned it is
  /// gone or took too long, the master did not fetch the answer, or the slave left synchronous operation.
  /// Also when its answer was given and never on the bus.
  virtual void dropped(std::uint64_t id) noexcept = 0;
  /// The answer of the application was on the bus.
  virtual void answered(std::uint64_t id) noexcept = 0;
};

/// What numbers that are not in the table, and sub-slaves, are to an application; and how long it has.
struct ParameterJobsSettings {
  bool unknown_numbers = false;  ///< an application is asked for them; else `unknown`
  bool sub_slaves = false;       ///< likewise for sub-slave addresses over 0; else 0xFFFB
  ParameterError unknown = ParameterError::not_present;  ///< answer for them that is nobody's
  /// In which an application has to answer, 0: it is waited for without end; and for which its answer waits
  /// for the master, at least a second.
  Duration answer_time{};
};

/// What an application has taken over, beside what the settings give it anyway.
struct TakenOver {
  std::bitset<ParameterNumber::max + 1> numbers;  ///< in the table or not
  bool sub_slaves = false;                        ///< every parameter of sub-slave addresses over 0
};

/// Answers the master's parameter accesses: from the table at once, or from an application, busy until it has
/// answered. One access is open at a time. Without an application what it had taken over is the table's
/// again, or answered with the error that the definition says; what is its own by the settings with 0xFFFA.
/// When it goes or its time is over, what is open ends with the master's next question in that way, and a
/// write with an error, because nobody knows whether it was taken. A write that the table refuses (access,
/// format, limits) does not reach the application. Each access that the application is asked for ends once:
/// dropped, or answered; an answer after that is refused. Nothing allocates, blocks or throws; not thread
/// safe.
class ParameterJobs {
 public:
  /// `table` and `listener` must outlive this.
  ParameterJobs(const ParameterJobsSettings& settings, ParameterTable& table,
                ParameterJobsListener& listener) noexcept
      : settings_(settings), table_(table), listener_(listener) {}

  // --- of the slave, from its `SlaveApplication`

  /// The slave's `read_parameter`; asked again with the same arguments while it answers busy.
  ParameterAnswer read(ParameterNumber number, Element element, SubSlave sub) noexcept;
  /// The slave's `write_parameter`, likewise.
  ParameterAnswer write(ParameterNumber number, Element element, SubSlave sub, bool doubleword,
                        std::uint32_t value) noexcept;
  /// The access answered busy last is not wanted any more, nor is an answer that was not on the bus.
  void dropped() noexcept;
  /// The slave's `keeps_answer`: the master asks for its write again within the time of an answer.
  bool keeps_answer() noexcept;
  /// The answer was on the bus (`SlaveApplication::parameter_answered`).
  void sent() noexcept;

  /// Tells the time, on any one clock, in every interval; ends an access whose application took too long,
  /// or whose answer the master has not asked for in that time, at least a second, fetched and never on the
  /// bus or not fetched at all: the same question later is a new one.
  void at(Duration now) noexcept;

  // --- of the application

  /// There is one (its lease runs), or there is none (any more): it has taken over nothing then.
  void set_application(bool present) noexcept;
  /// What the application that is there has taken over. What is open stays its as long as its number does,
  /// else it ends as when the application goes.
  void take_over(const TakenOver& taken) noexcept;
  /// The application's answer, which goes out with the master's next question; `busy` in it counts as not
  /// given. False: that access is not open, or was answered.
  bool answer(std::uint64_t id, const ParameterAnswer& answer) noexcept;
  /// The access that is open; nothing: none is.
  const std::optional<AskedParameter>& open() const noexcept { return open_; }

 private:
  bool belongs_to_application(ParameterNumber number, SubSlave sub) const noexcept;
  ParameterAnswer ask(const AskedParameter& job) noexcept;
  bool is_open(const AskedParameter& job) noexcept;
  ParameterAnswer answer_to_open() noexcept;
  ParameterAnswer without_application(const AskedParameter& job) const noexcept;
  void end_open() noexcept;
  void forget_sending() noexcept;
  Duration keeping() const noexcept;

  ParameterJobsSettings settings_;
  ParameterTable& table_;
  ParameterJobsListener& listener_;
  bool application_ = false;
  TakenOver taken_;
  Duration now_{};
  Duration asked_at_{};
  Duration answered_at_{};
  Duration questioned_at_{};  ///< the master's newest question
  std::optional<AskedParameter> open_;
  std::optional<ParameterAnswer> answer_;  ///< of the open access
  std::uint64_t sending_ = 0;              ///< the access whose answer is on its way
  std::uint64_t ids_ = 0;
};

}  // namespace cansync
