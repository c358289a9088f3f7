#include "daemon/cansync/requests/audit_text.h"

#include <fmt/format.h>

#include "cansync/dds/convert.h"
#include "daemon/cansync/requests/gateway_requests.h"
#include "text/counts.h"

namespace cansyncd {
namespace {

/// A number as a client gave it, bounded to what an int holds.
int bounded(std::uint32_t number) noexcept {
  constexpr std::uint32_t kHighest = 0x7FFF'FFFF;
  return static_cast<int>(number < kHighest ? number : kHighest);
}

std::string_view mode_text(cansync_Mode mode) noexcept {
  switch (mode) {
    case cansync_MODE_SETUP:
      return "setup";
    case cansync_MODE_RUN:
      return "run";
    case cansync_MODE_STOP:
      return "stop";
    case cansync_MODE_RESET_CAN:
      return "reset-can";
    case cansync_MODE_RESTART:
      return "restart";
  }
  return "unknown";
}

std::string code_text(std::int32_t code) {
  constexpr std::int32_t kUnchanged = -2;
  if (code == kUnchanged) return "unchanged";
  const auto cursor = cansync::dds::to_cursor(code);
  return cursor ? cursor_text(*cursor) : fmt::format("code {}", code);
}

std::string maximum_slave_text(std::int32_t slave) {
  return slave < 0 ? "unchanged" : std::to_string(slave);
}

}  // namespace

std::optional<Change> change_of(const cansync_ParameterRequest& sample) {
  if (!sample.write) return std::nullopt;
  const std::string what = sample.sub_slave == 0
                               ? fmt::format("parameter {}", sample.number)
                               : fmt::format("parameter {} of sub-slave {}", sample.number, sample.sub_slave);
  return Change{"parameter_write", bounded(sample.slave), what, std::to_string(sample.value),
                bounded(sample.number)};
}

std::optional<Change> change_of(const cansync_TransferRequest& sample) {
  if (sample.direction == cansync_DIRECTION_UPLOAD) return std::nullopt;
  const std::string what =
      sample.sub_slave == 0 ? fmt::format("address 0x{:X}", sample.address)
                            : fmt::format("address 0x{:X} of sub-slave {}", sample.address, sample.sub_slave);
  Change change{"download", bounded(sample.slave), what, text::counted(sample.data._length, "byte")};
  change.hashed = true;
  return change;
}

std::optional<Change> change_of(const cansync_Command& sample) {
  switch (sample.kind) {
    case cansync_COMMAND_CONTROL_WORD:
      return Change{"control_word", bounded(sample.slave), "", fmt::format("0x{:04X}", sample.control_word)};
    case cansync_COMMAND_BROADCAST:
      return Change{"broadcast", -1,
                    fmt::format("priority {}, slaves 0x{:08X}", sample.priority, sample.slave_mask),
                    fmt::format("command {}, data 0x{:02X} 0x{:04X}", sample.action, sample.data_byte,
                                sample.data_word)};
    case cansync_COMMAND_MODE:
      return Change{"mode", -1, "",
                    fmt::format("{}{}", mode_text(sample.mode), sample.force ? " with force" : "")};
    case cansync_COMMAND_POLLING:
      return Change{"polling", -1, "",
                    polling_text(code_text(sample.polling_one), code_text(sample.polling_two),
                                 maximum_slave_text(sample.maximum_slave))};
    case cansync_COMMAND_CHANNEL_CURSORS:
      return Change{"cursors", -1, "",
                    cursors_text(code_text(sample.cursor_control_word), code_text(sample.cursor_parameter),
                                 code_text(sample.cursor_transfer))};
    case cansync_COMMAND_REFERENCE_MAPPING:
      return Change{"reference_mapping", -1, "", mapping_text(sample.mapping)};
    case cansync_COMMAND_ACTUAL_MAPPING:
      return Change{"actual_mapping", bounded(sample.slave), "", mapping_text(sample.mapping)};
    case cansync_COMMAND_RELEASE:
      return Change{"release", bounded(sample.slave), "", sample.force ? "released by force" : "released"};
  }
  return Change{"unknown", -1, fmt::format("kind {}", static_cast<unsigned>(sample.kind)), ""};
}

std::string polling_text(const std::string& one, const std::string& two, const std::string& maximum_slave) {
  return fmt::format("1 {}, 2 {}, maximum slave {}", one, two, maximum_slave);
}

std::string cursors_text(const std::string& control_word, const std::string& parameter,
                         const std::string& transfer) {
  return fmt::format("control word {}, parameter {}, transfer {}", control_word, parameter, transfer);
}

std::string mapping_text(const std::uint8_t (&bytes)[8]) {
  std::string out;
  for (const unsigned byte : bytes) out += fmt::format("{}{:02X}", out.empty() ? "" : " ", byte);
  return out;
}

std::string mapping_text(const cansync::ProcessMapping& mapping) {
  std::uint8_t bytes[8] = {};
  cansync::dds::to_registers(mapping, bytes);
  return mapping_text(bytes);
}

}  // namespace cansyncd
