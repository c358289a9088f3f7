#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "can/bus.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/realtime/reporter.h"

namespace cansyncd {

/// Reports on the edge what becomes of the bus: interface, controller, sending, and faults that repeat, which
/// are counted until they have stayed away for 3 s. Realtime thread only; realtime safe.
class BusWatch {
 public:
  /// Both must outlive the watch.
  BusWatch(can::Bus& bus, Reporter& reporter) noexcept : bus_(bus), reporter_(reporter) {}

  /// Takes the state the bus is in as the one that needs no report; an interface that is not up does.
  void begin() noexcept;

  /// A telegram was handed to the bus.
  void sent(can::SendResult result) noexcept;

  /// Looks at the bus, once an interval; `now` is the bus's time.
  void look(can::Time now) noexcept;

  /// True when telegrams reach the bus, as far as is known: the interface is up, somebody acknowledges, and
  /// the controller has not been off the bus for a second.
  bool connected() const noexcept {
    return status_.link == can::LinkState::up && status_.delivery == can::Delivery::normal && !off_bus_;
  }

  /// True when nothing can be received: the interface is not up, or the controller is off the bus.
  bool away() const noexcept {
    return status_.link != can::LinkState::up || status_.state == can::ControllerState::bus_off;
  }

  /// At the last look the bus came back after telegrams had not reached it, however short that was.
  bool returned() const noexcept { return returned_; }

  /// As of the last look.
  const can::ControllerStatus& status() const noexcept { return status_; }
  can::SendResult last_send() const noexcept { return last_send_; }

 private:
  struct Row {
    std::uint64_t seen = 0;   ///< counter at the last look
    std::uint64_t count = 0;  ///< since the row began; 0: there is none
    can::Time last{};
  };

  void watch_bus_off(can::Time now) noexcept;
  void watch_link(can::LinkState before) noexcept;
  void watch_delivery(can::Delivery before) noexcept;
  void watch_row(BusFaultKind kind, std::uint64_t counter, can::Time now) noexcept;

  can::Bus& bus_;
  Reporter& reporter_;
  can::ControllerStatus status_;
  std::optional<can::Time> bus_off_since_;
  bool off_bus_ = false;  ///< for longer than an interruption
  bool returned_ = false;
  std::array<Row, kBusFaultKinds> rows_ = {};
  can::SendResult last_send_ = can::SendResult::queued;
  std::uint64_t failed_sends_ = 0;  ///< in a row, the interface being up
  std::uint64_t without_link_ = 0;  ///< telegrams since the interface is not up
  std::uint64_t held_back_ = 0;     ///< telegrams since nobody acknowledges
  std::uint64_t never_sent_ = 0;    ///< all such telegrams when everything was well
};

}  // namespace cansyncd
