#include "daemon/cansync_slave/gateway/slave_requests.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <span>
#include <variant>

#include "daemon/desk/job_desk_answers.h"
#include "daemon/desk/job_desk_oversight.h"
#include "daemon/desk/job_desk_requests.h"

namespace cansyncd {

template class JobDesk<SlaveRequests>;

namespace {

using gateway::dds::Denial;

std::string registers_text(const std::uint8_t (&bytes)[8]) {
  return fmt::format("0x{:02X}", fmt::join(std::span(bytes), " 0x"));
}

SlaveMode mode_of(cansync_slave_SlaveMode mode) noexcept {
  switch (mode) {
    case cansync_slave_SLAVE_MODE_SETUP:
      return SlaveMode::setup;
    case cansync_slave_SLAVE_MODE_RUN:
      return SlaveMode::run;
    case cansync_slave_SLAVE_MODE_STOP:
      return SlaveMode::stop;
    case cansync_slave_SLAVE_MODE_RESTART:
      return SlaveMode::restart;
    case cansync_slave_SLAVE_MODE_RESET_CAN:
      break;
  }
  return SlaveMode::reset_can;
}

}  // namespace

SlaveOutcome slave_outcome_of(can::JobKnown known, can::JobEnd end) noexcept {
  switch (can::ending_of(known, end)) {
    case can::JobEnding::cancelled:
      return SlaveOutcome::cancelled;
    case can::JobEnding::stopped:
      return SlaveOutcome::stopped;
    case can::JobEnding::no_answer:
    case can::JobEnding::timeout:
    case can::JobEnding::lost:
    case can::JobEnding::taken:
      break;
  }
  return SlaveOutcome::no_answer;
}

SlaveOutcome slave_outcome_of(const SlaveOrderDone& done) noexcept {
  return done.stopped ? slave_outcome_of(*done.stopped, can::JobEnd::stopped) : SlaveOutcome::done;
}

gateway_ReplyCode reply_code_of(SlaveOutcome outcome) noexcept {
  switch (outcome) {
    case SlaveOutcome::done:
      return gateway_REPLY_DONE;
    case SlaveOutcome::cancelled:
      return gateway_REPLY_CANCELLED;
    case SlaveOutcome::stopped:
      return gateway_REPLY_MASTER_STOPPED;
    case SlaveOutcome::no_answer:
      break;
  }
  return gateway_REPLY_NO_ANSWER;
}

cansync_slave_SlaveCommandReply SlaveCommandTopic::ended(const gateway::dds::RequestKey& key,
                                                         SlaveOutcome outcome) {
  const char* reason = "";
  switch (outcome) {
    case SlaveOutcome::done:
      break;
    case SlaveOutcome::cancelled:
      reason = "cancelled";
      break;
    case SlaveOutcome::stopped:
      reason = "the daemon was stopped before it was done; nothing of it was done";
      break;
    case SlaveOutcome::no_answer:
      reason = "the daemon was stopped while the controller was being reset; whether it was is not known";
      break;
  }
  return cansync_slave::dds::command_reply(key, reply_code_of(outcome), reason);
}

LaneLimits SlaveRequests::lane_limits() {
  constexpr unsigned kOpen = SlaveExchange::kCommands;
  return {{kOpen, kOpen}};
}

std::optional<Change> SlaveRequests::change_of(const cansync_slave_SlaveCommand& sample,
                                               const SlaveContext& /*context*/) {
  static constexpr std::array<const char*, cansync_slave_SLAVE_MODE_RESET_CAN + 1> kModes = {
      "setup", "run", "stop", "restart", "reset_can"};
  Change change;
  switch (sample.kind) {
    case cansync_slave_SLAVE_COMMAND_MAPPING:
      change.action = "slave_mapping";
      change.new_value =
          fmt::format("references {}, actual values {}", registers_text(sample.reference_mapping),
                      registers_text(sample.actual_mapping));
      return change;
    case cansync_slave_SLAVE_COMMAND_LISTEN:
      change.action = "slave_listen";
      change.new_value = fmt::format("slave {}: {}", sample.other, registers_text(sample.actual_mapping));
      return change;
    default:
      break;
  }
  change.action = "slave_mode";
  const auto mode = static_cast<std::size_t>(sample.mode);
  change.new_value = mode < kModes.size() ? kModes[mode] : "unknown";
  return change;
}

std::optional<SlaveOrder> SlaveRequests::request_of(const cansync_slave_SlaveCommand& sample, JobId id,
                                                    std::vector<std::uint8_t>& /*data*/) {
  using cansync_slave::dds::mapping_of;
  switch (sample.kind) {
    case cansync_slave_SLAVE_COMMAND_MODE:
      return SlaveModeOrder{id, mode_of(sample.mode)};
    case cansync_slave_SLAVE_COMMAND_MAPPING:
      return SlaveMappingOrder{id, mapping_of(sample.reference_mapping), mapping_of(sample.actual_mapping)};
    case cansync_slave_SLAVE_COMMAND_LISTEN: {
      SlaveListenOrder order{id, *cansync::SlaveNumber::from(sample.other), std::nullopt};
      const std::span bytes(sample.actual_mapping);
      if (std::any_of(bytes.begin(), bytes.end(), [](std::uint8_t byte) { return byte != 0; }))
        order.mapping = mapping_of(sample.actual_mapping);
      return order;
    }
    default:
      break;
  }
  return std::nullopt;
}

gateway::dds::Problem SlaveRequests::objection(const Request& request, const SlaveContext& context) {
  const auto* listen = std::get_if<SlaveListenOrder>(&request);
  if (listen == nullptr || listen->other != context.config.slave.number) return std::nullopt;
  return Denial{gateway_CAUSE_FIELD,
                fmt::format("other {}: is this slave itself; allowed: the others", listen->other.value())};
}

JobId SlaveRequests::id_of(const SlaveOrderDone& done) noexcept {
  if (const auto* mode = std::get_if<SlaveModeOrder>(&done.order)) return mode->id;
  if (const auto* mapping = std::get_if<SlaveMappingOrder>(&done.order)) return mapping->id;
  const auto* listen = std::get_if<SlaveListenOrder>(&done.order);
  return listen != nullptr ? listen->id : JobId{0};
}

gateway::dds::Problem SlaveRequests::refusal(const SlaveOrderDone& done, const Request& /*request*/,
                                             const SlaveContext& /*context*/) {
  switch (done.refusal) {
    case SlaveRefusal::none:
      return std::nullopt;
    case SlaveRefusal::wrong_state:
      return Denial{gateway_CAUSE_WRONG_STATE,
                    "the mode does not follow from the slave's state; from stop: setup, then run"};
    case SlaveRefusal::of_cluster:
      if (std::holds_alternative<SlaveModeOrder>(done.order))
        return Denial{gateway_CAUSE_WRONG_STATE,
                      "the slave of a cluster runs and stops with its daemon; only reset_can is taken here"};
      return Denial{gateway_CAUSE_WRONG_STATE,
                    "the mappings of a cluster's slave are those of its file; change [upper.slave] or "
                    "[[upper.monitored]] there, and restart the daemon"};
    case SlaveRefusal::not_permitted:
      return Denial{gateway_CAUSE_RIGHT,
                    "the daemon may not reset the controller; give it the right CAP_NET_ADMIN"};
    case SlaveRefusal::no_controller:
      return Denial{
          gateway_CAUSE_BUS_UNAVAILABLE,
          "the controller cannot be reset: its interface is missing or down, or its driver does not do it; set "
          "the interface up, or use its restart-ms"};
    case SlaveRefusal::reset_under_way:
      break;
  }
  return Denial{gateway_CAUSE_QUEUE_FULL,
                "the controller is being reset; ask again when that reset is answered"};
}

std::string_view SlaveRequests::name(Outcome outcome) noexcept {
  switch (outcome) {
    case Outcome::done:
      return "done";
    case Outcome::cancelled:
      return "cancelled";
    case Outcome::stopped:
      return "stopped";
    case Outcome::no_answer:
      break;
  }
  return "no answer";
}

}  // namespace cansyncd
