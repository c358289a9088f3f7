#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "can/bus.h"
#include "daemon/j1939/exchange.h"
#include "daemon/loop/controller_watch.h"
#include "daemon/loop/flight_tap.h"
#include "daemon/loop/wall_clock.h"
#include "j1939/node.h"

namespace cansyncd {

/// What the realtime thread of a bus of J1939 needs to know.
struct MessageMachineSettings {
  j1939::NodeSettings node;
  std::uint32_t bits_per_second = 250'000;            ///< over 0
  WallClock::Read wall_clock = &read_realtime_clock;  ///< null in virtual time
  FlightTap* tap = nullptr;                           ///< flight recorder; null: none
};

/// Binds a `j1939::Node` to a bus and to the gateway; driven by `DeadlineLoop`. Realtime thread only;
/// realtime safe after its construction.
class MessageMachine {
 public:
  /// Bus and exchange must outlive the machine.
  MessageMachine(const MessageMachineSettings& settings, can::Bus& bus, J1939Exchange& exchange)
      : bus_(bus),
        exchange_(exchange),
        node_(settings.node),
        watch_(bus, settings.bits_per_second, settings.wall_clock, settings.tap) {}

  // --- for DeadlineLoop, which says what each is
  void begin(can::Time now) noexcept;
  void advance(can::Time now) noexcept;
  void receive(const can::ReceivedFrame& received) noexcept;
  std::optional<can::Frame> next_frame() noexcept { return node_.next_frame(); }
  void handed_over(can::SendResult result) noexcept;
  bool waits_for_echo() const noexcept { return !node_.has_place(); }
  can::Time next_deadline() const noexcept { return node_.next_deadline(); }
  void publish(can::Time now) noexcept;
  void end(can::Time now) noexcept;

 private:
  void take_requests(can::Time now) noexcept;
  void watch_bus(can::Time now) noexcept;
  void report(const j1939::Node::Delivery& delivery) noexcept;
  void answer(const MessageDone& done) noexcept;
  void pass_answers() noexcept;
  void tell_claim() noexcept;
  void tell_addresses(can::Time now) noexcept;

  can::Bus& bus_;
  J1939Exchange& exchange_;
  j1939::Node node_;
  ControllerWatch watch_;
  NodeSnapshot snapshot_;
  AddressSnapshot addresses_;
  std::uint64_t told_revision_ = 0;  ///< of the table of claims
  LongData long_data_ = {};
  can::Time next_status_{};
  can::Time next_addresses_{};
  std::size_t unanswered_ = 0;  ///< orders taken whose answer was not pushed yet
  bool changed_ = false;        ///< the state of bus or claim, since it was published
  bool pending_ = false;        ///< something was written for the gateway
};

}  // namespace cansyncd
