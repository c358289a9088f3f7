#include "daemon/recorder/flight_writer.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <system_error>
#include <utility>

#include "daemon/loop/flight_tap.h"

namespace cansyncd {

std::string prepare_flight_folder(const std::string& folder) {
  constexpr mode_t kForOwnerAndGroup = 0750;
  if (::mkdir(folder.c_str(), kForOwnerAndGroup) != 0 && errno != EEXIST) {
    return fmt::format("{}: {}", folder, std::generic_category().message(errno));
  }
  if (::access(folder.c_str(), W_OK | X_OK) != 0) {
    return fmt::format("{}: {}", folder, std::generic_category().message(errno));
  }
  return {};
}

FlightWriter::FlightWriter(rt::FlightRecorder& recorder, FlightFileSettings settings, Tell tell)
    : recorder_(recorder),
      settings_(std::move(settings)),
      tell_(std::move(tell)),
      thread_([this] { run(); }) {}

FlightWriter::~FlightWriter() {
  stop_ = true;
  recorder_.wake_up();
  thread_.join();
}

void FlightWriter::run() {
  constexpr std::chrono::hours kUntilWoken{1};
  while (true) {
    // Looked at before the wait: what froze up to the stop is still saved.
    const bool last = stop_;
    if (recorder_.wait_frozen(last ? std::chrono::milliseconds(0) : kUntilWoken)) {
      save();
    } else if (last) {
      return;
    }
  }
}

void FlightWriter::save() {
  FlightRecording recording{recorder_.trigger(), recorder_.entries(), recorder_.take_further()};
  const char* reason = name(static_cast<FlightReason>(recording.trigger.reason));
  const FlightFileResult result = write_flight(recording, settings_);
  recorder_.rearm();
  if (!result.problem.empty()) {
    tell_({cansync_SEVERITY_ERROR, "flight_recording_failed", -1,
           fmt::format("the flight recording ({}, interval {}) was not written: {}", reason,
                       recording.trigger.interval, result.problem),
           std::nullopt});
    return;
  }
  tell_({cansync_SEVERITY_INFO, "flight_recording", -1,
         fmt::format("{} ({}, interval {}, {} frames; {} faults before have no recording of their own)",
                     result.log, reason, recording.trigger.interval, result.frames, recording.further_faults),
         std::nullopt});
}

}  // namespace cansyncd
