#include "daemon/desk/access.h"

#include <variant>

namespace cansyncd {
namespace {

struct Effect {
  Right right = Right::engineer;
  bool changes = true;
};

/// One function for each kind: a kind that is new does not compile until somebody has decided.
struct EffectOf {
  Effect operator()(const cansync::ParameterRequest& r) const noexcept { return {Right::engineer, r.write}; }
  Effect operator()(const cansync::TransferRequest& r) const noexcept {
    return {Right::engineer, r.direction == cansync::TransferRequest::Direction::download};
  }
  Effect operator()(const cansync::ControlWordRequest& /*r*/) const noexcept {
    return {Right::operate, true};
  }
  Effect operator()(const cansync::BroadcastRequest& /*r*/) const noexcept { return {Right::operate, true}; }
  Effect operator()(const cansync::ReferenceUpdate& /*r*/) const noexcept { return {Right::operate, true}; }
  Effect operator()(const Cancel& /*r*/) const noexcept { return {Right::operate, false}; }
  Effect operator()(const StopRelease& /*r*/) const noexcept { return {Right::operate, false}; }
  Effect operator()(const ModeRequest& /*r*/) const noexcept { return {Right::engineer, true}; }
  Effect operator()(const SetPolling& /*r*/) const noexcept { return {Right::engineer, true}; }
  Effect operator()(const SetCursors& /*r*/) const noexcept { return {Right::engineer, true}; }
  Effect operator()(const SetReferenceMapping& /*r*/) const noexcept { return {Right::engineer, true}; }
  Effect operator()(const SetActualMapping& /*r*/) const noexcept { return {Right::engineer, true}; }
  Effect operator()(const ReleaseSlave& /*r*/) const noexcept { return {Right::engineer, true}; }
};

constexpr const char* kReadOnly =
    "access.read_only: this daemon only looks on; it takes no request that would change a drive or the line, "
    "reads and uploads are allowed; set it to false in the configuration and reload the daemon (SIGHUP)";

}  // namespace

Right needed_right(const Request& request) {
  return std::visit(EffectOf{}, request).right;
}

bool changes_something(const Request& request) {
  return std::visit(EffectOf{}, request).changes;
}

std::optional<std::string> right_refusal(const Request& request, Right right) {
  if (needed_right(request) <= right) return std::nullopt;
  return "kind: with DDS Security on topic Command takes control words and broadcasts alone; modes, polling, "
         "cursors and mappings go over topic EngineerCommand, which the role engineer may write";
}

std::optional<std::string> read_only_refusal(const Request& request, const Config& config) {
  if (!config.access.read_only || !changes_something(request)) return std::nullopt;
  return kReadOnly;
}

std::optional<std::string> read_only_refusal_of_references(const Config& config) {
  return read_only_refusal(cansync::ReferenceUpdate{}, config);
}

}  // namespace cansyncd
