#include "daemon/desk/gateway_replies.h"

#include <algorithm>
#include <memory>

namespace cansyncd {
namespace {

struct EndpointDeleter {
  void operator()(dds_builtintopic_endpoint_t* endpoint) const noexcept {
    dds_builtintopic_free_endpoint(endpoint);
  }
};
using Endpoint = std::unique_ptr<dds_builtintopic_endpoint_t, EndpointDeleter>;

Place place_of(const dds_builtintopic_endpoint_t& endpoint) noexcept {
  Place place;
  std::copy(std::begin(endpoint.participant_key.v), std::end(endpoint.participant_key.v), place.begin());
  return place;
}

}  // namespace

Place PlaceFinder::find(dds_entity_t reader, dds_instance_handle_t writer) {
  if (const auto known = known_.find(writer); known != known_.end()) return known->second;
  const Endpoint endpoint(dds_get_matched_publication_data(reader, writer));
  if (!endpoint) return {};
  // Writers come and go for years; what is thrown away here is found again.
  constexpr std::size_t kRemembered = 1024;
  if (known_.size() >= kRemembered) known_.clear();
  return known_[writer] = place_of(*endpoint);
}

void MatchedPlaces::look(dds_entity_t writer) {
  dds_publication_matched_status_t status = {};
  known_ = dds_get_publication_matched_status(writer, &status) == DDS_RETCODE_OK;
  if (!known_ || (status.current_count == current_ && status.total_count == total_)) return;
  current_ = status.current_count;
  total_ = status.total_count;
  std::vector<dds_instance_handle_t> readers(current_);
  const dds_return_t found = dds_get_matched_subscriptions(writer, readers.data(), readers.size());
  readers.resize(std::min(readers.size(), static_cast<std::size_t>(std::max(found, 0))));
  // Those that have left are kept, because nobody needs to wait for them; not for ever.
  constexpr std::size_t kRemembered = 4096;
  if (places_.size() > kRemembered) places_.clear();
  for (const auto handle : readers) {
    const Endpoint endpoint(dds_get_matched_subscription_data(writer, handle));
    if (endpoint) places_.insert(place_of(*endpoint));
  }
}

}  // namespace cansyncd
