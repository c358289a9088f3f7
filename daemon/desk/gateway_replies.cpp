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

}  // namespace cansyncd
