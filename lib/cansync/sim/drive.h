#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "can/bus.h"
#include "cansync/settings/timing.h"
#include "cansync/sim/drive_memory.h"
#include "cansync/sim/drive_motion.h"
#include "cansync/sim/drive_parameters.h"
#include "cansync/slave/slave.h"
#include "cansync/slave/slave_supervision.h"
#include "cansync/telegram/mapping.h"
#include "sim/node.h"

// docs/simulated-drive.md describes the drive as a user sees it.
namespace sim {

/// Bits of a drive's control word; `run` switches it on and lets it follow its reference value.
namespace control_bit {
inline constexpr std::uint16_t enable = 0x0001;         ///< power on
inline constexpr std::uint16_t no_quick_stop = 0x0002;  ///< 0 = quick stop
inline constexpr std::uint16_t follow = 0x0004;         ///< 0 = ramp down and stand
inline constexpr std::uint16_t fault_reset = 0x0080;    ///< acknowledges a fault each time it arrives
inline constexpr std::uint16_t run = enable | no_quick_stop | follow;
}  // namespace control_bit

/// Bits of a drive's status word.
namespace status_bit {
inline constexpr std::uint16_t ready = 0x0001;       ///< no fault
inline constexpr std::uint16_t powered = 0x0002;     ///< the control word enables it
inline constexpr std::uint16_t following = 0x0004;   ///< follows its reference value
inline constexpr std::uint16_t fault = 0x0008;       ///< see the fault code
inline constexpr std::uint16_t quick_stop = 0x0010;  ///< powered, quick stop commanded
inline constexpr std::uint16_t standstill = 0x0020;  ///< slower than 1 increment/s
inline constexpr std::uint16_t on_target = 0x0040;   ///< following error within 10 increments
inline constexpr std::uint16_t extrapolating =
    0x0080;  ///< the reference value was missing in the last interval
inline constexpr std::uint16_t synchronized = 0x8000;  ///< locked on SYNC (O 7.2)
}  // namespace status_bit

/// Why a drive has faulted; action command 128 provokes a fault with any other code.
namespace fault_code {
inline constexpr std::uint16_t none = 0;
inline constexpr std::uint16_t references_missing =
    26;                                         ///< too many intervals without a reference value (O 7.2)
inline constexpr std::uint16_t sync_lost = 27;  ///< too many SYNC edges stayed away
}  // namespace fault_code

/// User command that puts a drive into fault; the data word is the fault code (0 counts as 1).
inline constexpr std::uint8_t kActionProvokeFault = 128;

/// Which reference value moves the axis, and how.
struct AxisSettings {
  std::uint8_t position_value = 0;  ///< number 0..7 of the reference value that is the position
  std::uint8_t speed_value = 1;     ///< number 0..7 of the one that is the speed, in operating mode 1
  /// Follows value 0 of this slave's actual values instead of a reference value.
  std::optional<cansync::SlaveNumber> leader;
  double gear = 1;    ///< increments of this axis per increment of the reference
  double offset = 0;  ///< increments, added after the gear
};

/// Receives what a master changes on a drive, when the drive takes it. On the thread that drives the line: nothing
/// may allocate, lock, log or block in real time.
class DriveWatcher {
 public:
  virtual ~DriveWatcher() = default;
  /// Parameter `number` has `value` from now on.
  virtual void parameter_written(cansync::SlaveNumber drive, cansync::ParameterNumber number,
                                 std::uint32_t value) noexcept = 0;
};

/// Everything about a simulated drive that can be set.
struct DriveSettings {
  /// Number, bit rate, mappings, monitored slaves, block limit, "activate" command.
  cansync::SlaveSideSettings slave;
  /// From "activate", with SYNC edges coming, until bit 15 of the status word.
  cansync::Duration lock_time = std::chrono::milliseconds(500);
  /// From the end of a received frame until its answer is ready; default: 20 bit times (20 us at 1 Mbit/s),
  /// which meets every latest start while the master sends each telegram 50 us before its own.
  std::optional<cansync::Duration> processing_delay;
  std::uint32_t misses_until_fault = 10;  ///< intervals in a row without a reference value; 0 = never
  std::uint32_t edges_until_fault = 10;   ///< SYNC edges missing in a row, at least 2
  std::uint16_t initial_control_word = control_bit::run;  ///< as if it had arrived; 0 = waits for one
  std::uint16_t status_parameter = parameter::status_word;
  AxisSettings axis;
  MemorySettings memory;
  std::vector<ParameterDefinition> parameters = standard_parameters();
};

/// A simulated drive on a simulated line: the slave state machine with an axis, parameters and memory behind
/// it. It goes to active operation by itself; actual values are released at each SYNC edge:
/// 0 position, 1 speed, 2 following error, 3 position setpoint, 4 torque, 5 status word (fault code in the
/// high word), 6 temperature, 7 reference value 4 as it was received. Nothing allocates, blocks or throws
/// after construction; not thread safe.
///
/// Begins with a cache line: the 32 of a line then touch fewer in an interval, which `line_bench` shows.
class alignas(64) Drive final : public Node, private cansync::SlaveApplication {
 public:
  explicit Drive(const DriveSettings& settings);
  Drive(const Drive&) = delete;
  Drive& operator=(const Drive&) = delete;

