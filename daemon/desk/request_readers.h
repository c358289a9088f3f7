#pragma once

#include <dds/dds.h>

#include <cstddef>
#include <vector>

#include "daemon/desk/client_table.h"
#include "daemon/desk/gateway_events.h"
#include "daemon/desk/gateway_replies.h"
#include "daemon/desk/rejections.h"
#include "dds/endpoint.h"
#include "dds/guard/key_guard.h"

namespace cansyncd {

/// What guards of requests have in common, whatever their readers take: who may still write, and what was
/// dropped before it could be taken. Gateway thread only.
class RequestReaders {
 public:
  /// Requests that are refused unread, in one pass and of one reader.
  static constexpr std::size_t kRefusedAtOnce = 16;

  /// Both must outlive the object. No reader may be added after the first `look`.
  void add(const gateway::dds::ReaderBase& reader, gateway::dds::KeyGuard& guard) {
    endpoints_.push_back(&reader);
    guards_.push_back(&guard);
  }

  /// Looks which participants have a writer of requests; guards forget the others.
  const LivingPlaces& look(PlaceFinder& places, SteadyTime now);

  /// As they were when it looked.
  const LivingPlaces& living() const noexcept { return living_; }

  /// Counts and tells what was dropped: keys too many, requests without room for a refusal, samples DDS could
  /// not read.
  void count_dropped(Rejections& rejections, EventPublisher& events, SteadyTime now);

 private:
  std::vector<const gateway::dds::ReaderBase*> endpoints_;
  std::vector<gateway::dds::KeyGuard*> guards_;  ///< by reader
  LivingPlaces living_;
};

}  // namespace cansyncd
