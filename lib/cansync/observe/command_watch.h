#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "cansync/observe/line_clock.h"
#include "cansync/observe/observation.h"
#include "cansync/observe/transfer_watch.h"

namespace cansync::observe {

/// A telegram with its time on the bus.
struct OnBus {
  Duration start{};
  Duration end{};
  Duration since_first{};  ///< of the recording's first frame, its start
  Instant at;
};

/// Looks at the command channel: action commands, and what each slave was asked and answered.
class CommandWatch {
 public:
  /// Fills `out`, which must outlive it.
  CommandWatch(Observation& out, const SlotTimes& times) noexcept
      : out_(out), transfers_(out), times_(times) {}

  /// An action command, to any slaves.
  void action(const ActionCommand& action, const OnBus& when);
  /// A parameter or transfer command to `slave`.
  void command(SlaveNumber slave, const Telegram& telegram, const OnBus& when);
  /// An answer; one that fits no command is counted as such.
  void reply(const ParameterReply& reply, const OnBus& when);
  /// The same, to a telegram of a transfer.
  void reply(const TransferReply& reply, const OnBus& when);
  /// The recording is over; what was asked last may have its answer behind the end.
  void finish();

 private:
  /// A write without an answer: is it sent again among the next commands?
  struct LostWrite {
    ParameterCommand command;
    std::optional<std::size_t> step;
    unsigned commands = 0;  ///< to the slave since then
  };
  /// The newest command to a slave.
  struct Asked {
    std::optional<Telegram> telegram;
    Duration end{};
    bool answered = false;
    bool busy = false;
    std::optional<std::size_t> step;  ///< of a write
    std::size_t parameter = kNowhere;
    std::optional<LostWrite> lost_write;
  };
  /// Times at which a parameter was read in operation.
  struct ReadTimes {
    std::optional<IntervalNumber> last;
    std::vector<std::uint32_t> apart;
  };
  static constexpr std::size_t kNowhere = ~std::size_t{0};
  static constexpr std::size_t kMostApart = 256;
  static constexpr unsigned kCommandsUntilGivenUp = 4;

  bool starting_up(Duration since_first) const noexcept;
  void settle(Asked& asked, SlaveNumber slave);
  bool sent_again(Asked& asked, const ParameterCommand* command);
  void parameter(Asked& asked, const ParameterCommand& command, bool again, const OnBus& when);
  std::size_t place_of(const ParameterCommand& command);
  void answered(Asked& asked, SlaveUse& use, const OnBus& when, bool busy, bool error) const noexcept;
  void took_value(ParameterUse& use, std::uint32_t value, bool doubleword, const OnBus& when) const noexcept;

  Observation& out_;
  TransferWatch transfers_;
  const SlotTimes& times_;
  std::array<Asked, kSlaves> asked_ = {};
  std::vector<ReadTimes> read_times_;  ///< as out_.parameters
};

/// Adds a step, or counts on when it is an action equal to the one before. Nothing: there is no room.
std::optional<std::size_t> add_step(Observation& out, Step step);

}  // namespace cansync::observe
