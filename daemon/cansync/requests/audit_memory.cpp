#include "daemon/cansync/requests/audit_memory.h"

#include <algorithm>

#include "cansync/channel/outcome_rules.h"

namespace cansyncd {

AuditMemory::AuditMemory(const Config& config) : settings_(cansync::in_force(config.master)) {}

AuditMemory::Key AuditMemory::key_of(const cansync::ParameterRequest& request) noexcept {
  return {request.slave.value(), request.sub_slave.value, request.number.value()};
}

std::optional<std::uint32_t> AuditMemory::parameter(const cansync::ParameterRequest& request) const {
  const auto found = parameters_.find(key_of(request));
  return found == parameters_.end() ? std::nullopt : std::optional(found->second);
}

void AuditMemory::learn(const cansync::ParameterRequest& request, const cansync::ParameterResult& result) {
  constexpr std::uint8_t kValueElement = 7;
  if (request.element.value() != kValueElement) return;
  const Key key = key_of(request);
  if (result.outcome == cansync::Outcome::done) {
    remember(key, result.value);
  } else if (request.write && cansync::perhaps_written(result)) {
    // The slave may have the old value or the new one.
    if (parameters_.erase(key) != 0) order_.erase(std::find(order_.begin(), order_.end(), key));
  }
}

void AuditMemory::remember(const Key& key, std::uint32_t value) {
  const auto [entry, is_new] = parameters_.insert_or_assign(key, value);
  if (!is_new) return;
  if (order_.size() == kParameters) {
    parameters_.erase(order_.front());
    order_.pop_front();
  }
  order_.push_back(key);
}

}  // namespace cansyncd
