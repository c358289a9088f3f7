#pragma once

#include <dds/dds.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>

namespace gateway::dds {

/// The DDS GUID of a writer; all zero: none.
using WriterGuid = std::array<std::uint8_t, 16>;

inline WriterGuid to_array(const dds_guid_t& guid) noexcept {
  WriterGuid out;
  std::copy(std::begin(guid.v), std::end(guid.v), out.begin());
  return out;
}

/// Of a writer of this program; all zero when DDS does not tell. Any thread.
inline WriterGuid guid_of(dds_entity_t writer) noexcept {
  dds_guid_t guid = {};
  return dds_get_guid(writer, &guid) == DDS_RETCODE_OK ? to_array(guid) : WriterGuid{};
}

/// Of a writer that is matched with `reader`; all zero when it is not. Any thread; asks DDS.
inline WriterGuid guid_of_matched(dds_entity_t reader, dds_instance_handle_t writer) noexcept {
  dds_builtintopic_endpoint_t* const endpoint = dds_get_matched_publication_data(reader, writer);
  if (endpoint == nullptr) return {};
  const WriterGuid guid = to_array(endpoint->key);
  dds_builtintopic_free_endpoint(endpoint);
  return guid;
}

/// The member `application` of a job.
template <class Job>
WriterGuid application_of(const Job& job) noexcept {
  WriterGuid guid;
  std::copy(std::begin(job.application), std::end(job.application), guid.begin());
  return guid;
}

}  // namespace gateway::dds
