#pragma once

#include <cstdint>
#include <string_view>

#include "cansync/settings/settings.h"
#include "cansync/telegram/numbers.h"

namespace cansync {

/// Whether a master may send on its bus.
enum class BusAccess : std::uint8_t {
  granted,       ///< it may: no other master was received while it listened, or a command accepts the other
  away,          ///< it must not: the bus is not there, so nothing can be received
  listening,     ///< it must not yet: it has not listened for `StartupSettings::listen`
  other_master,  ///< it must not: another master has sent within the last 3 s
};
/// A stable word for an access, e.g. "other_master"; the text lives as long as the program.
std::string_view name(BusAccess access) noexcept;

/// Decides whether a master may send: it listens before its first frame and after each loss of the bus, and
/// another master keeps it silent until that one has been quiet for 3 s.
///
/// Time counts in intervals that have really passed, one call of `pass_interval` each, so a thread that was
/// suspended has listened to nothing meanwhile. Realtime safe; not thread safe.
class SoleMaster {
 public:
  /// `listen`: see `StartupSettings::listen`. `interval`: tSYNC.
  SoleMaster(Duration listen, Duration interval) noexcept;

  /// An interval passes. Returns how many frames of another master there were when that one has now been
  /// quiet for long enough, else 0.
  std::uint64_t pass_interval() noexcept;

  /// Another master has sent `identifier`, 0: a SYNC. True for the first frame since there was none.
  bool heard(std::uint32_t identifier) noexcept;

  /// The bus is not there.
  void bus_away() noexcept { away_ = true; }
  /// The bus is there again: what happened on it meanwhile is not known.
  void bus_returned() noexcept;

  /// The bus is taken as it is, unheard and with whoever sends there, until the other master is gone, or the
  /// listening over; also until the bus was away, or `accept_nobody`.
  void accept() noexcept { accepted_ = true; }
  /// Another master that sends is accepted no longer.
  void accept_nobody() noexcept { accepted_ = false; }

  /// As of now, with what is accepted.
  BusAccess access() const noexcept;
  /// `access` is `BusAccess::granted`.
  bool granted() const noexcept { return access() == BusAccess::granted; }
  /// As `access`, whatever was accepted.
  BusAccess unforced() const noexcept;

  /// Another master has sent within the last 3 s.
  bool other() const noexcept { return row_ != 0; }
  /// Of its newest frame; 0: there is no other master, or a SYNC was its newest.
  std::uint32_t other_identifier() const noexcept { return other() ? identifier_ : 0; }

 private:
  const Duration interval_;
  const std::uint64_t needed_;  ///< whole intervals to listen; 0: none
  std::uint64_t listened_ = 0;  ///< intervals since the bus is there
  std::uint64_t quiet_ = 0;     ///< intervals since the other master's newest frame
  std::uint64_t row_ = 0;       ///< its frames since it was reported; 0: there is none
  std::uint32_t identifier_ = 0;
  bool away_ = false;
  bool accepted_ = false;
};

}  // namespace cansync
