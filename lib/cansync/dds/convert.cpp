#include "cansync/dds/convert.h"

#include <algorithm>
#include <chrono>

namespace cansync::dds {
namespace {

constexpr std::int32_t kAutomaticCode = -128;
constexpr std::int32_t kNobodyCode = -1;

/// A number that `check` found in range; cut to its range if nobody asked `check`.
template <class Bounded>
Bounded bounded(std::uint32_t value) noexcept {
  return *Bounded::from(std::min<std::uint32_t>(value, Bounded::max));
}

SubSlave sub_slave(std::uint32_t value) noexcept {
  return {static_cast<std::uint16_t>(value)};
}

Duration monitoring_time(std::uint32_t milliseconds) noexcept {
  return std::chrono::milliseconds(milliseconds);
}

std::uint32_t age(IntervalNumber now, IntervalNumber last) noexcept {
  const IntervalNumber intervals = now >= last ? now - last : 0;
  return static_cast<std::uint32_t>(std::min<IntervalNumber>(intervals, 0xFFFFFFFFu));
}

std::uint8_t bits(bool zero, bool one) noexcept {
  return static_cast<std::uint8_t>((zero ? 1u : 0u) | (one ? 2u : 0u));
}

}  // namespace

ParameterRequest to_core(const cansync_ParameterRequest& request, JobId id) noexcept {
  ParameterRequest core;
  core.id = id;
  core.write = request.write;
  core.slave = bounded<SlaveNumber>(request.slave);
  core.sub_slave = sub_slave(request.sub_slave);
  core.number = bounded<ParameterNumber>(request.number);
  core.element = bounded<Element>(request.element);
  core.value = request.value;
  core.monitoring_time = monitoring_time(request.timeout);
  switch (request.format) {
    case cansync_FORMAT_WORD:
      core.format = ParameterFormat::word;
      break;
    case cansync_FORMAT_DOUBLEWORD:
      core.format = ParameterFormat::doubleword;
      break;
    case cansync_FORMAT_AS_SLAVE_SAYS:
      core.format = ParameterFormat::as_slave_says;
      break;
  }
  return core;
}

TransferRequest to_core(const cansync_TransferRequest& request, JobId id,
                        std::span<std::uint8_t> data) noexcept {
  TransferRequest core;
  core.id = id;
  core.direction = request.direction == cansync_DIRECTION_DOWNLOAD ? TransferRequest::Direction::download
                                                                   : TransferRequest::Direction::upload;
  core.slave = bounded<SlaveNumber>(request.slave);
  core.sub_slave = sub_slave(request.sub_slave);
  core.address = request.address;
  core.block_size = static_cast<std::uint16_t>(std::min(request.block_size, 0xFFFFu));
  core.monitoring_time = monitoring_time(request.timeout);
  core.data = data;
  return core;
}

ControlWordRequest to_control_word(const cansync_Command& command, JobId id) noexcept {
  return {id, bounded<SlaveNumber>(command.slave), static_cast<std::uint16_t>(command.control_word),
          monitoring_time(command.timeout)};
}

BroadcastRequest to_broadcast(const cansync_Command& command, JobId id) noexcept {
  const ActionCommand action{{command.slave_mask},
                             static_cast<std::uint8_t>(command.action),
                             static_cast<std::uint8_t>(command.data_byte),
                             static_cast<std::uint16_t>(command.data_word)};
  return {id, static_cast<std::uint8_t>(std::min(command.priority, 2u)), action,
          monitoring_time(command.timeout)};
}

ReferenceUpdate to_core(const cansync_ReferenceValues& values) noexcept {
  ReferenceUpdate update;
  update.channel = values.telegram == 2 ? Channel::two : Channel::one;
  for (unsigned i = 0; i < update.value.size(); ++i)
    update.value[i] = static_cast<std::uint32_t>(values.value[i]);
  update.valid_mask = values.valid;
  update.from_interval = values.from_interval;
  update.release_intervals = std::max(values.release_intervals, 1u);
  update.mapping_number = values.mapping_number;
  return update;
}

std::optional<Cursor> to_cursor(std::int32_t code) noexcept {
  if (code == kAutomaticCode) return Cursor{Cursor::Kind::automatic, {}};
  if (code == kNobodyCode) return Cursor{Cursor::Kind::nobody, {}};
  if (code < 0 || code > SlaveNumber::max) return std::nullopt;
  return Cursor{Cursor::Kind::fixed, *SlaveNumber::from(static_cast<std::uint64_t>(code))};
}

std::int32_t to_code(const Cursor& cursor) noexcept {
  switch (cursor.kind) {
    case Cursor::Kind::automatic:
      return kAutomaticCode;
    case Cursor::Kind::nobody:
      return kNobodyCode;
    case Cursor::Kind::fixed:
      break;
  }
  return cursor.slave.value();
}

std::optional<ProcessMapping> to_mapping(const std::uint8_t (&bytes)[8]) noexcept {
  ProcessMapping mapping = {};
  for (unsigned i = 0; i < 2 * kWords; ++i) {
    const std::optional<WordMapping> word = from_register(bytes[i]);
    if (!word) return std::nullopt;
    mapping[i / kWords].word[i % kWords] = *word;
  }
  return mapping;
}

void to_registers(const ProcessMapping& mapping, std::uint8_t (&bytes)[8]) noexcept {
  for (unsigned i = 0; i < 2 * kWords; ++i) bytes[i] = to_register(mapping[i / kWords].word[i % kWords]);
}

cansync_ActualValues actual_values(SlaveNumber slave, std::string_view name, const ActualValues& values,
                                   const std::array<cansync_ValueName, kValues>& names, IntervalNumber now,
                                   std::int64_t receive_time) noexcept {
  cansync_ActualValues out = {};
  out.slave = slave.value();
  copy_text(name, out.slave_name);
  for (unsigned i = 0; i < kValues; ++i) {
    out.raw[i] = values.value[i];
    const bool word = ((values.words >> i) & 1u) != 0;
    const auto number = static_cast<double>(number_of(values.value[i], word, names[i].is_signed));
    out.scaled[i] = number * names[i].factor + names[i].offset;
  }
  out.words = values.words;
  out.arrived = bits(values.arrived[0], values.arrived[1]);
  out.ever = bits(values.count[0] != 0, values.count[1] != 0);
  for (unsigned channel = 0; channel < kChannels; ++channel) {
    out.interval[channel] = values.interval[channel];
    out.age[channel] = age(now, values.interval[channel]);
  }
  out.receive_time = receive_time;
  return out;
}

cansync_SlaveStatus slave_status(SlaveNumber slave, std::string_view name, const SlaveStatus& status,
                                 const ProcessMapping& mapping,
                                 const std::array<cansync_ValueName, kValues>& names) noexcept {
  cansync_SlaveStatus out = {};
  out.slave = slave.value();
  copy_text(name, out.name);
  out.responds = status.responds;
  out.synchronized = status.synchronized;
  out.status_known = status.status_known;
  out.status_word = status.status_word;
  out.last_seen = status.last_seen;
  out.answers = status.answers;
  out.unanswered = status.unanswered;
  out.missed_actual = status.missed_actual;
  out.slow_answers = status.slow_answers;
  out.last_response = status.last_response.count();
  out.longest_response = status.longest_response.count();
  to_registers(mapping, out.actual_mapping);
  std::copy(names.begin(), names.end(), std::begin(out.actual_value));
  copy_text(cansync::name(status.state), out.state);
  out.times_lost = status.times_lost;
  out.times_returned = status.times_returned;
  out.jobs_ended = status.jobs_ended;
  out.status_error = status.status_error;
  return out;
}

namespace {

void fill_frame_kinds(const MasterCounters& counters, cansync_MasterStatus& out) noexcept {
  const auto rejected = [&](DecodeError error) { return counters.rejected[static_cast<unsigned>(error)]; };
  out.frames_foreign = rejected(DecodeError::not_for_us);
  out.frames_extended = rejected(DecodeError::extended);
  out.frames_remote = rejected(DecodeError::remote);
  out.frames_error = rejected(DecodeError::error_frame);
  out.frames_slave_number = rejected(DecodeError::wrong_slave);
  out.frames_length = rejected(DecodeError::wrong_length);
  out.frames_reserved = rejected(DecodeError::reserved_bits);
  const auto unexpected = [&](Unexpected kind) {
    return counters.unexpected_by_kind[static_cast<unsigned>(kind)];
  };
  out.unexpected_slave = unexpected(Unexpected::wrong_slave);
  out.unexpected_answer = unexpected(Unexpected::wrong_answer);
  out.unexpected_late = unexpected(Unexpected::late);
  out.unexpected_duplicate = unexpected(Unexpected::duplicate);
  out.unexpected_unasked = unexpected(Unexpected::unasked);
}

}  // namespace

void fill_master_status(const MasterSettings& settings, const MasterCounters& counters, State state,
                        cansync_MasterStatus& out) noexcept {
  const SlotTimes& times = slot_times(settings.bit_rate);
  out.option_status = static_cast<std::uint16_t>(state);
  copy_text(cansync::name(state), out.state);
  out.interval_length = static_cast<std::uint64_t>(times.interval.count());
  out.slaves_configured = settings.configured().bits;
  out.parameter_queue = settings.command_channel.parameter_queue;
  out.parameter_timeout = static_cast<std::uint32_t>(
      std::chrono::duration_cast<std::chrono::milliseconds>(settings.command_channel.parameter_monitoring)
          .count());
  out.transfer_timeout = static_cast<std::uint32_t>(
      std::chrono::duration_cast<std::chrono::milliseconds>(settings.command_channel.transfer_monitoring)
          .count());
  out.command_timeout = static_cast<std::uint32_t>(
      std::chrono::duration_cast<std::chrono::milliseconds>(settings.command_channel.command_monitoring)
          .count());
  out.transfer_queue = settings.command_channel.transfer_queue;
  out.telegrams_sent = counters.telegrams_sent;
  out.left_out = counters.left_out;
  out.references_not_released = counters.references_not_released;
  out.rejected_frames = 0;
  for (const std::uint64_t count : counters.rejected) out.rejected_frames += count;
  out.unexpected_frames = counters.unexpected;
  fill_frame_kinds(counters, out);
  to_registers(settings.process.reference_mapping, out.reference_mapping);
  out.polling_one = to_code(settings.process.polling[0]);
  out.polling_two = to_code(settings.process.polling[1]);
  out.maximum_slave = settings.process.maximum_slave.value();
  out.cursor_control_word = to_code(settings.command_channel.control_word);
  out.cursor_parameter = to_code(settings.command_channel.parameter);
  out.cursor_transfer = to_code(settings.command_channel.transfer);
  copy_text(settings.command_channel.serving == Serving::scan ? "scan" : "work_conserving", out.serving);
}

}  // namespace cansync::dds
