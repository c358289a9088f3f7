#pragma once

#include <dds/dds.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include "dds/endpoint.h"

namespace cansyncd {

/// Takes the oldest samples of `reader` in order, like `Reader::take`, but with their information (who wrote
/// it, when, and whether it is data or tells that the key's last writer is gone): `on_sample(const T&, const
/// dds_sample_info_t&)`. One batch at most, because a writer that never rests must not hold up the rest of
/// the gateway; true: there may be more. Samples are lent for the call only.
template <class T, class OnSample>
bool take_with_info(cansync::dds::Reader<T>& reader, OnSample&& on_sample) {
  struct Loan {
    dds_entity_t reader;
    void** samples;
    std::int32_t count;
    ~Loan() { (void)dds_return_loan(reader, samples, count); }
  };
  constexpr std::uint32_t kMost = cansync::dds::ReaderBase::kBatch;
  std::array<void*, kMost> samples = {};
  std::array<dds_sample_info_t, kMost> infos;
  const dds_return_t count = dds_take(reader.handle(), samples.data(), infos.data(), kMost, kMost);
  if (count <= 0) return false;
  const Loan loan{reader.handle(), samples.data(), count};
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    on_sample(*static_cast<const T*>(samples[i]), infos[i]);
  }
  return static_cast<std::uint32_t>(count) == kMost;
}

}  // namespace cansyncd
