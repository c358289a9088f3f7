#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "can/frame.h"
#include "cansync/telegram/numbers.h"
#include "cansync/telegram/telegram.h"

namespace cansync {

/// Why a well-formed telegram of a slave is not taken.
enum class Unexpected : std::uint8_t {
  wrong_slave,   ///< another slave is asked
  wrong_answer,  ///< its slave is asked, but for another number, offset, format or kind of answer
  late,          ///< its slave was asked, and is no longer waited for
  duplicate,     ///< the same as the telegram that was taken last
  unasked,       ///< nobody is asked
};
inline constexpr unsigned kUnexpectedKinds = 5;

/// A short English word group for counters.
std::string_view name(Unexpected kind) noexcept;

/// Tells what is wrong with a telegram that nobody takes. It remembers of each slave what was taken last and
/// whether an answer is still owed, for the command channel and both actual value channels. Realtime safe;
/// not thread safe.
class Strays {
 public:
  /// `slave` was asked with a command, and its answer is given up.
  void given_up(SlaveNumber slave) noexcept { owed_[kResponse].set(slave); }
  /// `slave` was asked for actual values in the interval that is over, and sent none.
  void missed(Channel channel, SlaveNumber slave) noexcept { owed_[index(channel)].set(slave); }

  /// `frame`, which is `telegram` of a slave, was taken.
  void taken(const can::Frame& frame, const Telegram& telegram) noexcept;

  /// What kind of stray `frame` is; `asked` is the slave that is asked on its channel now.
  Unexpected judge(const can::Frame& frame, const Telegram& telegram,
                   std::optional<SlaveNumber> asked) noexcept;

  /// Where a telegram of a slave belongs.
  struct Origin {
    unsigned place;  ///< the actual value channels by their index, then the responses to commands
    SlaveNumber slave;
  };
  /// Of a telegram that a slave has sent.
  static Origin origin(const Telegram& telegram) noexcept;

 private:
  static constexpr unsigned kResponse = kChannels;
  static constexpr unsigned kPlaces = kChannels + 1;

  std::array<SlaveMask, kPlaces> owed_ = {};
  std::array<SlaveMask, kPlaces> known_ = {};  ///< `last_` holds something
  std::array<std::array<can::Frame, kSlaves>, kPlaces> last_ = {};
};

}  // namespace cansync
