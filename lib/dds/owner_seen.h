#pragma once

#include <dds/dds.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <string>
#include <string_view>

#include "dds/endpoint.h"

namespace gateway::dds {

/// In the place of a strength: one more than that of whoever has it when the writer is made.
inline constexpr std::int32_t kTakeOver = std::numeric_limits<std::int32_t>::min();

/// Who has something that one writer has at a time, as the daemon tells it in its status.
struct OwnerSeen {
  std::string_view writer;  ///< empty: nobody
  std::int32_t strength = 0;
  std::array<std::uint8_t, 16> guid = {};  ///< all 0 with a writer: no program may have it

  bool operator==(const OwnerSeen&) const = default;
};

/// A member of a status that tells of it: `writer` or another text, `strength`, `writer_guid`.
template <class Writer, class Guid>
OwnerSeen owner_seen(const Writer& writer, std::int32_t strength, const Guid& guid) noexcept {
  OwnerSeen seen{std::string_view(writer), strength};
  std::copy(std::begin(guid), std::end(guid), seen.guid.begin());
  return seen;
}

/// A strength that takes over from all of them, 1 and more; or the one that is wanted.
std::int32_t strength_over(std::int32_t wanted, std::initializer_list<OwnerSeen> owners) noexcept;

/// The GUID of a writer of this process; all 0: it has none, for its identity may not write the topic.
std::array<std::uint8_t, 16> guid_of(const WriterBase& writer) noexcept;

/// Marks a sample as that of this writer, so that DDS keeps it apart from those of others.
template <class Sample>
void set_writer(const WriterBase& writer, Sample& sample) noexcept {
  const auto guid = guid_of(writer);
  std::copy(guid.begin(), guid.end(), std::begin(sample.writer));
}

/// Why a writer of this process must not write what another one has that is no weaker. Empty: it may. `what`:
/// e.g. "telegram 1 of the reference values".
std::string had_by_another(std::string_view what, const OwnerSeen& owner, const WriterBase& writer,
                           std::int32_t strength);

}  // namespace gateway::dds
