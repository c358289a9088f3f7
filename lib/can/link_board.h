#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "can/bus.h"

namespace can {

/// What the link watch and the realtime thread tell each other about an interface. Wait-free on both sides;
/// each value stands for itself.
class LinkBoard {
 public:
  /// What the interface is, and the socket that is bound to it, as they go together.
  struct Link {
    std::uint32_t index = 0;  ///< 0: missing, or one that must not be used
    LinkState state = LinkState::missing;
    int socket = -1;  ///< descriptor, at most `BusSockets::kMost`; -1: none
  };
  /// State of the controller as the driver tells it when asked.
  struct Controller {
    ControllerState state = ControllerState::error_active;
    std::uint8_t transmit_errors = 0;
    std::uint8_t receive_errors = 0;
  };

  // --- link watch

  void set_link(Link link) noexcept {
    link_.store((std::uint64_t{link.index} << 32) | (static_cast<std::uint64_t>(link.socket + 1) << 8) |
                static_cast<std::uint64_t>(link.state));
  }
  /// The socket that the realtime thread uses, or may be about to; to be asked after `set_link`. A socket of an earlier
  /// `set_link` that is another one is used no more.
  int socket_in_use() const noexcept { return socket_in_use_.load(); }
  void set_bit_rate(std::uint32_t bits_per_second) noexcept {
    bits_per_second_.store(bits_per_second, std::memory_order_relaxed);
  }
  /// The controller tries each frame once.
  void set_one_shot(bool on) noexcept { one_shot_.store(on, std::memory_order_relaxed); }
  /// To be taken before the driver is asked; an error frame that comes meanwhile knows better.
  std::uint32_t era() const noexcept { return era_.load(std::memory_order_acquire); }
  void set_controller(const Controller& controller, std::uint32_t era) noexcept {
    const std::uint64_t known = 1;
    controller_.store((std::uint64_t{era} << 32) | (known << 24) |
                          (static_cast<std::uint64_t>(controller.state) << 16) |
                          (std::uint64_t{controller.transmit_errors} << 8) | controller.receive_errors,
                      std::memory_order_release);
  }
  /// Number of the reset that is wanted, and of the last one that was answered.
  std::uint32_t reset_wanted() const noexcept { return reset_wanted_.load(std::memory_order_acquire); }
  std::uint32_t reset_answered() const noexcept { return static_cast<std::uint32_t>(reset_.load() >> 8); }
  void answer_reset(std::uint32_t number, ResetResult result) noexcept {
    reset_.store((std::uint64_t{number} << 8) | static_cast<std::uint64_t>(result),
                 std::memory_order_release);
  }

  // --- realtime thread

  Link link() const noexcept {
    const std::uint64_t word = link_.load();
    return {static_cast<std::uint32_t>(word >> 32), static_cast<LinkState>(word & 0xFFu),
            static_cast<int>(word >> 8 & 0xFFFFFFu) - 1};
  }
  /// Takes the socket of `link` into use, in the place of the one before. False: the watch has exchanged it meanwhile,
  /// and none is in use.
  bool use_socket(int socket) noexcept {
    // In this order on both sides: either the watch sees that it is used, or this sees that it is another one.
    socket_in_use_.store(socket);
    if (link().socket == socket) return true;
    socket_in_use_.store(-1);
    return false;
  }
  std::uint32_t bit_rate() const noexcept { return bits_per_second_.load(std::memory_order_relaxed); }
  bool one_shot() const noexcept { return one_shot_.load(std::memory_order_relaxed); }
  /// An error frame has told the controller's state: what the driver was asked before is out of date.
  void begin_era() noexcept { era_.fetch_add(1, std::memory_order_acq_rel); }
  /// What the driver said, if nothing newer is known.
  std::optional<Controller> controller() const noexcept {
    const std::uint64_t word = controller_.load(std::memory_order_acquire);
    if ((word >> 24 & 1u) == 0) return std::nullopt;
    if (static_cast<std::uint32_t>(word >> 32) != era_.load(std::memory_order_relaxed)) return std::nullopt;
    return Controller{static_cast<ControllerState>(word >> 16 & 0xFFu),
                      static_cast<std::uint8_t>(word >> 8 & 0xFFu), static_cast<std::uint8_t>(word & 0xFFu)};
  }
  void want_reset(std::uint32_t number) noexcept { reset_wanted_.store(number, std::memory_order_release); }
  /// What became of reset `number`; nothing: not answered yet.
  std::optional<ResetResult> reset_result(std::uint32_t number) const noexcept {
    const std::uint64_t word = reset_.load(std::memory_order_acquire);
    if (static_cast<std::uint32_t>(word >> 8) != number) return std::nullopt;
    return static_cast<ResetResult>(word & 0xFFu);
  }

 private:
  std::atomic<std::uint64_t> link_{static_cast<std::uint64_t>(LinkState::missing)};
  std::atomic<std::uint32_t> bits_per_second_{0};
  std::atomic<int> socket_in_use_{-1};
  std::atomic<bool> one_shot_{false};
  std::atomic<std::uint64_t> controller_{0};
  std::atomic<std::uint32_t> era_{0};
  std::atomic<std::uint32_t> reset_wanted_{0};
  std::atomic<std::uint64_t> reset_{0};
};

}  // namespace can
