#include "cansync/sim/drive.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <type_traits>

namespace sim {
namespace {

using cansync::Channel;
using cansync::ControlCommand;

constexpr unsigned kDefaultDelayBits = 20;
/// Steps the axis makes at most after edges were missing; by then the drive has faulted.
constexpr std::uint32_t kMostSteps = 64;
constexpr double kOnTarget = 10.0;   // increments
constexpr double kStandstill = 1.0;  // increments/s

std::uint32_t raw(double value) noexcept {
  return static_cast<std::uint32_t>(static_cast<std::int64_t>(value + (value < 0 ? -0.5 : 0.5)));
}

constexpr Channel channel_of(std::uint8_t value) noexcept {
  return value < 4 ? Channel::one : Channel::two;
}

/// True when the mapping carries the low word of `value` alone.
bool is_word(const cansync::ProcessMapping& mapping, std::uint8_t value) noexcept {
  const auto& words = mapping[index(channel_of(value))].word;
  return std::none_of(words.begin(), words.end(), [value](const cansync::WordMapping& word) {
    return word.assigned && word.high && word.value == value;
  });
}

/// The telegram in a frame, or null; valid until the next call on this thread. All drives of a line are given
/// the same frame one after the other, so it is decoded once.
const cansync::Telegram* telegram_in(const can::Frame& frame) noexcept {
  static_assert(std::has_unique_object_representations_v<can::Frame>);
  using Words = std::array<std::uint64_t, sizeof(can::Frame) / sizeof(std::uint64_t)>;
  thread_local constinit can::Frame last;
  thread_local constinit cansync::Decoded decoded{cansync::DecodeError::not_for_us};
  if (std::bit_cast<Words>(frame) != std::bit_cast<Words>(last)) {
    last = frame;
    decoded = cansync::decode(frame);
  }
  return std::get_if<cansync::Telegram>(&decoded);
}

cansync::SlaveSupervisionSettings supervision_settings(const DriveSettings& settings) {
  cansync::SlaveSupervisionSettings result;
  result.interval = slot_times(settings.slave.bit_rate).interval;
  result.lock_time = settings.lock_time;
  result.edges_until_fault = settings.edges_until_fault;
  result.misses_until_fault = settings.misses_until_fault;
  return result;
}

/// Settings with every range held and what depends on others filled in.
DriveSettings completed(DriveSettings settings) {
  constexpr std::uint8_t kLastValue = cansync::kValues - 1;
  settings.axis.position_value = std::min(settings.axis.position_value, kLastValue);
  settings.axis.speed_value = std::min(settings.axis.speed_value, kLastValue);
  if (settings.axis.leader) {
    auto& mapping = settings.slave.monitored[settings.axis.leader->value()];
    if (!mapping) mapping = {default_mapping(Channel::one), default_mapping(Channel::two)};
  }
  if (settings.status_parameter != parameter::status_word) {
    ParameterDefinition status;
    status.number = settings.status_parameter;
    status.access = ParameterDefinition::Access::read_only;
    settings.parameters.push_back(status);
  }
  return settings;
}

}  // namespace

Drive::Drive(const DriveSettings& settings)
    : axis_(completed(settings).axis),
      supervision_(supervision_settings(settings)),
      motion_(slot_times(settings.slave.bit_rate).interval),
      processing_delay_(settings.processing_delay.value_or(slot_times(settings.slave.bit_rate).bit_time() *
                                                           kDefaultDelayBits)),
      slave_(completed(settings).slave, *this),
      settings_(completed(settings)),
      parameters_(settings_.parameters),
      memory_(settings.memory) {
  start();
}

void Drive::start() noexcept {
  parameters_.reset();
  parameters_.set_value(parameter::serial_number, 1000u + number().value());
  parameters_.set_value(parameter::slave_number, number().value());
  control_word_ = settings_.initial_control_word;
  speed_mode_ = false;
  choose_reference();
  apply_parameters();
  for (const ControlCommand command : {ControlCommand::handshake, ControlCommand::take_over_initialisation,
                                       ControlCommand::start_synchronous, ControlCommand::enable_active}) {
    slave_.control(command);
  }
}

void Drive::restart() noexcept {
  slave_.control(ControlCommand::cold_restart);
  supervision_.reset();
  motion_ = DriveMotion(slot_times(settings_.slave.bit_rate).interval);
  fault_ = fault_code::none;
  busy_requests_ = 0;
  last_action_ = 0;
  action_count_ = 0;
  start();
}

bool Drive::accepts(const can::Frame& frame) const noexcept {
  namespace id = cansync::identifier;
  if (!frame.is_standard_data()) return false;
  const std::uint32_t identifier = frame.id;
  const std::uint32_t participant = id::participant_of(identifier);
  switch (id::channel_of(identifier)) {
    case id::reference_one:
    case id::reference_two:
      return true;
    case id::actual_one:
    case id::actual_two:
      return participant < cansync::kSlaves && settings_.slave.monitored[participant].has_value();
    case id::command:
      return participant == number().value();
    default:
      return identifier == id::action;
  }
}

void Drive::on_sync(can::Time now) noexcept {
  const std::uint32_t intervals = supervision_.edge(now, slave_.sync_activated());
  notice_fault();
  take_references(intervals);
  const double target = speed_mode_ ? speed_setpoint_ : setpoint();
  const MotionMode mode = motion_mode();
  for (std::uint32_t i = std::min(intervals, kMostSteps); i > 0; --i) motion_.step(mode, target);
  release(mode);
}

std::optional<Transmission> Drive::on_frame(const can::Frame& frame, can::Time end) noexcept {
  const cansync::Telegram* telegram = telegram_in(frame);
  if (telegram == nullptr) return std::nullopt;
  if (std::holds_alternative<cansync::ParameterCommand>(*telegram)) {
    supervision_.check(end);
    notice_fault();
  }
  const can::Time edge = supervision_.last_edge();
  // Told of when its answer is ready, the slave gives it the next slot when that is after this one's end.
  const cansync::Duration ready = end + processing_delay_ - edge;
  const auto answer = slave_.receive(*telegram, ready);
  if (!answer) return std::nullopt;
  const cansync::Duration earliest = answer->window.earliest;
  const cansync::Duration start = earliest > ready ? earliest + processing_delay_ : ready;
  if (!slave_.may_start(*answer, start)) return std::nullopt;
  return Transmission{answer->frame, edge + start};
}

std::optional<Transmission> Drive::on_sent(const can::Frame& frame, can::Time) noexcept {
  slave_.sent(frame);
  return std::nullopt;
}

// --- reference and actual values

bool Drive::followed_is_word() const noexcept {
  const cansync::SlaveSideSettings& slave = slave_.settings();
  if (axis_.leader) return is_word(*slave.monitored[axis_.leader->value()], 0);
  return is_word(slave.reference_mapping, followed_value());
}

void Drive::choose_reference() noexcept {
  word_ = followed_is_word();
  reference_ = ReferenceTracker(word_);
  if (axis_.leader) leader_count_ = slave_.monitored_count(*axis_.leader, Channel::one);
  speed_setpoint_ = 0;
  supervision_.forget_references();
  motion_.rebase();
}

std::optional<std::uint32_t> Drive::fresh_reference() noexcept {
  if (axis_.leader) {
    const std::uint32_t count = slave_.monitored_count(*axis_.leader, Channel::one);
    if (count == leader_count_) return std::nullopt;
    leader_count_ = count;
    return slave_.monitored(*axis_.leader)[0];
  }
  const std::uint8_t value = followed_value();
  if (!slave_.reference_fresh(channel_of(value))) return std::nullopt;
  return slave_.references()[value];
}

void Drive::take_references(std::uint32_t intervals) noexcept {
  const std::optional<std::uint32_t> fresh = fresh_reference();
  for (auto missing = supervision_.references(intervals, fresh.has_value()); missing > 0; --missing)
    reference_.miss();
  if (fresh) {
    reference_.take(*fresh);
    speed_setpoint_ = word_ ? static_cast<double>(static_cast<std::int16_t>(*fresh & 0xFFFF))
                            : static_cast<double>(static_cast<std::int32_t>(*fresh));
  }
  notice_fault();
}

MotionMode Drive::motion_mode() const noexcept {
  if (fault_ != fault_code::none) return motion_.speed() != 0 ? MotionMode::ramp_down : MotionMode::coast;
  if ((control_word_ & control_bit::enable) == 0) return MotionMode::coast;
  const bool commanded = (control_word_ & control_bit::run) == control_bit::run;
  if (!commanded || !reference_.seen() || !supervision_.synchronized()) return MotionMode::ramp_down;
  return speed_mode_ ? MotionMode::speed : MotionMode::position;
}

void Drive::release(MotionMode mode) noexcept {
  const double position = motion_.position();
  const double wanted = reference_.seen() && !speed_mode_ ? setpoint() : position;
  const double error = wanted - position;
  actual_[0] = raw(position);
  actual_[1] = raw(motion_.speed());
  actual_[2] = raw(error);
  actual_[3] = raw(wanted);
  actual_[4] = raw(motion_.torque());
  actual_[5] = status_word(mode, error) | (std::uint32_t{fault_} << 16);
  actual_[6] = raw(motion_.temperature());
  actual_[7] = slave_.references()[4];
  slave_.on_sync();
  slave_.release_actual(Channel::one, actual_);
  slave_.release_actual(Channel::two, actual_);
}

std::uint16_t Drive::status_word() const noexcept {
  return status_word(motion_mode(), setpoint() - motion_.position());
}

std::uint16_t Drive::status_word(MotionMode mode, double error) const noexcept {
  const auto bit = [](std::uint16_t mask, bool on) { return on ? unsigned{mask} : 0u; };
  const bool faulty = fault_ != fault_code::none;
  const bool powered = !faulty && (control_word_ & control_bit::enable) != 0;
  const bool stopping = powered && (control_word_ & control_bit::no_quick_stop) == 0;
  const bool following = mode == MotionMode::position || mode == MotionMode::speed;
  const unsigned word =
      bit(status_bit::ready, !faulty) | bit(status_bit::powered, powered) |
      bit(status_bit::following, following) | bit(status_bit::fault, faulty) |
      bit(status_bit::quick_stop, stopping) |
      bit(status_bit::standstill, std::abs(motion_.speed()) < kStandstill) |
      bit(status_bit::on_target, mode == MotionMode::position && std::abs(error) <= kOnTarget) |
      bit(status_bit::extrapolating, supervision_.extrapolating());
  return supervision_.status_word(static_cast<std::uint16_t>(word));
}

// --- faults and commands

void Drive::raise_fault(std::uint16_t code) noexcept {
  if (fault_ == fault_code::none) fault_ = code;
  reference_.forget();
  supervision_.forget_references();
}

void Drive::notice_fault() noexcept {
  switch (supervision_.take_fault()) {
    case cansync::SlaveFault::sync_lost:
      return raise_fault(fault_code::sync_lost);
    case cansync::SlaveFault::references_missing:
      return raise_fault(fault_code::references_missing);
    case cansync::SlaveFault::none:
      return;
  }
}

void Drive::sync_activated() noexcept {
  // The master starts up (again): what was wrong with the communication is over.
  if (fault_ == fault_code::references_missing || fault_ == fault_code::sync_lost) fault_ = fault_code::none;
}

void Drive::control_word(std::uint16_t word) noexcept {
  control_word_ = word;
  if ((word & control_bit::fault_reset) != 0) fault_ = fault_code::none;
}

void Drive::action(std::uint8_t command, std::uint8_t data_byte, std::uint16_t data_word) noexcept {
  last_action_ = (std::uint32_t{command} << 24) | (std::uint32_t{data_byte} << 16) | data_word;
  ++action_count_;
  if (command == kActionProvokeFault) raise_fault(std::max<std::uint16_t>(data_word, 1));
}

}  // namespace sim
