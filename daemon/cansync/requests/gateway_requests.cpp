#include "daemon/cansync/requests/gateway_requests.h"

#include <fmt/format.h>

#include <string_view>
#include <vector>

#include "cansync/dds/convert.h"
#include "daemon/cansync/texts/profile_rules.h"
#include "daemon/cansync/texts/refusal_text.h"

namespace cansyncd {
namespace {

namespace dds = cansync::dds;
using cansync::JobId;
using cansync::SlaveNumber;

std::optional<Mode> to_mode(cansync_Mode mode) noexcept {
  switch (mode) {
    case cansync_MODE_SETUP:
      return Mode::set_up;
    case cansync_MODE_RUN:
      return Mode::run;
    case cansync_MODE_STOP:
      return Mode::stop;
    case cansync_MODE_RESET_CAN:
      return Mode::reset_can;
    case cansync_MODE_RESTART:
      return Mode::restart;
  }
  return std::nullopt;
}

std::string_view name(Mode mode) noexcept {
  switch (mode) {
    case Mode::set_up:
      return "setup";
    case Mode::run:
      return "run";
    case Mode::stop:
      return "stop";
    case Mode::reset_can:
      return "reset-can";
    case Mode::restart:
      return "restart";
  }
  return "unknown";
}

SetPolling to_polling(const cansync_Command& command, JobId id) {
  SetPolling request;
  request.id = id;
  request.polling = {dds::to_cursor(command.polling_one), dds::to_cursor(command.polling_two)};
  if (command.maximum_slave >= 0) {
    request.maximum_slave = SlaveNumber::from(static_cast<std::uint64_t>(command.maximum_slave));
  }
  return request;
}

SetCursors to_cursors(const cansync_Command& command, JobId id) {
  return {id, dds::to_cursor(command.cursor_control_word), dds::to_cursor(command.cursor_parameter),
          dds::to_cursor(command.cursor_transfer)};
}

std::string text(const std::optional<cansync::Cursor>& cursor) {
  return cursor ? cursor_text(*cursor) : "unchanged";
}

std::string text(const cansync::ProcessMapping& mapping) {
  std::uint8_t bytes[8] = {};
  dds::to_registers(mapping, bytes);
  std::string out;
  for (const unsigned byte : bytes) out += fmt::format("{}{:02X}", out.empty() ? "" : " ", byte);
  return out;
}

struct Describer {
  const Config& config;
  using Text = std::optional<std::string>;

