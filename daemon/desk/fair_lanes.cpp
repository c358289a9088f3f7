#include "daemon/desk/fair_lanes.h"

#include <algorithm>

namespace cansyncd {
void FairLanes::add(JobId id, const ClientIdentity& client, Lane lane, unsigned weight) {
  Queue& queue = lanes_[lane];
  auto& own = queue.waiting[client];
  if (own.empty()) queue.turns.push_back(client);
  own.push_back(id);
  jobs_[id] = {lane, client, false, weight};
}

void FairLanes::remove(JobId id) {
  const auto found = jobs_.find(id);
  if (found == jobs_.end()) return;
  const Where where = found->second;
  jobs_.erase(found);
  const auto lane = lanes_.find(where.lane);
  if (where.given) {
    --lane->second.given;
    --together_[where.lane.kind];
    const auto own = lane->second.given_of.find(where.client);
    own->second -= where.weight;
    if (own->second == 0) lane->second.given_of.erase(own);
  } else {
    drop_waiting(lane->second, where.client, id);
  }
  if (lane->second.given == 0 && lane->second.turns.empty()) lanes_.erase(lane);
}

bool FairLanes::waits(JobId id) const {
  const auto found = jobs_.find(id);
  return found != jobs_.end() && !found->second.given;
}

std::vector<LaneTurn> FairLanes::turns(std::span<const JobId> ids) const {
  std::map<Lane, JobId> given;
  // By rising number: the first of a lane is its oldest.
  for (const auto& [id, where] : jobs_) {
    if (where.given) given.emplace(where.lane, id);
  }
  std::vector<LaneTurn> turns(ids.size());
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const auto found = jobs_.find(ids[i]);
    if (found == jobs_.end() || found->second.given) continue;
    const auto before = given.find(found->second.lane);
    turns[i] = {true, before == given.end() ? 0 : before->second};
  }
  return turns;
}

std::optional<Lane> FairLanes::next_lane() const {
  const auto may_give = [this](const auto& entry) {
    const std::uint8_t kind = entry.first.kind;
    return entry.second.given < limits_.at(kind).in_lane && together_[kind] < limits_[kind].together &&
           next_client(entry.first, entry.second) != entry.second.turns.end();
  };
  const auto after = last_ ? lanes_.upper_bound(*last_) : lanes_.begin();
  auto found = std::find_if(after, lanes_.end(), may_give);
  if (found == lanes_.end()) {
    found = std::find_if(lanes_.begin(), after, may_give);
    if (found == after) return std::nullopt;
  }
  return found->first;
}

std::deque<ClientIdentity>::const_iterator FairLanes::next_client(Lane lane, const Queue& queue) const {
  return std::find_if(queue.turns.begin(), queue.turns.end(), [&](const ClientIdentity& client) {
    const auto own = queue.given_of.find(client);
    if (own == queue.given_of.end()) return true;
    const unsigned weight = jobs_.at(queue.waiting.at(client).front()).weight;
    return own->second + weight <= limits_[lane.kind].of_client;
  });
}

JobId FairLanes::first_of(Lane lane) const {
  const Queue& queue = lanes_.at(lane);
  return queue.waiting.at(*next_client(lane, queue)).front();
}

void FairLanes::given(Lane lane) {
  Queue& queue = lanes_.at(lane);
  const auto turn = next_client(lane, queue);
  const ClientIdentity client = *turn;
  const auto own = queue.waiting.find(client);
  Where& where = jobs_.at(own->second.front());
  where.given = true;
  own->second.pop_front();
  queue.turns.erase(turn);
  if (own->second.empty()) {
    queue.waiting.erase(own);
  } else {
    queue.turns.push_back(client);
  }
  ++queue.given;
  queue.given_of[client] += where.weight;
  ++together_[lane.kind];
  last_ = lane;
}

void FairLanes::drop_waiting(Queue& queue, const ClientIdentity& client, JobId id) {
  const auto own = queue.waiting.find(client);
  std::erase(own->second, id);
  if (!own->second.empty()) return;
  queue.waiting.erase(own);
  std::erase(queue.turns, client);
}

}  // namespace cansyncd
