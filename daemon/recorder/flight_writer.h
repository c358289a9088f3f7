#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <thread>

#include "daemon/desk/event_text.h"
#include "daemon/recorder/flight_files.h"
#include "rt/flight_recorder.h"

namespace cansyncd {

/// Saves what the flight recorder has frozen: a thread of normal priority that writes the files, tells the
/// event, and lets the recorder go on. A file that cannot be written is told as an event, too.
class FlightWriter {
 public:
  using Tell = std::function<void(const EventText&)>;

  /// `tell` is called on the writing thread. `recorder` must outlive the writer. Throws std::system_error
  /// when there is no thread to be had.
  FlightWriter(rt::FlightRecorder& recorder, FlightFileSettings settings, Tell tell);
  /// Writes what is frozen already, and ends the thread.
  ~FlightWriter();
  FlightWriter(const FlightWriter&) = delete;
  FlightWriter& operator=(const FlightWriter&) = delete;

 private:
  void run();
  void save();

  rt::FlightRecorder& recorder_;
  const FlightFileSettings settings_;
  const Tell tell_;
  std::atomic<bool> stop_{false};
  std::thread thread_;  // last: it uses everything above
};

/// Makes `folder` ready for recordings: its last part is created when only that is missing. One that belongs
/// to neither root nor this process's user, or in which everybody may replace files, is refused. Empty: it is
/// ready; else why it is not, in words.
std::string prepare_flight_folder(const std::string& folder);

}  // namespace cansyncd
