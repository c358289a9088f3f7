#include "daemon/desk/writer_watch.h"

#include <algorithm>
#include <cstddef>

namespace cansyncd {

bool WriterWatch::look() {
  dds_subscription_matched_status_t matched = {};
  dds_liveliness_changed_status_t liveliness = {};
  if (dds_get_subscription_matched_status(reader_.handle(), &matched) != DDS_RETCODE_OK) return false;
  if (dds_get_liveliness_changed_status(reader_.handle(), &liveliness) != DDS_RETCODE_OK) return false;
  const Counts now{reader_.handle(), matched.current_count, matched.total_count, liveliness.alive_count,
                   liveliness.not_alive_count};
  if (now == counts_) return false;
  some_died_ = now.dead > counts_.dead;
  const bool one_alone = now.dead == counts_.dead + 1 && now.alive + 1 == counts_.alive &&
                         now.matched_ever == counts_.matched_ever;
  dead_ = one_alone ? liveliness.last_publication_handle : 0;
  counts_ = now;
  return true;
}

bool WriterWatch::left(dds_instance_handle_t writer) const {
  dds_builtintopic_endpoint_t* const endpoint = dds_get_matched_publication_data(reader_.handle(), writer);
  if (endpoint == nullptr) return true;
  dds_builtintopic_free_endpoint(endpoint);
  return false;
}

bool WriterWatch::gone(dds_instance_handle_t writer, bool shares) const {
  const bool died = dead_ != 0 ? dead_ == writer : shares;
  return (some_died_ && died) || left(writer);
}

std::vector<dds_instance_handle_t> WriterWatch::living() const {
  // One that is matched only now is found by the next look: the counts have changed then.
  std::vector<dds_instance_handle_t> writers(counts_.matched);
  const dds_return_t found = dds_get_matched_publications(reader_.handle(), writers.data(), writers.size());
  writers.resize(std::min(writers.size(), static_cast<std::size_t>(std::max(found, 0))));
  return writers;
}

const gateway::dds::WriterIdentity& WriterWatch::identify(dds_instance_handle_t writer) {
  if (const auto known = known_.find(writer); known != known_.end()) return known->second;
  // Writers come and go for years; what is thrown away here is found again.
  constexpr std::size_t kRemembered = 64;
  if (known_.size() >= kRemembered) known_.clear();
  auto identity = identify_writer(participant_, reader_.handle(), writer);
  if (!identity) identity = gateway::dds::WriterIdentity{"a program that has left already"};
  return known_[writer] = *identity;
}

}  // namespace cansyncd
