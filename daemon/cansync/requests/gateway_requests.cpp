#include "daemon/cansync/requests/gateway_requests.h"

#include <fmt/format.h>

#include "cansync/dds/convert.h"
#include "daemon/cansync/requests/kinds.h"

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
  return with_row(request, [&](auto row, const auto& kind) { return row.text(kind, config); });
}

std::vector<Request> changes(const Config& from, const Config& to) {
  std::vector<Request> requests;
  const cansync::SettingsInForce before = cansync::in_force(from.master);
  const cansync::SettingsInForce now = cansync::in_force(to.master);
  if (before.reference_mapping != now.reference_mapping) {
    requests.emplace_back(SetReferenceMapping{0, now.reference_mapping});
  }
  for (std::uint8_t i = 0; i < cansync::kSlaves; ++i) {
    const auto& mapping = now.actual_mapping[i];
    if (!from.master.slaves[i].configured || before.actual_mapping[i] == mapping) continue;
    requests.emplace_back(SetActualMapping{0, *SlaveNumber::from(i), mapping});
  }
  for (std::uint8_t i = 0; i < cansync::kValues; ++i) {
    if (before.reference_limits[i] != now.reference_limits[i])
      requests.emplace_back(SetReferenceLimits{0, i, now.reference_limits[i]});
  }
  SetPolling polling;
  polling.polling = {if_new(before.polling[0], now.polling[0]), if_new(before.polling[1], now.polling[1])};
  polling.maximum_slave = if_new(before.maximum_slave, now.maximum_slave);
  if (polling.polling[0] || polling.polling[1] || polling.maximum_slave) requests.emplace_back(polling);
  const SetCursors cursors{0, if_new(before.control_word, now.control_word),
                           if_new(before.parameter, now.parameter), if_new(before.transfer, now.transfer)};
  if (cursors.control_word || cursors.parameter || cursors.transfer) requests.emplace_back(cursors);
  return requests;
}

}  // namespace cansyncd
