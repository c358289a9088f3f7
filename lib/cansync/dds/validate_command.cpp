#include <fmt/format.h>

#include "cansync/dds/convert.h"
#include "cansync/dds/ranges.h"
#include "cansync/dds/validate.h"
#include "cansync/telegram/mapping.h"
#include "cansync/telegram/telegram.h"
#include "dds/enumerator.h"

namespace cansync::dds {
namespace {

using gateway::dds::Denial;

constexpr std::int32_t kUnchanged = -2;
constexpr std::uint32_t kFirstUserAction = 128;

Problem check_broadcast(const cansync_Command& command, const Limits& limits) {
  if (Problem problem = in_range("priority", command.priority, 0, 2)) return problem;
  if (command.slave_mask == 0) {
    return Denial{
        gateway_CAUSE_NO_SLAVES,
        fmt::format("slave_mask 0x0: no slave; allowed bits of the configured slaves {}, or 0xFFFFFFFF",
                    list_of(limits.configured))};
  }
  const bool everybody = command.slave_mask == SlaveMask::all().bits;  // also slaves nobody has configured
  const std::uint32_t strangers = everybody ? 0 : command.slave_mask & ~limits.configured.bits;
  if (strangers != 0) {
    return Denial{
        gateway_CAUSE_SLAVE_NOT_CONFIGURED,
        fmt::format(
            "slave_mask 0x{:X}: slaves {} are not configured; allowed bits of {}, or 0xFFFFFFFF for all that are on the bus",
            command.slave_mask, list_of({strangers}), list_of(limits.configured))};
  }
  if (command.action != kCommandControlWord && (command.action < kFirstUserAction || command.action > 255)) {
    return Denial{gateway_CAUSE_ACTION_RESERVED,
                  fmt::format("action {}: reserved or out of range; allowed 1 (control word) and 128..255",
                              command.action)};
  }
  if (Problem problem = in_range("data_byte", command.data_byte, 0, 0xFF)) return problem;
  if (Problem problem = in_range("data_word", command.data_word, 0, 0xFFFF)) return problem;
  return timeout_in_range(command.timeout);
}

Problem check_cursor(std::string_view field, std::int32_t code, const Limits& limits) {
  if (code == kUnchanged) return std::nullopt;
  const std::optional<Cursor> cursor = to_cursor(code);
  if (!cursor) {
    return Denial{
        gateway_CAUSE_FIELD,
        fmt::format("{} {}: out of range; allowed a slave 0..31, -128 automatic, -1 nobody, -2 unchanged",
                    field, code)};
  }
  if (cursor->kind != Cursor::Kind::fixed) return std::nullopt;
  return configured_slave(field, cursor->slave.value(), limits);
}

Problem check_polling(const cansync_Command& command, const Limits& limits) {
  if (Problem problem = check_cursor("polling_one", command.polling_one, limits)) return problem;
  if (Problem problem = check_cursor("polling_two", command.polling_two, limits)) return problem;
  if (command.maximum_slave == kUnchanged) return std::nullopt;
  if (command.maximum_slave < 0 || command.maximum_slave > SlaveNumber::max) {
    return Denial{
        gateway_CAUSE_FIELD,
        fmt::format("maximum_slave {}: out of range; allowed 0..31, -2 unchanged", command.maximum_slave)};
  }
  return std::nullopt;
}

Problem check_cursors(const cansync_Command& command, const Limits& limits) {
  if (Problem problem = check_cursor("cursor_control_word", command.cursor_control_word, limits))
    return problem;
  if (Problem problem = check_cursor("cursor_parameter", command.cursor_parameter, limits)) return problem;
  return check_cursor("cursor_transfer", command.cursor_transfer, limits);
}

Problem check_mapping(const cansync_Command& command) {
  for (unsigned i = 0; i < 2 * kWords; ++i) {
    const std::uint8_t byte = command.mapping[i];
    const std::optional<WordMapping> word = from_register(byte);
    if (!word) {
      return Denial{
          gateway_CAUSE_MAPPING,
          fmt::format(
              "mapping[{}] 0x{:02X}: no register byte; allowed 0 (unused), or bit 0 set, bit 1 high word, bits "
              "2..6 value 0..7, bit 7 zero",
              i, byte)};
    }
    const unsigned telegram = i / kWords;
    if (word->assigned && word->value / 4u != telegram) {
      return Denial{
          gateway_CAUSE_MAPPING,
          fmt::format("mapping[{}] 0x{:02X}: value {} does not belong to telegram {}; allowed {}..{}", i,
                      byte, word->value, telegram + 1, 4 * telegram, 4 * telegram + 3)};
    }
  }
  return std::nullopt;
}

}  // namespace

Problem check(const cansync_Command& command, const Limits& limits) {
  if (Problem problem = in_range("kind", gateway::dds::raw_number_of(command.kind), 0,
                                 static_cast<std::int64_t>(cansync_COMMAND_RELEASE))) {
    return problem;
  }
  switch (command.kind) {
    case cansync_COMMAND_CONTROL_WORD:
      if (Problem problem = configured_slave("slave", command.slave, limits)) return problem;
      if (Problem problem = in_range("control_word", command.control_word, 0, 0xFFFF)) return problem;
      return timeout_in_range(command.timeout);
    case cansync_COMMAND_BROADCAST:
      return check_broadcast(command, limits);
    case cansync_COMMAND_MODE:
      return in_range("mode", gateway::dds::raw_number_of(command.mode), 0,
                      static_cast<std::int64_t>(cansync_MODE_RESTART));
    case cansync_COMMAND_POLLING:
      return check_polling(command, limits);
    case cansync_COMMAND_CHANNEL_CURSORS:
      return check_cursors(command, limits);
    case cansync_COMMAND_REFERENCE_MAPPING:
      return check_mapping(command);
    case cansync_COMMAND_ACTUAL_MAPPING:
      if (Problem problem = configured_slave("slave", command.slave, limits)) return problem;
      return check_mapping(command);
    case cansync_COMMAND_RELEASE:
      return configured_slave("slave", command.slave, limits);
  }
  return std::nullopt;
}

}  // namespace cansync::dds
