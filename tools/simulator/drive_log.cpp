#include "simulator/drive_log.h"

#include <fmt/format.h>

#include <cstddef>
#include <utility>

#include "text/counts.h"

namespace cansync_sim {

void DriveLog::look() {
  if (bench_.counters().syncs == looked_at_) return;
  looked_at_ = bench_.counters().syncs;
  for (std::size_t index = 0; index < states_.size(); ++index) look(*bench_.drives()[index], states_[index]);
}

void DriveLog::look(const sim::Drive& drive, State& before) {
  const auto tell = [&]<class... Arguments>(fmt::format_string<Arguments...> format,
                                            Arguments&&... arguments) {
    remark_(fmt::format("SYNC {}: drive {} ", looked_at_ - 1, drive.number().value()) +
            fmt::format(format, std::forward<Arguments>(arguments)...));
  };
  State now;
  now.activated = drive.slave().sync_activated();
  now.synchronized = (drive.status_word() & sim::status_bit::synchronized) != 0;
  now.control_word = drive.control_word();
  now.fault = drive.fault();
  if (now.activated && !before.activated) tell("was activated");
  if (now.synchronized && !before.synchronized) tell("is synchronized");
  if (!now.synchronized && before.synchronized) tell("is not synchronized any more");
  if (now.control_word != before.control_word) tell("has control word 0x{:04X}", now.control_word);
  if (now.fault != before.fault && now.fault == 0) tell("has no fault any more");
  if (now.fault != before.fault && now.fault != 0) tell("has fault {}", now.fault);
  before = now;
}

std::string summary(const Bench& bench, std::uint64_t dropped) {
  const BenchCounters& counters = bench.counters();
  return fmt::format(
      "{}, {} SYNC, {} received, {} sent, {} not sent, {} too late, {}, {} lost by the kernel, {} without "
      "room",
      text::counted(bench.drives().size(), "drive"), counters.syncs,
      text::counted(counters.received, "frame"), counters.sent, counters.not_sent,
      text::counted(counters.too_late, "answer"), text::counted(counters.error_frames, "error frame"),
      text::counted(dropped, "frame"), text::counted(counters.faults_missed, "foreign frame"));
}

}  // namespace cansync_sim
