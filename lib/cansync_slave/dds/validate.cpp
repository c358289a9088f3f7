#include "cansync_slave/dds/validate.h"

#include <fmt/format.h>

namespace cansync_slave::dds {

using gateway::dds::Denial;

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
