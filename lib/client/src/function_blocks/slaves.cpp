#include "client/src/function_blocks/slaves.h"

#include <cansync/topics.h>
#include <fmt/format.h>

#include <algorithm>

namespace cansync::client::function_blocks {

std::optional<InputProblem> slave_problem(const Client& client, SINT number) {
  if (number < 0 || number >= static_cast<int>(cansync_SLAVES))
    return InputProblem{RefusalCause::field,
                        fmt::format("client: slave {}: out of range; allowed 0..31", number)};
  const auto status = client.master_status(std::chrono::milliseconds(0));
  if (!status) return std::nullopt;  // the request itself says that no daemon is there
  const std::uint32_t configured = status->slaves_configured;
  if (((configured >> static_cast<unsigned>(number)) & 1u) == 0)
    return InputProblem{
        RefusalCause::slave_not_configured,
        fmt::format("client: slave {}: not configured in the daemon; configured bits 0x{:08X}", number,
                    configured)};
  return std::nullopt;
}

std::uint32_t milliseconds_of(TIME time) noexcept {
  constexpr TIME::rep kMost = 0x7FFFFFFF;
  return static_cast<std::uint32_t>(std::clamp<TIME::rep>(time.count(), 1, kMost));
}

Mapping mapping_of(const SINT_4_BMARRAY& one, const BOOL_4_BMARRAY& high_one, const SINT_4_BMARRAY& two,
                   const BOOL_4_BMARRAY& high_two) {
  Mapping mapping;
  const auto add = [&](std::size_t word, SINT number, bool high) {
    if (number == -1) return;  // unused: the flag means nothing
    if (number < 0 || number > 7) {
      mapping.problem = fmt::format(
          "client: word {} of telegram {}: value number {} is out of range; allowed 0..3 in telegram 1, 4..7 "
          "in telegram 2, -1 for none",
          word % 4, word / 4 + 1, number);
      return;
    }
    mapping.bytes[word] = static_cast<std::uint8_t>((number << 2) | (high ? 2 : 0) | 1);
  };
  for (std::size_t word = 0; word < 4; ++word) {
    add(word, one[word], high_one[word]);
    add(word + 4, two[word], high_two[word]);
  }
  return mapping;
}

}  // namespace cansync::client::function_blocks
