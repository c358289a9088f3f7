#include "daemon/desk/job_book.h"

#include <fmt/format.h>

#include <algorithm>

#include "daemon/desk/limits_text.h"
#include "daemon/desk/rejections.h"
#include "text/visible.h"

namespace cansyncd {

using gateway::dds::RequestKey;

Requester who_of(std::string_view name, const RequestKey& key, const Place& place) {
  Requester who;
  // A program calls itself what it likes; whoever is told of it must not obey it.
  who.name = text::visible(name);
  who.request = key.request;
  const auto& client = key.client;
  who.label =
      fmt::format("'{}' ({:02x}{:02x}{:02x}{:02x})", who.name, client[0], client[1], client[2], client[3]);
  if (place != Place{}) {
    for (const unsigned byte : place) who.participant += fmt::format("{:02x}", byte);
  }
  return who;
}

JobId JobBook::first_id(const gateway::dds::DaemonIdentity& daemon) noexcept {
  constexpr std::size_t kBytes = 5;
  JobId id = 1;
  for (std::size_t i = 0; i < kBytes; ++i) id = id << 8 | daemon[i];
  return id;
}

JobBook::Admission JobBook::admit(const RequestKey& key,
                                  const std::pair<ClientEntry*, ClientTable::Admission>& entered,
                                  std::int64_t written, std::int64_t now, std::chrono::milliseconds max_age) {
  const auto [client, admission] = entered;
  const auto refused = [](gateway_RefusalCause cause, std::string reason) {
    return Admission{nullptr, {cause, std::move(reason)}};
  };
  if (admission == ClientTable::Admission::leaving) {
    return refused(
        gateway_CAUSE_IDENTITY,
        "client: the program that had this identity is gone, and its requests are not all cancelled yet; "
        "choose an identity at random at every start");
  }
  if (admission == ClientTable::Admission::full) {
    return {nullptr, too_many_clients(clients_.size(), ClientTable::kClients), true};
  }
  const std::uint64_t number = key.request;
  if (!client->numbers.use(number)) {
    if (find(key)) {
      return refused(gateway_CAUSE_NUMBER_USED,
                     fmt::format("request {}: this number is open already and is answered by itself; every "
                                 "request needs a number of its own, rising by one",
                                 number));
    }
    return refused(
        gateway_CAUSE_NUMBER_USED,
        fmt::format("request {}: this number was used already, or is too far behind the highest, {}; every "
                    "request needs a number of its own, rising by one",
                    number, client->numbers.highest()));
  }
  if (auto problem = stale(written, now, max_age)) return {nullptr, *std::move(problem)};
  return {client};
}

gateway::dds::Problem JobBook::no_room(const ClientEntry& client, std::size_t bytes) const {
  if (client.open >= kPerClient) return too_many_requests(client.open, kPerClient);
  if (client.transfer_bytes + bytes > kClientTransferMemory)
    return too_many_bytes_of_client(bytes, client.transfer_bytes, kClientTransferMemory);
  if (bytes_ + bytes > kTransferMemory) return too_many_bytes(bytes, bytes_, kTransferMemory);
  return std::nullopt;
}

void JobBook::open(const RequestKey& key, JobId id, std::size_t bytes) {
  if (ClientEntry* client = clients_.find(key.client)) {
    ++client->open;
    client->transfer_bytes += bytes;
  }
  bytes_ += bytes;
  open_.emplace(Key{key.client, key.request}, id);
}

void JobBook::let_go(const RequestKey& key, std::size_t bytes) {
  bytes_ -= bytes;
  if (ClientEntry* client = clients_.find(key.client)) client->transfer_bytes -= bytes;
}

bool JobBook::close(const RequestKey& key, std::size_t bytes) {
  let_go(key, bytes);
  open_.erase({key.client, key.request});
  ClientEntry* client = clients_.find(key.client);
  return client != nullptr && --client->open == 0 && client->gone;
}

void JobBook::close_all() {
  open_.clear();
  bytes_ = 0;
}

std::optional<JobId> JobBook::find(const RequestKey& key) const {
  const auto found = open_.find({key.client, key.request});
  return found == open_.end() ? std::nullopt : std::optional(found->second);
}

void JobBook::remember_cancel(ClientEntry& client, std::uint64_t request, SteadyTime now) {
  auto& early = client.early_cancels;
  if (early.size() == kEarlyCancels) early.pop_front();
  early.emplace_back(request, now);
}

bool JobBook::take_early_cancel(ClientEntry& client, std::uint64_t request, SteadyTime now) {
  auto& early = client.early_cancels;
  while (!early.empty() && now - early.front().second > kEarlyCancel) early.pop_front();
  const auto found =
      std::find_if(early.begin(), early.end(), [&](const auto& item) { return item.first == request; });
  if (found == early.end()) return false;
  early.erase(found);
  return true;
}

}  // namespace cansyncd
