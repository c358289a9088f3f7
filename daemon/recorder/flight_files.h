#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "daemon/loop/flight_tap.h"
#include "rt/flight_recorder.h"

/// A flight recording as files: what candump-style tools read, and a JSON header. Not for the realtime
/// thread.
namespace cansyncd {

/// Where recordings go and what belongs into each.
struct FlightFileSettings {
  std::string folder;
  unsigned files = 10;  ///< recordings of this bus that are kept; at least 1
  std::string bus;
  std::string interface;
  std::uint32_t bits_per_second = 0;
  FlightProtocol protocol;
};

/// A recording taken out of the recorder.
struct FlightRecording {
  rt::FlightTrigger trigger;
  std::vector<rt::FlightEntry> entries;
  std::uint64_t further_faults = 0;  ///< faults since the recording before that have none of their own
};

/// What became of writing a recording.
struct FlightFileResult {
  std::string log;      ///< path of the candump file; empty: it was not written
  std::string problem;  ///< why not, with the path
  std::size_t frames = 0;
};

/// The frames on the bus and the SYNC edges in candump's log format, in the order of their times (wall
/// clock): a frame at its end, an edge when it was produced, on the interface "sync" as `080#`.
std::string flight_candump(const FlightRecording& recording, const FlightFileSettings& settings);

/// The header: bus, reason, times, wake-ups, telegrams handed over and left out, states. `log` is the name of
/// the candump file.
std::string flight_header(const FlightRecording& recording, const FlightFileSettings& settings,
                          const std::string& log);

/// Removes what a daemon has left of this bus that ended while it wrote: logs without a header, and files that
/// were not whole. For a start, before anything is written.
void remove_half_recordings(const FlightFileSettings& settings);

/// Writes both files, whole or not at all; once it returns a power cut does not take them away. Then removes
/// recordings of this bus beyond `settings.files`: of the reason that has most of them the oldest. Touches no
/// other file.
FlightFileResult write_flight(const FlightRecording& recording, const FlightFileSettings& settings);

}  // namespace cansyncd
