#pragma once

#include <dds/dds.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <set>
#include <span>

#include "dds/signal.h"

namespace cansync::dds {

/// Keeps a reader from being filled with keys: DDS keeps a key for as long as its writer lives, and a reader
/// whose keys are used up holds up what everybody else writes. Samples with one key too many are dropped
/// before the reader keeps anything of them, and counted. Thread safe.
class KeyGuard {
 public:
  /// Most keys of one writer, and of all writers together.
  static constexpr std::size_t kKeysPerWriter = 16;
  static constexpr std::size_t kKeys = 256;

  /// `signal` is raised when a sample was dropped; it must outlive the guard.
  explicit KeyGuard(DataSignal& signal) noexcept : signal_(signal) {}
  KeyGuard(const KeyGuard&) = delete;
  KeyGuard& operator=(const KeyGuard&) = delete;

  /// Guards the readers of this topic entity that are made after; they must be deleted before the guard. A
  /// negative DDS return code when that cannot be done.
  dds_return_t install(dds_entity_t topic) noexcept;

  /// Forgets the keys of writers that are not in `living`.
  void keep(std::span<const dds_instance_handle_t> living);

  /// Samples dropped since the last call.
  std::uint64_t take_dropped() noexcept;

 private:
  static bool accept(const dds_sample_info_t* info, void* guard) noexcept;
  bool known_or_allowed(dds_instance_handle_t writer, dds_instance_handle_t key);

  DataSignal& signal_;
  std::mutex mutex_;
  std::map<dds_instance_handle_t, std::set<dds_instance_handle_t>> keys_;  ///< by writer
  std::size_t count_ = 0;                                                  ///< of keys
  std::uint64_t dropped_ = 0;
};

}  // namespace cansync::dds
