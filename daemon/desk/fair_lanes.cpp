#include "daemon/desk/fair_lanes.h"

#include <algorithm>
#include <limits>

namespace cansyncd {
namespace {

constexpr unsigned index_of(LaneKind kind) noexcept {
  return static_cast<unsigned>(kind);
}

}  // namespace

LaneLimits lane_limits(const cansync::CommandChannelSettings& settings) noexcept {
  // A parameter takes at least one interval: four last until this thread has given the next.
  constexpr unsigned kAhead = 4;
  constexpr unsigned kAny = std::numeric_limits<unsigned>::max();
  const auto at_most = [](unsigned wanted, unsigned queue) { return std::clamp(queue, 1u, wanted); };
  LaneLimits limits;
  limits.in_lane[index_of(LaneKind::parameter)] = kAhead;
  // A transfer is long: the next is begun when it has ended.
  limits.in_lane[index_of(LaneKind::transfer)] = 1;
  limits.in_lane[index_of(LaneKind::control_word)] = at_most(kAhead, settings.control_word_queue);
  limits.in_lane[index_of(LaneKind::broadcast)] = at_most(kAhead, settings.broadcast_queue);
  limits.in_lane[index_of(LaneKind::line)] = kAhead;
  limits.together.fill(kAny);
  limits.together[index_of(LaneKind::parameter)] = at_most(kAny, settings.parameter_queue);
  limits.together[index_of(LaneKind::transfer)] = at_most(kAny, settings.transfer_queue);
  return limits;
}

void FairLanes::add(cansync::JobId id, const ClientIdentity& client, Lane lane) {
  Queue& queue = lanes_[lane];
  auto& own = queue.waiting[client];
  if (own.empty()) queue.turns.push_back(client);
  own.push_back(id);
  jobs_[id] = {lane, client, false};
}

void FairLanes::remove(cansync::JobId id) {
  const auto found = jobs_.find(id);
  if (found == jobs_.end()) return;
  const Where where = found->second;
  jobs_.erase(found);
  const auto lane = lanes_.find(where.lane);
  if (where.given) {
    --lane->second.given;
    --together_[index_of(where.lane.kind)];
  } else {
    drop_waiting(lane->second, where.client, id);
  }
  if (lane->second.given == 0 && lane->second.turns.empty()) lanes_.erase(lane);
}

bool FairLanes::waits(cansync::JobId id) const {
  const auto found = jobs_.find(id);
  return found != jobs_.end() && !found->second.given;
}

std::optional<Lane> FairLanes::next_lane() const {
  const auto may_give = [this](const auto& entry) {
    const unsigned kind = index_of(entry.first.kind);
    return !entry.second.turns.empty() && entry.second.given < limits_.in_lane[kind] &&
           together_[kind] < limits_.together[kind];
  };
  const auto after = lanes_.upper_bound(last_);
  auto found = std::find_if(after, lanes_.end(), may_give);
  if (found == lanes_.end()) {
    found = std::find_if(lanes_.begin(), after, may_give);
    if (found == after) return std::nullopt;
  }
  return found->first;
}

cansync::JobId FairLanes::first_of(Lane lane) const {
  const Queue& queue = lanes_.at(lane);
  return queue.waiting.at(queue.turns.front()).front();
}

void FairLanes::given(Lane lane) {
  Queue& queue = lanes_.at(lane);
  const ClientIdentity client = queue.turns.front();
  const auto own = queue.waiting.find(client);
  jobs_.at(own->second.front()).given = true;
  own->second.pop_front();
  queue.turns.pop_front();
  if (own->second.empty()) {
    queue.waiting.erase(own);
  } else {
    queue.turns.push_back(client);
  }
  ++queue.given;
  ++together_[index_of(lane.kind)];
  last_ = lane;
}

void FairLanes::drop_waiting(Queue& queue, const ClientIdentity& client, cansync::JobId id) {
  const auto own = queue.waiting.find(client);
  std::erase(own->second, id);
  if (!own->second.empty()) return;
  queue.waiting.erase(own);
  std::erase(queue.turns, client);
}

}  // namespace cansyncd
