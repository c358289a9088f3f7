#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "can/bus.h"
#include "can/passing_bus.h"
#include "daemon/loop/fault_episode.h"
#include "daemon/loop/moment.h"
#include "daemon_config/flight_triggers.h"
#include "rt/flight_recorder.h"

namespace cansyncd {

/// Why a flight recording is made.
enum class FlightReason : std::uint8_t {
  requested,
  bus_off,
  syncs_missed,
  slave_lost,
  second_master,
  sending_failed
};
inline constexpr std::size_t kFlightReasons = 6;
/// Most recordings of faults in an hour, whatever the reasons.
inline constexpr std::size_t kMostRecordings = 6;

/// Name of a reason, as files and events carry it, e.g. "bus_off".
const char* name(FlightReason reason) noexcept;

/// What a recording's header says in a protocol's words: the names of numbers that the tap was told.
struct FlightProtocol {
  using Name = std::string_view (*)(std::uint32_t number) noexcept;
  can::Time interval{};  ///< between two SYNC edges; 0: there are none
  Name slot = nullptr;   ///< of `left_out`; null: there are none
  Name state = nullptr;  ///< of `state`; null: there are none
};

/// Feeds the flight recorder on the realtime thread: from the bus, and from the loop with what it reports.
/// Realtime safe; one thread.
class FlightTap {
 public:
  /// `recorder` must outlive the tap.
  FlightTap(rt::FlightRecorder& recorder, const FlightTriggers& triggers) noexcept
      : recorder_(recorder), triggers_(triggers) {}

  /// The instant that follows: number of the interval, and both clocks.
  void at(const Moment& moment) noexcept;

  void woke(can::Time due, can::Time at) noexcept { record(rt::FlightEntry::Kind::wake, at, due); }
  void edge(can::Time due, can::Time at) noexcept { record(rt::FlightEntry::Kind::edge, at, due); }
  void sent(can::Time at, const can::Frame& frame, can::SendResult result) noexcept;
  void received(const can::ReceivedFrame& received) noexcept;
  /// A frame was not handed over in time; `slot`: the protocol's number for its place.
  void left_out(std::uint32_t slot) noexcept;
  /// `state`: the protocol's number for it.
  void state(const Moment& when, std::uint32_t state) noexcept;
  /// Freezes the recorder, too, when the controller went bus-off and that is wanted.
  void controller(const Moment& when, can::ControllerState state) noexcept;

  /// Freezes the recorder when a recording is wanted for that reason, and the fault begins an episode of it.
  /// `detail`: a number for the header; of `syncs_missed` how many.
  void fault(FlightReason reason, std::uint64_t detail, const Moment& when) noexcept;

 private:
  void record(rt::FlightEntry::Kind kind, can::Time at, can::Time due, std::uint32_t value = 0,
              const can::Frame& frame = {}) noexcept;
  bool wanted(FlightReason reason, std::uint64_t detail) const noexcept;
  FaultEpisode& episode_of(FlightReason reason, std::uint64_t detail) noexcept;

  static constexpr std::size_t kSlaves = 32;

  rt::FlightRecorder& recorder_;
  const FlightTriggers triggers_;
  Moment moment_;
  std::array<FaultEpisode, kFlightReasons> episodes_;  ///< by reason
  std::array<FaultEpisode, kSlaves> slaves_lost_;      ///< by slave: one that flaps hides no other
  HourlyBound<kMostRecordings> all_;
};

/// A bus seen by the flight recorder: passes everything on and keeps it. Realtime safe.
class RecordedBus final : public can::PassingBus {
 public:
  /// Both must outlive this bus.
  RecordedBus(can::Bus& bus, FlightTap& tap) noexcept : PassingBus(bus), tap_(tap) {}

  can::Wake wait_until(can::Time deadline) noexcept override {
    return woken(deadline, behind_.wait_until(deadline));
  }
  can::Wake wait_for_frame(can::Time deadline) noexcept override {
    return woken(deadline, behind_.wait_for_frame(deadline));
  }
  bool receive(can::ReceivedFrame& out) noexcept override;
  can::SendResult send(const can::Frame& frame) noexcept override;

 private:
  can::Wake woken(can::Time deadline, can::Wake wake) noexcept;

  FlightTap& tap_;
};

}  // namespace cansyncd
