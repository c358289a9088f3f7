#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <variant>

#include "can/bus.h"
#include "can/frame.h"
#include "can/link_facts.h"
#include "layer2/module.h"
#include "rt/latest_value.h"
#include "rt/spsc_ring.h"
#include "rt/wake_signal.h"

/// Everything that the realtime thread of a bus of general frames and its gateway thread share. The gateway
/// writes `requests` and `outputs` and reads the rest; the realtime thread the other way round. All of it is
/// bounded, allocated at the start and wait-free on both sides.
namespace cansyncd {

/// Takes back an order that still waits; no answer of its own: the order answers. An unknown one is ignored.
struct CancelOrder {
  layer2::OrderId id = 0;
};

/// What a client asks for.
using Layer2Job = std::variant<layer2::SendOrder, layer2::ControlOrder, layer2::ObjectOrder>;

/// A request of the gateway. Each job has exactly one `SendDone`.
using Layer2Request = std::variant<layer2::SendOrder, layer2::ControlOrder, layer2::ObjectOrder, CancelOrder>;

/// The one answer to a job; of a ControlOrder, its refusal alone.
struct SendDone {
  layer2::Answer answer;
  layer2::Refusal refusal = layer2::Refusal::none;  ///< not none: nothing was sent, `answer` has the id alone
  can::Time sent_time{0};                           ///< done: CLOCK_REALTIME of the frame's last bit
  layer2::ObjectAnswer object = {};  ///< of an ObjectOrder; refusal, outcome and id stand above
};

/// An event of the module.
struct ModuleReport {
  layer2::ModuleEvent event;
  can::Time time{0};         ///< CLOCK_REALTIME
  std::uint64_t number = 0;  ///< rises by one, also by those that had no room
};

/// The message objects as they are.
struct ObjectsSnapshot {
  std::array<layer2::ObjectState, layer2::MessageObjects::kMost> objects = {};
  std::array<can::Time, layer2::MessageObjects::kMost> times = {};  ///< CLOCK_REALTIME of `ObjectState::time`
};

/// A frame that a range takes.
struct ReceivedReport {
  can::Frame frame;
  can::Time receive_time{0};  ///< CLOCK_REALTIME of its last bit
  std::uint8_t range = 0;     ///< position of the range
  bool high_priority = false;
};

/// A timer as it is.
struct TimerState {
  bool configured = false;
  bool running = false;
  layer2::TimerSettings settings;
  std::uint64_t sent = 0;
  std::uint64_t left_out = 0;
};

/// The process image as it is.
struct ImageSnapshot {
  std::uint32_t table = 0;  ///< `DataMapping::table` that it is of
  bool exchanging = false;
  bool sending = false;
  std::uint64_t received = 0;
  std::uint64_t dropped = 0;
  std::uint64_t sent = 0;
  std::uint64_t left_out = 0;
  std::uint8_t telegrams = 0;  ///< out
  std::array<layer2::DataMapping::LeftOut, layer2::DataMapping::kMessages> each_left_out = {};
  std::array<std::uint8_t, layer2::DataMapping::kBytes> inputs = {};
  std::array<std::uint8_t, layer2::DataMapping::kBytes> outputs = {};
};

/// The image that is sent, as the gateway has it.
struct OutputImage {
  std::uint32_t table = 0;  ///< `DataMapping::table` that it is for; under another one it is not taken
  std::array<std::uint8_t, layer2::DataMapping::kBytes> bytes = {};
  bool sending = false;  ///< false also until somebody has written
};

/// State of the bus; written when it changes and ten times a second.
struct BusSnapshot {
  can::ControllerStatus controller;
  can::TimestampSource timestamps = can::TimestampSource::thread;
  layer2::StationCounters counters;
  std::uint64_t taken_by_objects = 0;  ///< frames of others
  std::uint64_t taken_by_mapping = 0;
  std::uint64_t dropped_by_mapping = 0;
  std::uint64_t lost = 0;      ///< frames that had no room in `frames`
  std::uint32_t waiting = 0;   ///< orders that wait to be handed over
  std::uint32_t bus_load = 0;  ///< permille, of the last second
  bool script_running = false;
  bool window_running = false;
  layer2::StatusFacts facts;
  layer2::Station::QueueState send;
  layer2::Station::QueueState send_high;
  layer2::Station::QueueState receive;
  layer2::Station::QueueState receive_high;
  std::array<TimerState, layer2::Timers::kMost> timers = {};  ///< index: number - 1
};

/// The shared structures. Constructed before both threads, destroyed after both.
///
/// The realtime thread takes a request only while `done` has room for the answer of every order it has taken,
/// so that no answer can be lost. What still waits in `requests` when it stops is answered as stopped, as far
/// as there is room; once it has ended, whatever is left was never begun.
struct Layer2Exchange {
  static constexpr std::size_t kEvents = 1024;  ///< room for events

  /// `request_queue` and `report_queue`: entries of `requests` and of `frames`.
  Layer2Exchange(std::size_t request_queue, std::size_t report_queue)
      : requests(request_queue),
        done(request_queue + 2 * layer2::Station::kMostQueue + layer2::Station::kMostHandedOver),
        frames(report_queue) {}

  rt::SpscRing<Layer2Request> requests;  ///< gateway -> realtime
  rt::SpscRing<SendDone> done;           ///< realtime -> gateway
  rt::SpscRing<ReceivedReport> frames;   ///< realtime -> gateway, lossy
  rt::LatestValue<BusSnapshot> status;
  rt::SpscRing<ModuleReport> events{kEvents};  ///< realtime -> gateway, lossy
  rt::LatestValue<ImageSnapshot> image;
  rt::LatestValue<ObjectsSnapshot> objects;
  rt::LatestValue<OutputImage> outputs;  ///< gateway -> realtime
  rt::LatestValue<can::LinkFacts> link;  ///< of the thread that watches the interface
  rt::WakeSignal gateway_wake;           ///< signalled when anything above was written for the gateway
};

}  // namespace cansyncd
