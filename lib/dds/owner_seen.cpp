#include "dds/owner_seen.h"

#include <fmt/format.h>

namespace gateway::dds {

std::int32_t strength_over(std::int32_t wanted, std::initializer_list<OwnerSeen> owners) noexcept {
  if (wanted != kTakeOver) return wanted;
  std::int32_t over = 0;
  for (const OwnerSeen& owner : owners) over = std::max(over, owner.strength);
  return over == std::numeric_limits<std::int32_t>::max() ? over : over + 1;
}

std::array<std::uint8_t, 16> guid_of(const WriterBase& writer) noexcept {
  std::array<std::uint8_t, 16> out = {};
  dds_guid_t guid = {};
  if (writer.permitted() && dds_get_guid(writer.handle(), &guid) == DDS_RETCODE_OK)
    std::copy(std::begin(guid.v), std::end(guid.v), out.begin());
  return out;
}

std::string had_by_another(std::string_view what, const OwnerSeen& owner, const WriterBase& writer,
                           std::int32_t strength) {
  if (owner.writer.empty()) return {};
  if (owner.guid == decltype(owner.guid){})
    return fmt::format("{}: {} gives it, and no program may", what, owner.writer);
  if (strength > owner.strength || owner.guid == guid_of(writer)) return {};
  return fmt::format(
      "{}: {} has it with strength {}, and this program, with strength {}, waits until it has gone; a higher "
      "strength takes over",
      what, owner.writer, owner.strength, strength);
}

}  // namespace gateway::dds
