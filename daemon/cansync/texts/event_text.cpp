#include "daemon/cansync/texts/event_text.h"

#include <fmt/format.h>

#include <utility>

#include "daemon/cansync/state_text.h"
#include "daemon/cansync/texts/bus_text.h"
#include "daemon/cansync/texts/profile_rules.h"
#include "daemon/cansync/texts/refusal_text.h"
#include "daemon/cansync/texts/sync_text.h"
#include "text/counts.h"

namespace cansyncd {
namespace {

using Code = cansync::MasterEvent::Code;

gateway_EventSeverity severity_of(Code code) noexcept {
  switch (code) {
    case Code::slave_lost:
    case Code::slave_check_failed:
    case Code::slave_status_refused:
    case Code::wrong_drive:
    case Code::duplicate_slave:
    case Code::second_master:
      return gateway_SEVERITY_ERROR;
    case Code::slave_not_synchronized:
    case Code::references_stopped:
    case Code::references_too_old:
    case Code::references_held:
    case Code::unknown_slave:
      return gateway_SEVERITY_WARNING;
    case Code::slave_responds:
    case Code::slave_returned:
    case Code::slave_checked:
    case Code::slave_identified:
    case Code::slave_released:
    case Code::slave_synchronized:
    case Code::all_synchronized:
    case Code::references_released:
    case Code::second_master_gone:
      break;
  }
  return gateway_SEVERITY_INFO;
}

/// "serial-number (parameter 102), expected 1001 (0x3E9), found 1002 (0x3EA)".
std::string difference_text(const cansync::MasterEvent& event, const Config& config) {
  std::string found = fmt::format("found {} (0x{:X})", event.found, event.found);
  if (event.outcome == cansync::Outcome::slave_error) {
    found = fmt::format("slave error 0x{:04X}", event.found);
  } else if (event.outcome != cansync::Outcome::done) {
    found = cansync::name(event.outcome);
  }
  return fmt::format("{}, expected {} (0x{:X}), {}",
                     parameter_label(config, event.slave->value(), event.detail), event.expected,
                     event.expected, found);
}

std::string check_failed_text(const std::string& who, const cansync::MasterEvent& event,
                              const Config& config) {
  return fmt::format("{} stays held out: {}; set it right, then: cansync release {}", who,
                     difference_text(event, config), event.slave->value());
}

std::string wrong_drive_text(const std::string& who, const cansync::MasterEvent& event,
                             const Config& config) {
  return fmt::format(
      "{} is not the drive expected and is held out: {}; connect the right drive, or correct its expect and reload, then: "
      "cansync release {}",
      who, difference_text(event, config), event.slave->value());
}

std::string duplicate_text(const std::string& who, const cansync::MasterEvent& event, const Config& config) {
  const bool holds = config.master.startup.on_duplicate == cansync::OnDuplicate::hold;
  return fmt::format(
      "two drives answer as {}{}; give each drive a number of its own, then: cansync release {}", who,
      holds ? ", which is held out" : "", event.slave->value());
}

std::string status_refused_text(const std::string& who, const cansync::MasterEvent& event,
                                const Config& config) {
  constexpr const char* kRemedy =
      "set startup.status_parameter, or the slave's status_parameter, to the number in the drive's parameter "
      "list";
  const std::string parameter = parameter_label(config, event.slave->value(), event.detail);
  if (event.outcome == cansync::Outcome::slave_error)
    return fmt::format("{} refuses its status word, {}, with error 0x{:04X}; {}", who, parameter, event.found,
                       kRemedy);
  return fmt::format("{} does not give its status word, {}: it answers {}; {}", who, parameter,
                     event.outcome == cansync::Outcome::timeout ? "busy for 5 s" : "without a value for 5 s",
                     kRemedy);
}

std::string_view other_master_effect(const cansync::MasterEvent& event) noexcept {
  if (event.found == static_cast<std::uint32_t>(cansync::BusAccess::granted)) return "";
  return "; the daemon sends nothing until that one has been quiet for 3 s";
}

/// Is it the drive expected, one drive, and one of the line?
std::string which_drive_text(const std::string& who, const cansync::MasterEvent& event,
                             const Config& config) {
  if (event.code == Code::wrong_drive) return wrong_drive_text(who, event, config);
  if (event.code == Code::duplicate_slave) return duplicate_text(who, event, config);
  if (event.code == Code::unknown_slave) {
    return fmt::format(
        "slave {0} answers and is not in the configuration; add it ([[slave]] with number = {0}), or disconnect it: "
        "it receives the reference values of all",
        event.slave->value());
  }
  return fmt::format("{} is the drive expected: {} {}", who, text::counted(event.detail, "parameter"),
                     event.detail == 1 ? "has its value" : "have their values");
}

std::string text_of(const cansync::MasterEvent& event, const Config& config) {
  const std::string who = event.slave ? slave_label(config, event.slave->value()) : std::string("a slave");
  switch (event.code) {
    case Code::slave_responds:
      return who + " responds";
    case Code::slave_lost:
      return fmt::format("{} no longer responds{}; check its power and the bus cable", who,
                         event.detail != 0 ? fmt::format(", {} of its jobs ended", event.detail) : "");
    case Code::slave_returned:
      return who + " responds again; it is held out until it is released";
    case Code::slave_checked:
      return fmt::format("{} has the values of all its {} return parameters", who, event.detail);
    case Code::slave_check_failed:
      return check_failed_text(who, event, config);
    case Code::slave_status_refused:
      return status_refused_text(who, event, config);
    case Code::slave_identified:
    case Code::wrong_drive:
    case Code::duplicate_slave:
    case Code::unknown_slave:
      return which_drive_text(who, event, config);
    case Code::slave_released:
      return who + (event.detail != 0 ? " is released by command, unchecked" : " is released");
    case Code::slave_synchronized:
      return who + " is synchronized";
    case Code::slave_not_synchronized:
      return who + " is no longer synchronized";
    case Code::all_synchronized:
      return "all configured slaves are synchronized";
    case Code::references_stopped:
      return fmt::format("reference values of telegram {} are no longer released", event.detail);
    case Code::references_released:
      return fmt::format("reference values of telegram {} are released", event.detail);
    case Code::references_too_old:
      if (event.expected == 0) {
        return fmt::format(
            "reference values of telegram {} are too old: before their release began they had waited until "
            "they were older than {} ms (failsafe.reference_max_age_ms)",
            event.detail, config.failsafe.reference_max_age.count());
      }
      return fmt::format(
          "reference values of telegram {} are too old: no newer ones came within {} "
          "(failsafe.reference_max_intervals)",
          event.detail, text::counted(event.expected, "interval"));
    case Code::references_held:
      return fmt::format("the last reference values of telegram {} are still released, for {} at most",
                         event.detail, text::counted(config.failsafe.hold_intervals, "interval"));
    case Code::second_master:
      return fmt::format("another master sends on this bus ({}){}; switch one of them off",
                         other_master_frame(event.detail), other_master_effect(event));
    case Code::second_master_gone:
      return fmt::format("the other master is silent; {} of its frames were seen", event.detail);
  }
  return "unknown event";
}

std::string_view remedy_of(can::SendResult result) noexcept {
  switch (result) {
    case can::SendResult::queued:
      return "telegrams are sent";
    case can::SendResult::queue_full:
      return "the controller's queue is full; is another node on the bus, with the same bit rate?";
    case can::SendResult::bus_off:
      return "the controller is bus-off; check the wiring, then give mode reset-can";
    case can::SendResult::interface_down:
      return "the interface is missing or not up; plug it in and set it up";
    case can::SendResult::not_delivered:
      return "nobody on the bus acknowledges";
  }
  return "unknown reason";
}

struct ReportDescriber {
  const Config& config;
  const can::LinkFacts& link;

