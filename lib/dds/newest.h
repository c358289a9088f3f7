#pragma once

#include <dds/dds.h>

#include <cstdint>
#include <optional>

#include "dds/endpoint.h"
#include "dds/writer_identity.h"

namespace gateway::dds {

/// What a writer that is there told last, on a topic without keys. Of a writer that is gone nothing is known: what
/// another one, which is there yet, told before it is known when it tells again. `T` has no sequences. One thread.
template <class T>
class Newest {
 public:
  /// Takes what has come to `reader`, always the same. Nothing: nobody who is there has told anything.
  const std::optional<T>& take(Reader<T>& reader) {
    bool is_alive = true;
    const auto on_sample = [&](const T& sample, const dds_sample_info_t& info) {
      is_alive = info.instance_state == DDS_IST_ALIVE;
      if (!info.valid_data) return;
      told_ = sample;
      writer_ = info.publication_handle;
    };
    while (reader.take_batch(on_sample) == ReaderBase::kBatch) {
    }
    if (!is_alive || !is_there(reader)) told_.reset();
    return told_;
  }

  /// As it was taken last.
  const std::optional<T>& told() const noexcept { return told_; }

 private:
  /// Its writer; DDS is asked after a change only, for it may keep who asks waiting.
  bool is_there(const Reader<T>& reader) {
    const std::uint32_t matched = reader.matched();
    if (matched == matched_ && writer_ == looked_for_) return true;
    matched_ = matched;
    looked_for_ = writer_;
    return participant_of_writer(reader.handle(), writer_) != 0;
  }

  std::optional<T> told_;
  dds_instance_handle_t writer_ = 0;
  dds_instance_handle_t looked_for_ = 0;
  std::uint32_t matched_ = 0;
};

}  // namespace gateway::dds
