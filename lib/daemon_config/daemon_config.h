#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "can/bit_timing.h"
#include "daemon_config/flight_triggers.h"
#include "sync/input.h"

/// What every protocol's configuration has: the daemon's part of one bus. Plain values; docs/configuration.md
/// lists every option. Not for the realtime thread.
namespace cansyncd {

/// What stands behind the bus.
enum class BusKind : std::uint8_t {
  simulated,  ///< simulated line with simulated drives, in real time
  socketcan,  ///< a CAN network interface of the kernel
};

/// What the daemon asks of a controller's one-shot mode, in which a frame that nobody acknowledges is not
/// repeated.
enum class OneShot : std::uint8_t {
  prefer,   ///< without it, say so and send
  enforce,  ///< without it, refuse to start, and send nothing
  ignore,   ///< without it, send
};

/// The bus.
struct BusConfig {
  std::string name = "sim";  ///< name for people, log lines and the default DDS partition; 1..63 characters
  BusKind kind = BusKind::simulated;
  std::string interface = "sim";  ///< "sim", or the network interface's name
  std::string adapter;  ///< the adapter that the interface must have, as can::read_pin reads it; empty: any
  std::uint32_t bits_per_second = 1'000'000;  ///< over 0; which ones, the protocol's option says
  bool wake_on_frame = false;                 ///< CAN interface: wake for each frame instead of at the slots
  OneShot one_shot = OneShot::prefer;
  std::optional<std::uint8_t> btr0;  ///< bit timing registers of the controller the line was set up with;
  std::optional<std::uint8_t> btr1;  ///< both or none
  can::Controller registers_of = can::Controller::plc;  ///< whose clock the registers count in
  /// Sample point of the protocol's nodes, in 1/1000 of a bit; 0: any. Nothing: of the PLC's preset (M 4.9).
  std::optional<std::uint16_t> sample_point;
};

/// What to do when the realtime thread cannot get what it asks for.
enum class RealtimeMode : std::uint8_t {
  enforce,  ///< refuse to start
  ignore,   ///< say so once and run anyway
};

/// The realtime thread.
struct RealtimeConfig {
  RealtimeMode mode = RealtimeMode::ignore;
  int priority = 60;                  ///< SCHED_FIFO priority, 1..98; 0: normal scheduling
  int cpu = -1;                       ///< processor the thread is bound to; -1: any
  bool lock_memory = true;            ///< mlockall
  std::uint32_t request_queue = 256;  ///< requests on their way to the realtime thread
  std::uint32_t report_queue = 1024;  ///< reports on their way from the realtime thread
};

/// Where the SYNC edge goes beside the bus itself. A simulated bus has its own SYNC line.
enum class SyncOutput : std::uint8_t {
  none,
  gpio,  ///< a GPIO line
  phc,   ///< a periodic output of a PTP hardware clock, which the timeline follows
  can,   ///< the software SYNC frame
};

/// The external SYNC that the timeline follows.
enum class SyncInput : std::uint8_t {
  none,
  gpio,  ///< edges of a GPIO line
  pps,   ///< one pulse per second
  can,   ///< the software SYNC frame of another node
};

using SyncEdge = sync_line::Edge;

/// The SYNC line.
struct SyncConfig {
  SyncOutput output = SyncOutput::none;
  SyncEdge edge = SyncEdge::falling;  ///< at the GPIO line or the clock's pin
  std::string gpio_chip = "/dev/gpiochip0";
  std::uint32_t gpio_line = 0;
  std::string phc_device = "/dev/ptp0";
  int phc_pin = 0;  ///< -1: the clock's pins are fixed
  std::uint32_t phc_channel = 0;
  std::uint32_t can_identifier = 0x080;  ///< of the software SYNC frame
  SyncInput input = SyncInput::none;
  std::string input_gpio_chip = "/dev/gpiochip0";
  std::uint32_t input_gpio_line = 0;
  SyncEdge input_edge = SyncEdge::falling;
  std::string pps_device = "/dev/pps0";
  SyncEdge pps_edge = SyncEdge::rising;       ///< rising: assert; falling: clear
  std::chrono::nanoseconds input_offset{0};   ///< from the input's edge to the timeline's
  std::chrono::milliseconds holdover{1000};   ///< without edges until the input counts as lost
  std::chrono::nanoseconds greatest_step{0};  ///< per interval; 0: a thousandth of the interval

  /// Does the bus carry software SYNC frames for or from this daemon?
  bool uses_frame() const noexcept { return output == SyncOutput::can || input == SyncInput::can; }
};

/// What to do when another daemon serves a bus of the same name in the same domain.
enum class NameInUse : std::uint8_t {
  refuse,  ///< refuse to start
  event,   ///< start, and tell an event
};

/// DDS.
struct DdsConfig {
  std::uint32_t domain = 0;      ///< 0..230
  std::string interface = "lo";  ///< network interface DDS is bound to
  std::string partition;         ///< of all topics; never empty after parsing (default: the bus's name)
  bool interval_topic = false;   ///< publish the topic Interval
  std::chrono::milliseconds request_max_age{5000};  ///< of a request when it arrives; 0: any
  NameInUse name_in_use = NameInUse::refuse;
  std::string security;  ///< folder of the daemon's identity; empty: without DDS Security
  std::string xml;       ///< Cyclone DDS configuration used instead of the generated one; empty: generated
  bool final_types = false;  ///< topics of final types, in XCDR1; false: appendable, in XCDR2
};

/// Who may do what.
struct AccessConfig {
  bool read_only = false;     ///< refuse every request that would change a drive or the line
  bool profile_rules = true;  ///< refuse writes that the slave's profile does not allow
  bool record_each = false;   ///< each of a client's repeated requests to send has an entry of its own
};

/// The simulated line; looked at only with `BusKind::simulated`.
struct SimLineConfig {
  std::uint64_t seed = 1;
  std::string fault_script;  ///< file with faults to inject; empty: none
  std::string trace;         ///< file for a candump text log of the bus; empty: none
};

/// The flight recorder: what is kept of the realtime thread's last moments, and when it is saved.
struct RecorderConfig {
  std::optional<std::string> folder;   ///< empty: off; nothing: the service's state folder, see docs
  std::uint32_t files = 10;            ///< recordings kept
  std::uint32_t entries = 16384;       ///< things kept in memory: wake-ups, frames, states
  std::uint32_t intervals_after = 50;  ///< recording goes on so long after a fault
  FlightTriggers triggers;
};

/// The metrics file for node_exporter's textfile collector.
struct MetricsConfig {
  std::string file;                 ///< empty: none
  std::chrono::seconds period{10};  ///< 1..3600
};

/// The daemon's part of a configuration. Each protocol's own has it as its base.
struct DaemonConfig {
  BusConfig bus;
  RealtimeConfig realtime;
  SyncConfig sync;
  DdsConfig dds;
  AccessConfig access;
  SimLineConfig sim;
  RecorderConfig recorder;
  MetricsConfig metrics;
};

}  // namespace cansyncd
