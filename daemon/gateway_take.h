#pragma once

#include <dds/dds.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include "dds/endpoint.h"

namespace cansyncd {

/// Takes every sample of `reader` in order, like `Reader::take`, but with its information (who wrote it,
/// when, and whether it is data or tells that the key's last writer is gone): `on_sample(const T&, const
/// dds_sample_info_t&)`. Samples are lent for the call only.
template <class T, class OnSample>
void take_with_info(cansync::dds::Reader<T>& reader, OnSample&& on_sample) {
  constexpr std::uint32_t kBatch = 64;
  struct Loan {
    dds_entity_t reader;
    void** samples;
    std::int32_t count;
    ~Loan() { (void)dds_return_loan(reader, samples, count); }
  };
  for (;;) {
    std::array<void*, kBatch> samples = {};
    std::array<dds_sample_info_t, kBatch> infos;
    const dds_return_t count = dds_take(reader.handle(), samples.data(), infos.data(), kBatch, kBatch);
    if (count <= 0) return;
    const Loan loan{reader.handle(), samples.data(), count};
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      on_sample(*static_cast<const T*>(samples[i]), infos[i]);
    }
  }
}

}  // namespace cansyncd
