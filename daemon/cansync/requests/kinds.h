#pragma once

#include <optional>
#include <string>

#include "cansync/config/config.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/requests/audit_memory.h"
#include "daemon/cansync/requests/lanes.h"
#include "daemon/desk/access.h"
#include "daemon/desk/audit.h"

/// What the desk has to know of each kind of request, a row for each. Not for the realtime thread.
namespace cansyncd {

/// What most kinds have in common; a row hides what is different with it.
template <class Kind, Right kRight, bool kChanges>
struct CommonRow {
  /// The right it needs, and whether it would change a drive, the line or the master.
  static Effect effect(const Kind& /*request*/) noexcept { return {kRight, kChanges}; }
  /// The queue of the master it waits in.
  static Lane lane(const Kind& /*request*/) noexcept { return {LaneKind::line, 0}; }
  /// In words, for the journal; nothing when it is not worth a line there.
  static std::optional<std::string> text(const Kind& /*request*/, const Config& /*config*/) {
    return std::nullopt;
  }
  /// The value it would replace. `state`: the master's, when it was taken.
  static std::string before(const Kind& /*request*/, const AuditMemory& /*memory*/,
                            cansync::State /*state*/) {
    return AuditTrail::kNotKnown;
  }
  /// Keeps what it has set, once it is done.
  static void done(const Kind& /*request*/, AuditMemory& /*memory*/) {}
  /// Forgets what it may have changed: it ended, and whether it was done is not known.
  static void perhaps_done(const Kind& /*request*/, AuditMemory& /*memory*/) {}
};

/// No default: a kind that is new does not compile until it has its row.
template <class Kind>
struct KindRow;

// --- jobs of the command channel. Values of parameters come with their result; what a download replaced is
// not known.

template <>
struct KindRow<cansync::ParameterRequest> : CommonRow<cansync::ParameterRequest, Right::engineer, true> {
  static Effect effect(const cansync::ParameterRequest& r) noexcept { return {Right::engineer, r.write}; }
  static Lane lane(const cansync::ParameterRequest& r) noexcept {
    return {LaneKind::parameter, r.slave.value()};
  }
  static std::optional<std::string> text(const cansync::ParameterRequest& r, const Config& config);
  static std::string before(const cansync::ParameterRequest& r, const AuditMemory& memory, cansync::State);
};

template <>
struct KindRow<cansync::TransferRequest> : CommonRow<cansync::TransferRequest, Right::engineer, true> {
  static Effect effect(const cansync::TransferRequest& r) noexcept {
    return {Right::engineer, r.direction == cansync::TransferRequest::Direction::download};
  }
  static Lane lane(const cansync::TransferRequest& r) noexcept {
    return {LaneKind::transfer, r.slave.value()};
  }
  static std::optional<std::string> text(const cansync::TransferRequest& r, const Config& config);
};

template <>
struct KindRow<cansync::ControlWordRequest> : CommonRow<cansync::ControlWordRequest, Right::operate, true> {
  static Lane lane(const cansync::ControlWordRequest& r) noexcept {
    return {LaneKind::control_word, r.slave.value()};
  }
  static std::optional<std::string> text(const cansync::ControlWordRequest& r, const Config& config);
  static std::string before(const cansync::ControlWordRequest& r, const AuditMemory& memory, cansync::State);
  static void done(const cansync::ControlWordRequest& r, AuditMemory& memory);
  static void perhaps_done(const cansync::ControlWordRequest& r, AuditMemory& memory);
};

template <>
struct KindRow<cansync::BroadcastRequest> : CommonRow<cansync::BroadcastRequest, Right::operate, true> {
  static Lane lane(const cansync::BroadcastRequest& r) noexcept { return {LaneKind::broadcast, r.priority}; }
  static std::optional<std::string> text(const cansync::BroadcastRequest& r, const Config& config);
  static void done(const cansync::BroadcastRequest& r, AuditMemory& memory);
  static void perhaps_done(const cansync::BroadcastRequest& r, AuditMemory& memory);
};

// --- what takes effect at once

template <>
struct KindRow<ModeRequest> : CommonRow<ModeRequest, Right::engineer, true> {
  static std::optional<std::string> text(const ModeRequest& r, const Config& config);
  static std::string before(const ModeRequest& r, const AuditMemory& memory, cansync::State state);
};

template <>
struct KindRow<SetPolling> : CommonRow<SetPolling, Right::engineer, true> {
  static std::optional<std::string> text(const SetPolling& r, const Config& config);
  static std::string before(const SetPolling& r, const AuditMemory& memory, cansync::State);
  static void done(const SetPolling& r, AuditMemory& memory);
};

template <>
struct KindRow<SetCursors> : CommonRow<SetCursors, Right::engineer, true> {
  static std::optional<std::string> text(const SetCursors& r, const Config& config);
  static std::string before(const SetCursors& r, const AuditMemory& memory, cansync::State);
  static void done(const SetCursors& r, AuditMemory& memory);
};

template <>
struct KindRow<SetReferenceMapping> : CommonRow<SetReferenceMapping, Right::engineer, true> {
  static std::optional<std::string> text(const SetReferenceMapping& r, const Config& config);
  static std::string before(const SetReferenceMapping& r, const AuditMemory& memory, cansync::State);
  static void done(const SetReferenceMapping& r, AuditMemory& memory);
};

template <>
struct KindRow<SetActualMapping> : CommonRow<SetActualMapping, Right::engineer, true> {
  static std::optional<std::string> text(const SetActualMapping& r, const Config& config);
  static std::string before(const SetActualMapping& r, const AuditMemory& memory, cansync::State);
  static void done(const SetActualMapping& r, AuditMemory& memory);
};

template <>
struct KindRow<SetReferenceLimits> : CommonRow<SetReferenceLimits, Right::engineer, true> {
  static std::optional<std::string> text(const SetReferenceLimits& r, const Config& config);
  static std::string before(const SetReferenceLimits& r, const AuditMemory& memory, cansync::State);
  static void done(const SetReferenceLimits& r, AuditMemory& memory);
};

template <>
struct KindRow<ReleaseSlave> : CommonRow<ReleaseSlave, Right::engineer, true> {
  static std::optional<std::string> text(const ReleaseSlave& r, const Config& config);
};

// --- no jobs: the gateway's own, and what clients give over other topics

template <>
struct KindRow<cansync::ReferenceUpdate> : CommonRow<cansync::ReferenceUpdate, Right::operate, true> {};
template <>
struct KindRow<Cancel> : CommonRow<Cancel, Right::operate, false> {};
template <>
struct KindRow<StopRelease> : CommonRow<StopRelease, Right::operate, false> {};

/// Calls `use(row, request)` with the row of the kind that `request` has.
template <class Use>
auto with_row(const Request& request, Use&& use) {
  return std::visit([&]<class Kind>(const Kind& kind) { return use(KindRow<Kind>{}, kind); }, request);
}

}  // namespace cansyncd
