#include "daemon/cansync/texts/sync_text.h"

#include <fmt/format.h>

#include <chrono>

#include "daemon/loop/sync_line.h"
#include "text/counts.h"

namespace cansyncd {
namespace {

const std::string& sync_device(const Config& config, bool output) noexcept {
  if (!output)
    return config.sync.input == SyncInput::pps ? config.sync.pps_device : config.sync.input_gpio_chip;
  return config.sync.output == SyncOutput::phc ? config.sync.phc_device : config.sync.gpio_chip;
}

/// What the timeline follows, for people.
std::string_view sync_source(const Config& config) noexcept {
  return config.sync.output == SyncOutput::phc ? "hardware clock" : "external SYNC";
}

}  // namespace

EventText sync_event(const SyncSourceChanged& report, const Config& config) {
  using sync_line::LockState;
  const std::string_view source = sync_source(config);
  const auto missing = std::chrono::duration<double, std::milli>(report.missing).count();
  switch (report.to) {
    case LockState::locked:
      return {gateway_SEVERITY_INFO, "sync_locked", -1,
              report.missing > can::Time{0}
                  ? fmt::format("the timeline follows the {} again; its edges were missing for {:.1f} ms",
                                source, missing)
                  : fmt::format("the timeline follows the {}", source),
              report.when};
    case LockState::holdover:
      return {gateway_SEVERITY_WARNING, "sync_holdover", -1,
              fmt::format("edges of the {} have been missing for {:.1f} ms; the timeline holds over for up "
                          "to {} ms",
                          source, missing, config.sync.holdover.count()),
              report.when};
    case LockState::lost:
      return {gateway_SEVERITY_ERROR, "sync_lost", -1,
              fmt::format("edges of the {} have been missing for {:.1f} ms; the timeline goes on by itself; "
                          "check the source and its wiring",
                          source, missing),
              report.when};
    case LockState::searching:
      break;
  }
  const bool jumped = report.from != LockState::lost;
  return {jumped ? gateway_SEVERITY_WARNING : gateway_SEVERITY_INFO, "sync_searching", -1,
          jumped ? fmt::format("the {} has jumped; the timeline moves to its new phase", source)
                 : fmt::format("edges of the {} arrive again; the timeline moves towards them", source),
          report.when};
}

EventText sync_event(const SyncDeviceChanged& report, const Config& config) {
  const std::string_view what = report.output ? "SYNC output" : "SYNC input";
  if (report.error == 0) {
    return {gateway_SEVERITY_INFO,
            report.output ? EventCode("sync_output_restored") : EventCode("sync_input_restored"), -1,
            report.output ? fmt::format("the {} works again; {} could not be made since the start", what,
                                        text::counted(report.failures, "edge"))
                          : fmt::format("the {} works again", what),
            report.when};
  }
  const std::string reason =
      report.error == SyncLine::kNotSent
          ? std::string("the bus takes no software SYNC frame; see the events of the controller")
          : sync_line::reason_and_remedy(sync_device(config, report.output), report.error);
  return {gateway_SEVERITY_ERROR,
          report.output ? EventCode("sync_output_failed") : EventCode("sync_input_failed"), -1,
          fmt::format("the {} fails: {}", what, reason), report.when};
}

}  // namespace cansyncd
