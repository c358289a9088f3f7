#include "daemon/cansync_slave/realtime/sync_follower.h"

#include <algorithm>

namespace cansyncd {
namespace {

/// Most edges taken from the wire at once.
constexpr unsigned kWireEdgesAtOnce = 16;
/// An edge has come for certain so long after it was due, as a part of the interval; a software SYNC frame
/// ends 47 to 52 bits after its edge.
constexpr int kLookPart = 8;

}  // namespace

void SyncFollower::begin(can::Bus& bus) noexcept {
  if (inputs_.line != nullptr) inputs_.line->begin(bus);
  lock_.begin(bus.now() + interval_);
  look_at_ = lock_.next();
}

SyncFollower::Passed SyncFollower::pass(can::Time now) noexcept {
  Passed passed;
  if (lock_.next() > now) return passed;
  // All but the last at once, however long the thread stood still.
  if (const auto behind = (now - lock_.next()) / interval_; behind > 1) {
    passed.count += static_cast<std::uint64_t>(behind) - 1;
    lock_.advance(static_cast<std::uint64_t>(behind) - 1);
  }
  while (lock_.next() <= now) {
    passed.edge = lock_.next();
    ++passed.count;
    lock_.advance();
  }
  look_at_ = passed.edge + interval_ / kLookPart;
  return passed;
}

void SyncFollower::look(can::Time now) noexcept {
  if (now < look_at_) return;
  const bool expected = every_interval_ && tracking();
  take_edges();
  const std::uint64_t accepted = lock_.counters().accepted;
  if (expected && accepted == accepted_) ++missing_edges_;
  accepted_ = accepted;
  look_at_ = std::max(next(), now) + interval_ / kLookPart;
}

void SyncFollower::take_edges() noexcept {
  if (inputs_.line != nullptr) inputs_.line->follow(lock_);
  can::Time at{};
  for (unsigned i = 0; inputs_.wire != nullptr && i < kWireEdgesAtOnce && inputs_.wire->take(next(), at);
       ++i) {
    lock_.input(at);
  }
}

bool SyncFollower::take_frame(const can::ReceivedFrame& received) noexcept {
  return inputs_.line != nullptr && inputs_.line->take_frame(received, &lock_);
}

int SyncFollower::input_error() const noexcept {
  if (inputs_.line != nullptr) return inputs_.line->input_error();
  return inputs_.wire != nullptr ? inputs_.wire->error() : 0;
}

SyncSnapshot SyncFollower::snapshot() const noexcept {
  SyncSnapshot snapshot;
  snapshot.state = lock_.state();
  snapshot.phase_error = lock_.phase_error();
  snapshot.holdover = lock_.holdover();
  snapshot.edges = lock_.counters().accepted;
  snapshot.rejected_edges = lock_.counters().rejected;
  return snapshot;
}

}  // namespace cansyncd
