#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "can/link_board.h"
#include "can/link_facts.h"
#include "can/link_kernel.h"
#include "can/socketcan/bus_sockets.h"

namespace can {

/// Watches the interface of a bus, binds a socket to it and carries out resets, on a thread of normal priority; the
/// realtime thread learns of it through the board alone.
class LinkWatch {
 public:
  struct Settings {
    std::string interface;              ///< its name; it may come, go, and come back as another one
    std::uint32_t bits_per_second = 0;  ///< the bit rate it must have
    bool one_shot = false;              ///< it must be in one-shot mode, when it is a real controller
    AdapterPin adapter = {};            ///< which adapter it must have
  };

  /// All three must outlive the watch.
  LinkWatch(LinkKernel& kernel, LinkBoard& board, BusSockets& sockets, Settings settings)
      : kernel_(kernel), board_(board), sockets_(sockets), settings_(std::move(settings)) {}

  /// Reads the interface once and tells the board; then carries out a reset that is wanted. Returns what it
  /// has read.
  LinkFacts look();

  /// Looks whenever something has changed, and once a second, until `stop`; `told` is called with every
  /// reading that differs from the one before, on this thread, before the board has it.
  void run(const std::stop_token& stop, const std::function<void(const LinkFacts&)>& told);

 private:
  /// What stands in the way on an interface with these facts.
  LinkState state_of(const LinkFacts& facts) const noexcept;
  void publish(const LinkFacts& facts, std::uint32_t era);
  ResetResult reset(const LinkFacts& facts);
  /// An interface that a reset has left down, because it could not be set up at once.
  void set_up_again(LinkFacts& facts);

  LinkKernel& kernel_;
  LinkBoard& board_;
  BusSockets& sockets_;
  Settings settings_;
  std::function<void(const LinkFacts&)> told_;  ///< while `run` does
  std::optional<LinkFacts> last_told_;
  std::optional<std::uint32_t> left_down_;  ///< index of an interface that a reset has left down
};

/// What stands in the way of a bus of `bits_per_second` on an interface; with `one_shot`, also a real
/// controller that repeats frames; and an adapter that `adapter` does not allow.
LinkState link_state(const LinkFacts& facts, std::uint32_t bits_per_second, bool one_shot = false,
                     const AdapterPin& adapter = {}) noexcept;

}  // namespace can
