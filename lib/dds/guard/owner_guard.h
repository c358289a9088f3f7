#pragma once

#include <dds/dds.h>

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>

#include "dds/guard/topic_guard.h"
#include "dds/guard/writer_keys.h"
#include "dds/signal.h"

namespace gateway::dds {

/// Keeps programs from filling the reader of a topic that one writer has at a time: each writer has keys of
/// its own there, and samples with one key too many are dropped and counted. Thread safe.
class OwnerGuard final : public TopicGuard {
 public:
  /// Most keys of one writer: its telegrams, and some that do not exist, to be refused. And of all together.
  static constexpr std::size_t kKeysPerWriter = 8;
  static constexpr std::size_t kKeys = 256;

  /// `signal` is raised when a sample was dropped; it must outlive the guard.
  explicit OwnerGuard(DataSignal& signal) : signal_(signal) {}

  /// Forgets the keys of writers that are not in `living`.
  void keep(std::span<const dds_instance_handle_t> living);
  /// Samples that were dropped since the last call.
  std::uint64_t take_dropped() noexcept;

 private:
  bool accept(const void* sample, const dds_sample_info_t& info) noexcept override;
  void forget() noexcept override { keep({}); }

  DataSignal& signal_;
  std::mutex mutex_;
  WriterKeys keys_{kKeysPerWriter, kKeys};
  std::uint64_t dropped_ = 0;
};

}  // namespace gateway::dds
