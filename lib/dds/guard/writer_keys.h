#pragma once

#include <dds/dds.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <set>
#include <span>

namespace gateway::dds {

/// Which keys the writers of a reader use, in bounds: DDS keeps a key for as long as its writer lives. Not
/// thread safe.
class WriterKeys {
 public:
  WriterKeys(std::size_t per_writer, std::size_t together) noexcept
      : per_writer_(per_writer), together_(together) {}

  /// False: the key is one too many. Throws std::bad_alloc.
  bool known_or_allowed(dds_instance_handle_t writer, dds_instance_handle_t key);
  /// Forgets the keys of writers that are not in `living`.
  void keep(std::span<const dds_instance_handle_t> living);

 private:
  const std::size_t per_writer_;
  const std::size_t together_;
  std::map<dds_instance_handle_t, std::set<dds_instance_handle_t>> keys_;  ///< by writer
  std::size_t count_ = 0;                                                  ///< of keys
};

}  // namespace gateway::dds
