#include "daemon/desk/writer_arbiter.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "text/counts.h"

namespace cansyncd {

WriterArbiter::Claim WriterArbiter::claim(WriterHandle writer, std::int32_t strength) const noexcept {
  if (owner_.handle == 0) return Claim::begins;
  if (owner_.handle == writer) return Claim::keeps;
  return strength > owner_.identity.strength ? Claim::takes_over : Claim::waits;
}

void WriterArbiter::give(TopicWriter writer) {
  forget(writer.handle);
  owner_ = std::move(writer);
}

std::string WriterArbiter::refuse(const TopicWriter& writer) {
  ++refused_;
  if (reason_of_ != owner_.handle || reason_.empty()) {
    reason_of_ = owner_.handle;
    reason_ = fmt::format("{} has {} with strength {}; only a stronger writer takes over",
                          owner_.identity.who, what_, owner_.identity.strength);
  }
  const auto known = std::find_if(waiting_.begin(), waiting_.end(),
                                  [&](const TopicWriter& one) { return one.handle == writer.handle; });
  if (known != waiting_.end()) return {};
  if (waiting_.size() == kMostWaiting) {
    if (std::exchange(more_wait_, true)) return {};
    return fmt::format("more than {} for {}; the others are not named",
                       text::counted(kMostWaiting, "writer waits", "writers wait"), what_);
  }
  waiting_.push_back(writer);
  return fmt::format(
      "{} (strength {}) waits for {}, which {} (strength {}) has: nothing of it is taken until the owner has "
      "gone; only a stronger writer takes over",
      writer.identity.who, writer.identity.strength, what_, owner_.identity.who, owner_.identity.strength);
}

void WriterArbiter::forget(WriterHandle writer) {
  forget_if([&](WriterHandle one) { return one == writer; });
}

void WriterArbiter::forget_key(const WriterKey& key) {
  std::erase_if(waiting_, [&](const TopicWriter& one) { return one.key == key; });
  more_wait_ = more_wait_ && waiting_.size() == kMostWaiting;
}

void WriterArbiter::forget_if(const std::function<bool(WriterHandle)>& gone) {
  std::erase_if(waiting_, [&](const TopicWriter& one) { return gone(one.handle); });
  more_wait_ = more_wait_ && waiting_.size() == kMostWaiting;
}

std::string_view WriterArbiter::waiting() const noexcept {
  return waiting_.empty() ? std::string_view() : std::string_view(waiting_.front().identity.who);
}

}  // namespace cansyncd
