#include "daemon/cansync_slave/gateway/slave_events.h"

#include <fmt/format.h>

#include <chrono>
#include <string>
#include <string_view>

#include "daemon/cansync_slave/gateway/slave_status.h"
#include "sync/system.h"
#include "text/counts.h"

namespace cansyncd {
namespace {

double in_milliseconds(can::Time time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

/// A report in words.
struct SlaveWords {
  const SlaveRoleConfig& config;

  std::optional<EventText> operator()(const ReferencesReport&) const { return std::nullopt; }
  std::optional<EventText> operator()(const MonitoredReport&) const { return std::nullopt; }

  std::optional<EventText> operator()(const SlaveStateReport& report) const {
    return EventText{gateway_SEVERITY_INFO, "state_changed", -1,
                     fmt::format("state '{}' to '{}'", cansync::name(report.from), cansync::name(report.to)),
                     report.when};
  }

  std::optional<EventText> operator()(const SynchronizedReport& report) const {
    if (report.synchronized) {
      return EventText{
          gateway_SEVERITY_INFO, "slave_synchronized", config.slave.number.value(),
          "activated by the master, and the intervals follow its SYNC: bit 15 of the status word is "
          "set",
          report.when};
    }
    return EventText{
        gateway_SEVERITY_ERROR, "slave_not_synchronized", config.slave.number.value(),
        "not synchronized any more: bit 15 of the status word is clear, and no actual values are sent",
        report.when};
  }

  std::optional<EventText> operator()(const LockReport& report) const {
    using sync_line::LockState;
    const double missing = in_milliseconds(report.missing);
    switch (report.to) {
      case LockState::locked:
        return EventText{gateway_SEVERITY_INFO, "sync_locked", -1, "the intervals follow the master's SYNC",
                         report.when};
      case LockState::holdover:
        return EventText{
            gateway_SEVERITY_WARNING, "sync_holdover", -1,
            fmt::format("SYNC edges have been missing for {:.1f} ms; the intervals go on without "
                        "them for up to {} ms",
                        missing, config.sync.holdover.count()),
            report.when};
      case LockState::lost:
        return EventText{
            gateway_SEVERITY_ERROR, "sync_lost", -1,
            fmt::format("SYNC edges have been missing for {:.1f} ms: there are no intervals without "
                        "them; check the master, the wiring of SYNC and [sync]",
                        missing),
            report.when};
      case LockState::searching:
        break;
    }
    return EventText{gateway_SEVERITY_INFO, "sync_searching", -1,
                     "SYNC edges arrive; the intervals move towards them", report.when};
  }

  std::optional<EventText> operator()(const InputReport& report) const {
    if (report.error == 0)
      return EventText{gateway_SEVERITY_INFO, "sync_input_restored", -1, "the SYNC input works again",
                       report.when};
    const std::string& device =
        config.sync.input == SyncInput::pps ? config.sync.pps_device : config.sync.input_gpio_chip;
    return EventText{
        gateway_SEVERITY_ERROR, "sync_input_failed", -1,
        fmt::format("the SYNC input fails: {}", sync_line::reason_and_remedy(device, report.error)),
        report.when};
  }

  std::optional<EventText> operator()(const FaultReport& report) const {
    if (report.fault == cansync::SlaveFault::sync_lost) return std::nullopt;  // sync_lost has told it
    if (report.over)
      return EventText{gateway_SEVERITY_INFO, "references_back", -1,
                       "reference values come again, or the slave left run", report.when};
    return EventText{
        gateway_SEVERITY_ERROR, "references_missing", -1,
        fmt::format(
            "no reference values for {} in a row; the application must not go on with the last ones: {}",
            text::counted(config.supervision.misses_until_fault, "interval"), word_of(report.reaction)),
        report.when};
  }

  std::optional<EventText> operator()(const OwnNumberReport& report) const {
    return EventText{
        gateway_SEVERITY_ERROR, "slave_number_twice", config.slave.number.value(),
        fmt::format("another node sends with identifier 0x{:03X} of slave {}, which this daemon is; "
                    "give one of the two another number",
                    report.identifier, config.slave.number.value()),
        report.when};
  }
};

}  // namespace

std::optional<EventText> event_of(const SlaveSideReport& report, const SlaveRoleConfig& config) {
  return std::visit(SlaveWords{config}, report);
}

}  // namespace cansyncd
