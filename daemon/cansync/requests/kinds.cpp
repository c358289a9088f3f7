#include "daemon/cansync/requests/kinds.h"

#include <fmt/format.h>

#include <string_view>

#include "daemon/cansync/requests/audit_text.h"
#include "daemon/cansync/requests/gateway_requests.h"
#include "daemon/cansync/texts/limit_text.h"
#include "daemon/cansync/texts/profile_rules.h"
#include "daemon/cansync/texts/refusal_text.h"
#include "text/counts.h"

namespace cansyncd {
namespace {

using Text = std::optional<std::string>;

std::string_view name(Mode mode) noexcept {
  switch (mode) {
    case Mode::set_up:
      return "setup";
    case Mode::run:
      return "run";
    case Mode::stop:
      return "stop";
    case Mode::reset_can:
      return "reset-can";
    case Mode::restart:
      return "restart";
  }
  return "unknown";
}

std::string cursor_or_unchanged(const std::optional<cansync::Cursor>& cursor) {
  return cursor ? cursor_text(*cursor) : "unchanged";
}

}  // namespace

Text KindRow<cansync::ParameterRequest>::text(const cansync::ParameterRequest& r, const Config& config) {
  if (!r.write) return std::nullopt;
  const bool own = r.sub_slave.value == 0;
  return fmt::format("write {} sub-slave {} {} = {} (0x{:X})", slave_label(config, r.slave.value()),
                     r.sub_slave.value,
                     own ? parameter_label(config, r.slave.value(), r.number.value())
                         : fmt::format("parameter {}", r.number.value()),
                     r.value, r.value);
}

std::string KindRow<cansync::ParameterRequest>::before(const cansync::ParameterRequest& r,
                                                       const AuditMemory& memory, cansync::State /*state*/) {
  const auto value = memory.parameter(r);
  return value ? std::to_string(*value) : AuditTrail::kNotKnown;
}

Text KindRow<cansync::TransferRequest>::text(const cansync::TransferRequest& r, const Config& config) {
  if (r.direction == cansync::TransferRequest::Direction::upload) return std::nullopt;
  return fmt::format("download {} to {} sub-slave {} address 0x{:X}", text::counted(r.data.size(), "byte"),
                     slave_label(config, r.slave.value()), r.sub_slave.value, r.address);
}

Text KindRow<cansync::ControlWordRequest>::text(const cansync::ControlWordRequest& r, const Config& config) {
  return fmt::format("control word 0x{:04X} to {}", r.control_word, slave_label(config, r.slave.value()));
}

std::string KindRow<cansync::ControlWordRequest>::before(const cansync::ControlWordRequest& r,
                                                         const AuditMemory& memory,
                                                         cansync::State /*state*/) {
  const auto word = memory.control_word(r.slave);
  return word ? fmt::format("0x{:04X}", *word) : AuditTrail::kNotKnown;
}

void KindRow<cansync::ControlWordRequest>::done(const cansync::ControlWordRequest& r, AuditMemory& memory) {
  memory.set_control_word(r.slave, r.control_word);
}

void KindRow<cansync::ControlWordRequest>::perhaps_done(const cansync::ControlWordRequest& r,
                                                        AuditMemory& memory) {
  memory.forget_control_word(r.slave);
}

Text KindRow<cansync::BroadcastRequest>::text(const cansync::BroadcastRequest& r, const Config& /*config*/) {
  return fmt::format("broadcast {} to slaves 0x{:08X}: command {}, data 0x{:02X} 0x{:04X}", r.priority,
                     r.action.slaves.bits, r.action.command, r.action.data_byte, r.action.data_word);
}

void KindRow<cansync::BroadcastRequest>::done(const cansync::BroadcastRequest& r, AuditMemory& memory) {
  if (r.action.command != cansync::kCommandControlWord) return;
  for (const cansync::SlaveNumber slave : r.action.slaves) memory.set_control_word(slave, r.action.data_word);
}

void KindRow<cansync::BroadcastRequest>::perhaps_done(const cansync::BroadcastRequest& r,
                                                      AuditMemory& memory) {
  if (r.action.command != cansync::kCommandControlWord) return;
  for (const cansync::SlaveNumber slave : r.action.slaves) memory.forget_control_word(slave);
}

Text KindRow<ModeRequest>::text(const ModeRequest& r, const Config& /*config*/) {
  return fmt::format("mode {}{}", name(r.mode), r.force ? " with force" : "");
}

std::string KindRow<ModeRequest>::before(const ModeRequest& /*r*/, const AuditMemory& /*memory*/,
                                         cansync::State state) {
  return std::string(cansync::name(state));
}

Text KindRow<SetPolling>::text(const SetPolling& r, const Config& /*config*/) {
  return "polling " + polling_text(cursor_or_unchanged(r.polling[0]), cursor_or_unchanged(r.polling[1]),
                                   r.maximum_slave ? std::to_string(r.maximum_slave->value()) : "unchanged");
}

std::string KindRow<SetPolling>::before(const SetPolling& /*r*/, const AuditMemory& memory,
                                        cansync::State /*state*/) {
  const cansync::SettingsInForce& now = memory.settings();
  return polling_text(cursor_text(now.polling[0]), cursor_text(now.polling[1]),
                      std::to_string(now.maximum_slave.value()));
}

void KindRow<SetPolling>::done(const SetPolling& r, AuditMemory& memory) {
  cansync::SettingsInForce& now = memory.settings();
  for (unsigned i = 0; i < cansync::kChannels; ++i) now.polling[i] = r.polling[i].value_or(now.polling[i]);
  now.maximum_slave = r.maximum_slave.value_or(now.maximum_slave);
}

Text KindRow<SetCursors>::text(const SetCursors& r, const Config& /*config*/) {
  return "cursors " + cursors_text(cursor_or_unchanged(r.control_word), cursor_or_unchanged(r.parameter),
                                   cursor_or_unchanged(r.transfer));
}

std::string KindRow<SetCursors>::before(const SetCursors& /*r*/, const AuditMemory& memory,
                                        cansync::State /*state*/) {
  const cansync::SettingsInForce& now = memory.settings();
  return cursors_text(cursor_text(now.control_word), cursor_text(now.parameter), cursor_text(now.transfer));
}

void KindRow<SetCursors>::done(const SetCursors& r, AuditMemory& memory) {
  cansync::SettingsInForce& now = memory.settings();
  now.control_word = r.control_word.value_or(now.control_word);
  now.parameter = r.parameter.value_or(now.parameter);
  now.transfer = r.transfer.value_or(now.transfer);
}

Text KindRow<SetReferenceMapping>::text(const SetReferenceMapping& r, const Config& /*config*/) {
  return fmt::format("mapping of the reference values {}", mapping_text(r.mapping));
}

std::string KindRow<SetReferenceMapping>::before(const SetReferenceMapping& /*r*/, const AuditMemory& memory,
                                                 cansync::State /*state*/) {
  return mapping_text(memory.settings().reference_mapping);
}

void KindRow<SetReferenceMapping>::done(const SetReferenceMapping& r, AuditMemory& memory) {
  memory.settings().reference_mapping = r.mapping;
}

Text KindRow<SetActualMapping>::text(const SetActualMapping& r, const Config& config) {
  return fmt::format("mapping of the actual values of {} {}", slave_label(config, r.slave.value()),
                     mapping_text(r.mapping));
}

std::string KindRow<SetActualMapping>::before(const SetActualMapping& r, const AuditMemory& memory,
                                              cansync::State /*state*/) {
  return mapping_text(memory.settings().actual_mapping[r.slave.value()]);
}

void KindRow<SetActualMapping>::done(const SetActualMapping& r, AuditMemory& memory) {
  memory.settings().actual_mapping[r.slave.value()] = r.mapping;
}

Text KindRow<SetReferenceLimits>::text(const SetReferenceLimits& r, const Config& /*config*/) {
  return fmt::format("limits of reference value {}: {}", r.value, limits_text(r.limits));
}

std::string KindRow<SetReferenceLimits>::before(const SetReferenceLimits& r, const AuditMemory& memory,
                                                cansync::State /*state*/) {
  return limits_text(memory.settings().reference_limits[r.value]);
}

void KindRow<SetReferenceLimits>::done(const SetReferenceLimits& r, AuditMemory& memory) {
  memory.settings().reference_limits[r.value] = r.limits;
}

Text KindRow<ReleaseSlave>::text(const ReleaseSlave& r, const Config& config) {
  return fmt::format("release of {}{}", slave_label(config, r.slave.value()), r.force ? " with force" : "");
}

}  // namespace cansyncd
