#include "daemon/recorder/flight_writer.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <system_error>
#include <utility>

#include "daemon/loop/flight_tap.h"
#include "text/counts.h"

namespace cansyncd {

std::string prepare_flight_folder(const std::string& folder) {
  constexpr mode_t kForOwnerAndGroup = 0750;
  const auto failed = [&](int error) {
    return fmt::format("{}: {}", folder, std::generic_category().message(error));
  };
  if (::mkdir(folder.c_str(), kForOwnerAndGroup) != 0 && errno != EEXIST) return failed(errno);
  struct stat facts = {};
  if (::stat(folder.c_str(), &facts) != 0) return failed(errno);
  if (!S_ISDIR(facts.st_mode)) return failed(ENOTDIR);
  if (facts.st_uid != 0 && facts.st_uid != ::geteuid()) {
    return fmt::format("{}: belongs to user {}; allowed: root, or the daemon's own user {}", folder,
                       facts.st_uid, ::geteuid());
  }
  if ((facts.st_mode & S_IWOTH) != 0 && (facts.st_mode & S_ISVTX) == 0)
    return folder + ": every user may replace files in it; take that right away (chmod o-w)";
  if (::access(folder.c_str(), W_OK | X_OK) != 0) return failed(errno);
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
  if (!result.problem.empty()) recorder_.not_saved();
  recorder_.rearm();
  if (!result.problem.empty()) {
    tell_({gateway_SEVERITY_ERROR, "flight_recording_failed", -1,
           fmt::format("the flight recording ({}, interval {}) was not written: {}", reason,
                       recording.trigger.interval, result.problem),
           std::nullopt});
    return;
  }
  tell_({gateway_SEVERITY_INFO, "flight_recording", -1,
         fmt::format("{} ({}, interval {}, {}; {})", result.log, reason, recording.trigger.interval,
                     text::counted(result.frames, "frame"),
                     text::counted(recording.further_faults, "fault before has no recording of its own",
                                   "faults before have no recording of their own")),
         std::nullopt});
}

}  // namespace cansyncd
