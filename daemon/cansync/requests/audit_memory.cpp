#include "daemon/cansync/requests/audit_memory.h"

#include <fmt/format.h>

#include <algorithm>
#include <variant>

#include "daemon/cansync/requests/audit_text.h"
#include "daemon/cansync/requests/gateway_requests.h"

namespace cansyncd {
namespace {

constexpr std::uint8_t kValueElement = 7;
constexpr std::uint8_t kControlWordAction = 1;

}  // namespace

/// One function for each kind: a kind that is new does not compile until somebody has decided.
struct AuditMemory::Before {
  const AuditMemory& memory;
  cansync::State state;

  std::string operator()(const cansync::ParameterRequest& r) const {
    const auto found = memory.parameters_.find({r.slave.value(), r.sub_slave.value, r.number.value()});
    return found == memory.parameters_.end() ? kNotKnown : std::to_string(found->second);
  }
  std::string operator()(const cansync::TransferRequest& /*r*/) const { return kNotKnown; }
  std::string operator()(const cansync::ControlWordRequest& r) const {
    const auto& word = memory.control_words_[r.slave.value()];
    return word ? fmt::format("0x{:04X}", *word) : kNotKnown;
  }
  std::string operator()(const cansync::BroadcastRequest& /*r*/) const { return kNotKnown; }
  std::string operator()(const ModeRequest& /*r*/) const { return std::string(cansync::name(state)); }
  std::string operator()(const SetPolling& /*r*/) const {
    const auto& now = memory.settings_;
    return polling_text(cursor_text(now.polling[0]), cursor_text(now.polling[1]),
                        std::to_string(now.maximum_slave.value()));
  }
  std::string operator()(const SetCursors& /*r*/) const {
    const auto& now = memory.settings_;
    return cursors_text(cursor_text(now.control_word), cursor_text(now.parameter), cursor_text(now.transfer));
  }
  std::string operator()(const SetReferenceMapping& /*r*/) const {
    return mapping_text(memory.settings_.reference_mapping);
  }
  std::string operator()(const SetActualMapping& r) const {
    return mapping_text(memory.settings_.actual_mapping[r.slave.value()]);
  }
  std::string operator()(const ReleaseSlave& /*r*/) const { return kNotKnown; }
  // No jobs: nobody asks.
  std::string operator()(const cansync::ReferenceUpdate& /*r*/) const { return kNotKnown; }
  std::string operator()(const Cancel& /*r*/) const { return kNotKnown; }
  std::string operator()(const StopRelease& /*r*/) const { return kNotKnown; }
};

struct AuditMemory::Done {
  AuditMemory& memory;

  void operator()(const cansync::ControlWordRequest& r) const {
    memory.control_words_[r.slave.value()] = r.control_word;
  }
  void operator()(const cansync::BroadcastRequest& r) const {
    if (r.action.command != kControlWordAction) return;
    for (std::uint8_t i = 0; i < cansync::kSlaves; ++i) {
      if (r.action.slaves.has(*cansync::SlaveNumber::from(i))) memory.control_words_[i] = r.action.data_word;
    }
  }
  void operator()(const SetPolling& r) const {
    for (unsigned i = 0; i < cansync::kChannels; ++i) {
      if (r.polling[i]) memory.settings_.polling[i] = *r.polling[i];
    }
    if (r.maximum_slave) memory.settings_.maximum_slave = *r.maximum_slave;
  }
  void operator()(const SetCursors& r) const {
    auto& now = memory.settings_;
    now.control_word = r.control_word.value_or(now.control_word);
    now.parameter = r.parameter.value_or(now.parameter);
    now.transfer = r.transfer.value_or(now.transfer);
  }
  void operator()(const SetReferenceMapping& r) const { memory.settings_.reference_mapping = r.mapping; }
  void operator()(const SetActualMapping& r) const {
    memory.settings_.actual_mapping[r.slave.value()] = r.mapping;
  }
  // Parameters come with their result (`learn`); what a download replaced is not known.
  void operator()(const cansync::ParameterRequest& /*r*/) const {}
  void operator()(const cansync::TransferRequest& /*r*/) const {}
  void operator()(const ModeRequest& /*r*/) const {}
  void operator()(const ReleaseSlave& /*r*/) const {}
  void operator()(const cansync::ReferenceUpdate& /*r*/) const {}
  void operator()(const Cancel& /*r*/) const {}
  void operator()(const StopRelease& /*r*/) const {}
};

AuditMemory::AuditMemory(const Config& config) : settings_(cansync::in_force(config.master)) {}

std::string AuditMemory::before(const Request& request, cansync::State state) const {
  return std::visit(Before{*this, state}, request);
}

void AuditMemory::done(const Request& request) {
  std::visit(Done{*this}, request);
}

void AuditMemory::learn(const cansync::ParameterRequest& request, const cansync::ParameterResult& result) {
  if (request.element.value() != kValueElement) return;
  const Key key{request.slave.value(), request.sub_slave.value, request.number.value()};
  if (result.outcome == cansync::Outcome::done) {
    remember(key, result.value);
  } else if (request.write && result.outcome == cansync::Outcome::no_answer) {
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