  std::optional<EventText> operator()(const StateChanged& report) const {
    return EventText{gateway_SEVERITY_INFO, "state_changed", -1,
                     fmt::format("state '{}' to '{}' on '{}'", cansync::name(report.from),
                                 cansync::name(report.to), cansync::name(report.command)),
                     report.when};
  }
  std::optional<EventText> operator()(const EventReport& report) const {
    EventText event{severity_of(report.event.code), code_of(report.event.code),
                    report.event.slave ? int{report.event.slave->value()} : -1, text_of(report.event, config),
                    report.when};
    if (report.event.code == Code::slave_check_failed || report.event.code == Code::slave_status_refused ||
        report.event.code == Code::wrong_drive)
      event.parameter = static_cast<int>(report.event.detail);
    return event;
  }
  std::optional<EventText> operator()(const SyncsMissed& report) const {
    return EventText{
        gateway_SEVERITY_WARNING, "syncs_missed", -1,
        fmt::format(
            "{} skipped: the realtime thread came too late; give it a realtime priority and a processor of "
            "its own",
            text::counted(report.count, "SYNC edge was", "SYNC edges were")),
        report.when};
  }
  std::optional<EventText> operator()(const ControllerChanged& report) const {
    auto severity = gateway_SEVERITY_WARNING;
    if (report.to == can::ControllerState::bus_off) severity = gateway_SEVERITY_ERROR;
    if (report.to == can::ControllerState::error_active) severity = gateway_SEVERITY_INFO;
    return EventText{severity, "controller_changed", -1,
                     fmt::format("CAN controller {} to {}", name(report.from), name(report.to)), report.when};
  }
  std::optional<EventText> operator()(const SendingChanged& report) const {
    if (report.result == can::SendResult::queued) {
      return EventText{gateway_SEVERITY_INFO, "sending_restored", -1,
                       fmt::format("telegrams are sent again; {} were left out", report.failed), report.when};
    }
    return EventText{gateway_SEVERITY_ERROR, "sending_failed", -1,
                     fmt::format("telegrams cannot be sent: {}", remedy_of(report.result)), report.when};
  }
  std::optional<EventText> operator()(const SyncSourceChanged& report) const {
    return sync_event(report, config);
  }
  std::optional<EventText> operator()(const SyncDeviceChanged& report) const {
    return sync_event(report, config);
  }
  std::optional<EventText> operator()(const LinkChanged& report) const {
    return describe_link(report, config, link);
  }
  std::optional<EventText> operator()(const BusFault& report) const { return describe_fault(report); }
  std::optional<EventText> operator()(const DeliveryChanged& report) const {
    return describe_delivery(report, config);
  }
  std::optional<EventText> operator()(const TransferProgress&) const { return std::nullopt; }
  std::optional<EventText> operator()(const ReferenceRefused&) const { return std::nullopt; }
};

}  // namespace

EventCode code_of(Code code) {
  switch (code) {
    case Code::slave_responds:
      return "slave_responds";
    case Code::slave_returned:
      return "slave_returned";
    case Code::slave_checked:
      return "slave_checked";
    case Code::slave_check_failed:
      return "slave_check_failed";
    case Code::slave_identified:
      return "slave_identified";
    case Code::wrong_drive:
      return "wrong_drive";
    case Code::duplicate_slave:
      return "duplicate_slave";
    case Code::unknown_slave:
      return "unknown_slave";
    case Code::slave_released:
      return "slave_released";
    case Code::slave_status_refused:
      return "slave_status_refused";
    case Code::slave_lost:
      return "slave_lost";
    case Code::slave_synchronized:
      return "slave_synchronized";
    case Code::slave_not_synchronized:
      return "slave_not_synchronized";
    case Code::all_synchronized:
      return "all_synchronized";
    case Code::references_stopped:
      return "references_stopped";
    case Code::references_released:
      return "references_released";
    case Code::references_too_old:
      return "references_too_old";
    case Code::references_held:
      return "references_held";
    case Code::second_master:
      return "second_master";
    case Code::second_master_gone:
      break;
  }
  return "second_master_gone";
}

std::string held_reason(const cansync::SlaveStatus& status, const Config& config) {
  if (!status.held) return "";
  switch (status.held->code) {
    case Code::wrong_drive:
      return "not the drive expected: " + difference_text(*status.held, config);
    case Code::duplicate_slave:
      return "two drives answer with this number";
    default:
      return "return parameter not right: " + difference_text(*status.held, config);
  }
}

std::optional<EventText> describe(const Report& report, const Config& config, const can::LinkFacts& link) {
  return std::visit(ReportDescriber{config, link}, report);
}

}  // namespace cansyncd