  cansync::SlaveNumber number() const noexcept { return slave_.settings().number; }
  NodeNumber node_number() const noexcept override { return number().value(); }
  bool accepts(const can::Frame& frame) const noexcept override;
  void on_sync(can::Time now) noexcept override;
  std::optional<Transmission> on_frame(const can::Frame& frame, can::Time end) noexcept override;
  std::optional<Transmission> on_sent(const can::Frame& frame, can::Time end) noexcept override;

  /// As after power off and on: state machine, axis and parameters start anew, memory keeps its contents.
  void restart() noexcept;

  /// Sets a parameter past every access right, as if the drive had come with it; it takes effect at once.
  /// False: no such parameter.
  bool set_parameter(std::uint16_t number, std::uint32_t value) noexcept;

  /// The next `requests` parameter requests are answered busy; `DriveParameters::kEndless`: all of them.
  void answer_busy(std::uint32_t requests) noexcept { busy_requests_ = requests; }

  /// Reports to `watcher` from now on; it must outlive the drive.
  void watch(DriveWatcher& watcher) noexcept { watcher_ = &watcher; }

  /// Faults at once with `code`, over 0.
  void raise_fault(std::uint16_t code) noexcept;

  std::uint16_t control_word() const noexcept { return control_word_; }
  std::uint16_t status_word() const noexcept;
  std::uint16_t fault() const noexcept { return fault_; }
  /// Intervals without a reference value that was due, since power-on.
  std::uint32_t missed_references() const noexcept { return supervision_.missed_references(); }
  /// Actual value telegrams left out because they would have started after their slot.
  std::uint64_t left_out() const noexcept {
    return slave_.counters(cansync::Channel::one).late + slave_.counters(cansync::Channel::two).late;
  }

  const cansync::Slave& slave() const noexcept { return slave_; }
  const DriveMotion& motion() const noexcept { return motion_; }
  /// The actual values released last.
  const cansync::Values& actual() const noexcept { return actual_; }
  const DriveParameters& parameters() const noexcept { return parameters_; }
  DriveMemory& memory() noexcept { return memory_; }
  const DriveMemory& memory() const noexcept { return memory_; }

 private:
  // What a master asks of the drive.
  cansync::ParameterAnswer read_parameter(cansync::ParameterNumber number, cansync::Element element,
                                          cansync::SubSlave sub) noexcept override;
  cansync::ParameterAnswer write_parameter(cansync::ParameterNumber number, cansync::Element element,
                                           cansync::SubSlave sub, bool doubleword,
                                           std::uint32_t value) noexcept override;
  void parameter_dropped() noexcept override { parameters_.dropped(); }
  BlockAnswer begin_block(const cansync::TransferInitialise& initialise) noexcept override;
  BlockAnswer read_block(std::uint16_t offset, std::span<std::uint8_t> out) noexcept override;
  BlockAnswer write_block(std::uint16_t offset, std::span<const std::uint8_t> data) noexcept override;
  void end_block(bool complete) noexcept override { memory_.end(complete); }
  void sync_activated() noexcept override;
  void control_word(std::uint16_t word) noexcept override;
  void action(std::uint8_t command, std::uint8_t data_byte, std::uint16_t data_word) noexcept override;

  void start() noexcept;
  bool busy_by_order() noexcept;
  void notice_fault() noexcept;
  /// Value of a parameter that mirrors what the drive does; nothing for a stored one.
  std::optional<std::uint32_t> live_value(std::uint16_t number) const noexcept;
  void apply_parameters() noexcept;
  std::uint8_t followed_value() const noexcept {
    return speed_mode_ ? axis_.speed_value : axis_.position_value;
  }
  bool followed_is_word() const noexcept;  ///< the mapping carries its low word alone
  void choose_reference() noexcept;
  /// The reference value followed, when it came since the last edge.
  std::optional<std::uint32_t> fresh_reference() noexcept;
  void take_references(std::uint32_t intervals) noexcept;
  MotionMode motion_mode() const noexcept;
  double setpoint() const noexcept { return reference_.value() * axis_.gear + axis_.offset; }
  std::uint16_t status_word(MotionMode mode, double error) const noexcept;
  /// Releases the actual values of this interval.
  void release(MotionMode mode) noexcept;

  // What every interval touches comes first, to lie together.
  std::uint16_t control_word_ = 0;
  std::uint16_t fault_ = fault_code::none;
  bool speed_mode_ = false;
  bool word_ = false;               ///< the reference value followed has 16 bits
  std::uint32_t leader_count_ = 0;  ///< telegrams of the leader taken so far
  double speed_setpoint_ = 0;       ///< increments/s, in operating mode 1
  AxisSettings axis_;
  ReferenceTracker reference_;
  cansync::SlaveSupervision supervision_;
  DriveMotion motion_;
  cansync::Values actual_ = {};
  cansync::Duration processing_delay_;
  cansync::Slave slave_;
  DriveSettings settings_;
  DriveWatcher* watcher_ = nullptr;  ///< null: none
  std::uint32_t busy_requests_ = 0;
  std::uint32_t last_action_ = 0;
  std::uint32_t action_count_ = 0;
  DriveParameters parameters_;
  DriveMemory memory_;
};

}  // namespace sim
