#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "can/bus.h"
#include "daemon/layer2/exchange.h"
#include "daemon/loop/controller_watch.h"
#include "daemon/loop/flight_tap.h"
#include "daemon/loop/wall_clock.h"
#include "layer2/module.h"

namespace cansyncd {

/// What the realtime thread of a bus of general frames needs to know.
struct FrameMachineSettings {
  layer2::ModuleSettings module;
  std::uint32_t bits_per_second = 500'000;            ///< over 0
  WallClock::Read wall_clock = &read_realtime_clock;  ///< null in virtual time
  FlightTap* tap = nullptr;                           ///< flight recorder; null: none
};

/// Binds a `layer2::Module` to a bus and to the gateway; driven by `DeadlineLoop`. Realtime thread only;
/// realtime safe after its construction.
class FrameMachine {
 public:
  /// Bus and exchange must outlive the machine.
  FrameMachine(const FrameMachineSettings& settings, can::Bus& bus, Layer2Exchange& exchange)
      : bus_(bus),
        exchange_(exchange),
        module_(settings.module),
        watch_(bus, settings.bits_per_second, settings.wall_clock, settings.tap) {}

  // --- for DeadlineLoop, which says what each is
  void begin(can::Time now) noexcept;
  void advance(can::Time now) noexcept;
  void receive(const can::ReceivedFrame& received) noexcept;
  std::optional<can::Frame> next_frame() noexcept { return module_.next_frame(); }
  void handed_over(can::SendResult result) noexcept;
  bool waits_for_echo() const noexcept { return !module_.station().has_place(); }
  can::Time next_deadline() const noexcept { return module_.next_deadline(); }
  void publish(can::Time now) noexcept;
  void end(can::Time now) noexcept;

 private:
  void take_requests(can::Time now) noexcept;
  void take_request(const Layer2Request& request, can::Time now) noexcept;
  void control(const layer2::ControlOrder& order, can::Time now) noexcept;
  void finish_reset(can::ResetResult result) noexcept;
  void pass_received() noexcept;
  void take_snapshot() noexcept;
  void publish_image(can::Time now) noexcept;
  void take_outputs() noexcept;
  void publish_objects(can::Time now) noexcept;
  void pass_events() noexcept;
  void watch_bus(can::Time now) noexcept;
  void answer(const SendDone& done) noexcept;
  void answer_object(const layer2::ObjectAnswer& answer) noexcept;
  void pass_answers() noexcept;

  can::Bus& bus_;
  Layer2Exchange& exchange_;
  layer2::Module module_;
  ControllerWatch watch_;
  BusSnapshot snapshot_;
  can::Time next_status_{};
  std::size_t unanswered_ = 0;            ///< orders taken whose answer was not pushed yet
  std::optional<layer2::OrderId> reset_;  ///< that asked for the reset under way
  std::uint64_t known_lost_ = 0;          ///< of what the controller lost: until it was taken back last
  ImageSnapshot image_;
  OutputImage outputs_;
  can::Time next_image_{};
  ObjectsSnapshot objects_;
  std::uint64_t told_objects_ = 0;  ///< `MessageObjects::changes` of what was passed on
  can::Time next_objects_{};
  std::uint64_t event_number_ = 0;
  bool changed_ = false;         ///< the state of the bus, since it was published
  bool pending_ = false;         ///< something was written for the gateway
  bool frames_pending_ = false;  ///< received frames were
  can::Time next_wake_{};        ///< from then on they wake it
};

}  // namespace cansyncd
