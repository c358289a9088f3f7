#pragma once

#include <dds/dds.h>

namespace gateway::dds {

/// Decides which samples a reader keeps, before it keeps anything of them.
class TopicGuard {
 public:
  TopicGuard() = default;
  TopicGuard(const TopicGuard&) = delete;
  TopicGuard& operator=(const TopicGuard&) = delete;
  virtual ~TopicGuard() = default;

  /// Guards the readers of this topic entity that are made after; they must be deleted before the guard. Those
  /// of another topic entity must be deleted already, and what it knew of them is forgotten. A negative DDS
  /// return code when that cannot be done.
  dds_return_t install(dds_entity_t topic) noexcept {
    forget();
    dds_topic_filter filter = {};
    filter.mode = DDS_TOPIC_FILTER_SAMPLE_SAMPLEINFO_ARG;
    filter.f.sample_sampleinfo_arg = [](const void* sample, const dds_sample_info_t* info, void* guard) {
      return static_cast<TopicGuard*>(guard)->accept(sample, *info);
    };
    filter.arg = this;
    return dds_set_topic_filter_extended(topic, &filter);
  }

 private:
  /// True: the reader keeps the sample. Called by threads of DDS.
  virtual bool accept(const void* sample, const dds_sample_info_t& info) noexcept = 0;
  /// Samples that were let in and not taken are gone with their reader.
  virtual void forget() noexcept = 0;
};

}  // namespace gateway::dds
