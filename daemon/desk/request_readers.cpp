#include "daemon/desk/request_readers.h"

#include <fmt/format.h>

#include <cstdint>
#include <vector>

#include "daemon/desk/job_book.h"
#include "dds/malformed.h"
#include "text/counts.h"

namespace cansyncd {

const LivingPlaces& RequestReaders::look(PlaceFinder& places, SteadyTime now) {
  std::vector<dds_entity_t> handles;
  handles.reserve(endpoints_.size());
  for (const gateway::dds::ReaderBase* endpoint : endpoints_) handles.push_back(endpoint->handle());
  if (living_.look(handles, places, now)) {
    for (std::size_t i = 0; i < guards_.size(); ++i) guards_[i]->keep(living_.writers(i));
  }
  return living_;
}

void RequestReaders::count_dropped(Rejections& rejections, EventPublisher& events, SteadyTime now) {
  std::uint64_t elsewhere = 0;
  for (gateway::dds::KeyGuard* guard : guards_) elsewhere += guard->take_elsewhere();
  if (elsewhere != 0) {
    rejections.add(
        Rejection::other_daemon, "",
        fmt::format(
            "{} not taken and not answered: meant for another start of a daemon, which answers them if it "
            "runs",
            text::counted(elsewhere, "request or cancel was", "requests or cancels were")),
        now, elsewhere);
  }
  std::uint64_t keys = 0;
  for (gateway::dds::KeyGuard* guard : guards_) keys += guard->take_dropped();
  if (keys != 0) {
    rejections.add(
        Rejection::identity, "",
        fmt::format("{} dropped unread: one program may use {} client identities at a time, all together {}",
                    text::counted(keys, "sample was", "samples were"), gateway::dds::KeyGuard::kKeysPerWriter,
                    gateway::dds::KeyGuard::kKeys),
        now, keys);
  }
  std::uint64_t forgotten = 0;
  for (gateway::dds::KeyGuard* guard : guards_) forgotten += guard->take_forgotten();
  if (forgotten != 0) {
    rejections.add(
        Rejection::full, "",
        fmt::format(
            "{} dropped without a reply: their program writes on while {} of its requests wait and {} are "
            "being refused",
            text::counted(forgotten, "request was", "requests were"), JobBook::kPerClient,
            gateway::dds::KeyGuard::kTurnedAwayPerKey),
        now, forgotten);
  }
  const gateway::dds::Malformed malformed = gateway::dds::take_malformed();
  for (const std::string& line : malformed.further)
    events.publish({gateway_SEVERITY_WARNING, "dds_message", -1, "DDS says: " + line, std::nullopt}, now);
  if (malformed.count != 0) {
    rejections.add(
        Rejection::malformed, "",
        fmt::format("{} dropped because DDS could not read them (an unknown enumerator, a sequence "
                    "over its bound, another data model?); the newest: {}",
                    text::counted(malformed.count, "sample or packet was", "samples or packets were"),
                    malformed.newest),
        now, malformed.count);
  }
}

}  // namespace cansyncd
