#include "cansync_slave/dds/validate.h"

#include <fmt/format.h>

#include <iterator>
#include <span>
#include <string_view>

#include "cansync_slave/dds/convert.h"
#include "dds/enumerator.h"

namespace cansync_slave::dds {

using gateway::dds::Denial;

namespace {

gateway::dds::Problem check_mapping(std::string_view name, std::span<const std::uint8_t, 8> bytes) {
  using cansync::Channel;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const auto word = cansync::from_register(bytes[i]);
    const bool second = i >= cansync::kWords;
    const bool fits = word && (!word->assigned || (word->value >= cansync::kWords) == second);
    if (!fits)
      return Denial{
          gateway_CAUSE_MAPPING,
          fmt::format("{}[{}] 0x{:02X}: allowed 0, or bit 0, bit 1 for the high word and a value of "
                      "{} in bits 2..6",
                      name, i, bytes[i], second ? "4..7" : "0..3")};
  }
  return std::nullopt;
}

}  // namespace

gateway::dds::Problem check(const cansync_slave_SlaveCommand& command) {
  const std::int64_t kind = gateway::dds::raw_number_of(command.kind);
  const std::int64_t mode = gateway::dds::raw_number_of(command.mode);
  switch (kind) {
    case cansync_slave_SLAVE_COMMAND_MODE:
      if (mode >= cansync_slave_SLAVE_MODE_SETUP && mode <= cansync_slave_SLAVE_MODE_RESET_CAN)
        return std::nullopt;
      return Denial{gateway_CAUSE_KIND, fmt::format("mode {}: unknown to this daemon", mode)};
    case cansync_slave_SLAVE_COMMAND_MAPPING:
      if (auto problem = check_mapping("reference_mapping", command.reference_mapping)) return problem;
      return check_mapping("actual_mapping", command.actual_mapping);
    case cansync_slave_SLAVE_COMMAND_LISTEN:
      if (!cansync::SlaveNumber::from(command.other))
        return Denial{gateway_CAUSE_FIELD,
                      fmt::format("other {}: out of range; allowed 0..31", command.other)};
      return check_mapping("actual_mapping", command.actual_mapping);
    default:
      break;
  }
  return Denial{gateway_CAUSE_KIND, fmt::format("kind {}: unknown to this daemon", kind)};
}

gateway::dds::Problem check(const cansync_slave_ActualRelease& release) {
  constexpr unsigned kMostValid = 0x0F;
  if (release.telegram != 1 && release.telegram != 2)
    return Denial{gateway_CAUSE_FIELD,
                  fmt::format("telegram {}: out of range; allowed 1 or 2", release.telegram)};
  if (release.valid > kMostValid)
    return Denial{gateway_CAUSE_FIELD,
                  fmt::format("valid 0x{:02X}: out of range; allowed 0..0x0F", release.valid)};
  if (release.wait_intervals > kMostWaitIntervals)
    return Denial{gateway_CAUSE_FIELD, fmt::format("wait_intervals {}: out of range; allowed 0..{}, 0 = 1",
                                                   release.wait_intervals, kMostWaitIntervals)};
  return std::nullopt;
}

gateway::dds::Problem check(const cansync_slave_ApplicationAnswer& answer) {
  constexpr unsigned kMostParameter = 4095;
  constexpr unsigned kFirstBlockError = 0x0100;
  constexpr unsigned kMostLength = 4095;
  if (static_cast<unsigned>(answer.kind) > cansync_slave_ANSWER_BLOCK_REFUSED)
    return Denial{gateway_CAUSE_KIND, fmt::format("kind {}: this daemon does not know it; allowed 0..{}",
                                                  static_cast<unsigned>(answer.kind),
                                                  static_cast<unsigned>(cansync_slave_ANSWER_BLOCK_REFUSED))};
  for (std::uint32_t i = 0; i < answer.parameters._length; ++i) {
    if (answer.parameters._buffer[i] > kMostParameter)
      return Denial{gateway_CAUSE_FIELD, fmt::format("parameters[{}] {}: out of range; allowed 0..{}", i,
                                                     answer.parameters._buffer[i], kMostParameter)};
  }
  if (answer.kind == cansync_slave_ANSWER_BLOCK_REFUSED && answer.error < kFirstBlockError)
    return Denial{gateway_CAUSE_FIELD,
                  fmt::format("error 0x{:04X}: out of range; allowed 0x0100..0xFFFF", answer.error)};
  if (answer.length > kMostLength)
    return Denial{gateway_CAUSE_FIELD,
                  fmt::format("length {}: out of range; allowed 0..{}", answer.length, kMostLength)};
  return std::nullopt;
}

}  // namespace cansync_slave::dds