  Text operator()(const cansync::ParameterRequest& r) const {
    if (!r.write) return std::nullopt;
    const bool own = r.sub_slave.value == 0;
    return fmt::format("write {} sub-slave {} {} = {} (0x{:X})", slave_label(config, r.slave.value()),
                       r.sub_slave.value,
                       own ? parameter_label(config, r.slave.value(), r.number.value())
                           : fmt::format("parameter {}", r.number.value()),
                       r.value, r.value);
  }
  Text operator()(const cansync::TransferRequest& r) const {
    if (r.direction == cansync::TransferRequest::Direction::upload) return std::nullopt;
    return fmt::format("download {} bytes to {} sub-slave {} address 0x{:X}", r.data.size(),
                       slave_label(config, r.slave.value()), r.sub_slave.value, r.address);
  }
  Text operator()(const cansync::ControlWordRequest& r) const {
    return fmt::format("control word 0x{:04X} to {}", r.control_word, slave_label(config, r.slave.value()));
  }
  Text operator()(const cansync::BroadcastRequest& r) const {
    return fmt::format("broadcast {} to slaves 0x{:08X}: command {}, data 0x{:02X} 0x{:04X}", r.priority,
                       r.action.slaves.bits, r.action.command, r.action.data_byte, r.action.data_word);
  }
  Text operator()(const ModeRequest& r) const {
    return fmt::format("mode {}{}", name(r.mode), r.force ? " with force" : "");
  }
  Text operator()(const SetPolling& r) const {
    return fmt::format("polling 1 {}, 2 {}, maximum slave {}", text(r.polling[0]), text(r.polling[1]),
                       r.maximum_slave ? std::to_string(r.maximum_slave->value()) : "unchanged");
  }
  Text operator()(const SetCursors& r) const {
    return fmt::format("cursors control word {}, parameter {}, transfer {}", text(r.control_word),
                       text(r.parameter), text(r.transfer));
  }
  Text operator()(const SetReferenceMapping& r) const {
    return fmt::format("mapping of the reference values {}", text(r.mapping));
  }
  Text operator()(const SetActualMapping& r) const {
    return fmt::format("mapping of the actual values of {} {}", slave_label(config, r.slave.value()),
                       text(r.mapping));
  }
  Text operator()(const ReleaseSlave& r) const {
    return fmt::format("release of {}{}", slave_label(config, r.slave.value()), r.force ? " with force" : "");
  }
  Text operator()(const cansync::ReferenceUpdate&) const { return std::nullopt; }
  Text operator()(const Cancel&) const { return std::nullopt; }
  Text operator()(const StopRelease&) const { return std::nullopt; }
};

template <class T>
std::optional<T> if_new(const T& from, const T& to) {
  return from == to ? std::nullopt : std::optional(to);
}

}  // namespace

std::string cursor_text(const cansync::Cursor& cursor) {
  switch (cursor.kind) {
    case cansync::Cursor::Kind::automatic:
      return "automatic";
    case cansync::Cursor::Kind::nobody:
      return "nobody";
    case cansync::Cursor::Kind::fixed:
      break;
  }
  return fmt::format("slave {}", cursor.slave.value());
}

std::optional<Request> to_request(const cansync_Command& command, JobId id) {
  switch (command.kind) {
    case cansync_COMMAND_CONTROL_WORD:
      return dds::to_control_word(command, id);
    case cansync_COMMAND_BROADCAST:
      return dds::to_broadcast(command, id);
    case cansync_COMMAND_MODE:
      if (const auto mode = to_mode(command.mode)) return ModeRequest{id, *mode, command.force};
      return std::nullopt;
    case cansync_COMMAND_POLLING:
      return to_polling(command, id);
    case cansync_COMMAND_CHANNEL_CURSORS:
      return to_cursors(command, id);
    case cansync_COMMAND_REFERENCE_MAPPING:
      if (const auto mapping = dds::to_mapping(command.mapping)) return SetReferenceMapping{id, *mapping};
      return std::nullopt;
    case cansync_COMMAND_ACTUAL_MAPPING: {
      const auto slave = SlaveNumber::from(command.slave);
      const auto mapping = dds::to_mapping(command.mapping);
      if (slave && mapping) return SetActualMapping{id, *slave, *mapping};
      return std::nullopt;
    }
    case cansync_COMMAND_RELEASE:
      if (const auto slave = SlaveNumber::from(command.slave)) return ReleaseSlave{id, *slave, command.force};
      return std::nullopt;
  }
  return std::nullopt;
}

std::optional<std::string> describe(const Request& request, const Config& config) {
  return std::visit(Describer{config}, request);
}

std::vector<Request> changes(const Config& from, const Config& to) {
  std::vector<Request> requests;
  const auto& old_process = from.master.process;
  const auto& process = to.master.process;
  if (old_process.reference_mapping != process.reference_mapping) {
    requests.emplace_back(SetReferenceMapping{0, process.reference_mapping});
  }
  for (std::uint8_t i = 0; i < cansync::kSlaves; ++i) {
    const auto& mapping = to.master.slaves[i].actual_mapping;
    if (!from.master.slaves[i].configured || from.master.slaves[i].actual_mapping == mapping) continue;
    requests.emplace_back(SetActualMapping{0, *SlaveNumber::from(i), mapping});
  }
  SetPolling polling;
  polling.polling = {if_new(old_process.polling[0], process.polling[0]),
                     if_new(old_process.polling[1], process.polling[1])};
  polling.maximum_slave = if_new(old_process.maximum_slave, process.maximum_slave);
  if (polling.polling[0] || polling.polling[1] || polling.maximum_slave) requests.emplace_back(polling);
  const auto& old_channel = from.master.command_channel;
  const auto& channel = to.master.command_channel;
  const SetCursors cursors{0, if_new(old_channel.control_word, channel.control_word),
                           if_new(old_channel.parameter, channel.parameter),
                           if_new(old_channel.transfer, channel.transfer)};
  if (cursors.control_word || cursors.parameter || cursors.transfer) requests.emplace_back(cursors);
  return requests;
}

}  // namespace cansyncd
