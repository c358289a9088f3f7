#pragma once

#include <optional>
#include <string>

#include "can/bus.h"
#include "daemon/loop/flight_tap.h"
#include "daemon/recorder/flight_writer.h"
#include "daemon/service/journal.h"
#include "daemon_config/daemon_config.h"
#include "rt/flight_recorder.h"

namespace cansyncd {

/// The folder for recordings: what is configured; else `state_directory`, which the service manager gives
/// (null: none); else /var/lib/cansync/NAME. Empty: no recorder. Pure.
std::string flight_folder(const DaemonConfig& config, const char* state_directory);

/// The flight recorder of a daemon with all that belongs to it, or nothing of it when it is off.
class FlightDesk {
 public:
  /// Takes the memory and starts the writing thread, unless there is no folder that can be written, which is
  /// said in `journal` once. `protocol`: for the header of recordings. `bus` must outlive the desk; `tell` is
  /// called on the writing thread. Throws std::system_error without a thread or a file descriptor.
  FlightDesk(const DaemonConfig& config, const FlightProtocol& protocol, can::Bus& bus,
             const FlightWriter::Tell& tell, JournalSink& journal = process_journal());

  /// The bus the realtime loop is to drive, and its tap (null: off).
  can::Bus& bus() noexcept { return parts_ ? static_cast<can::Bus&>(parts_->bus) : bus_; }
  FlightTap* tap() noexcept { return parts_ ? &parts_->tap : nullptr; }

  /// Asks for a recording now. False: the recorder is off. Any thread.
  bool request() noexcept;

  /// Saves what is frozen, and a fault for which recording still went on; ends the writing thread. The
  /// realtime thread must have ended.
  void stop() noexcept;

 private:
  struct Parts {
    Parts(const DaemonConfig& config, can::Bus& inner)
        : recorder(config.recorder.entries, config.recorder.intervals_after),
          tap(recorder, config.recorder.triggers),
          bus(inner, tap) {}
    rt::FlightRecorder recorder;
    FlightTap tap;
    RecordedBus bus;
  };

  can::Bus& bus_;
  std::optional<Parts> parts_;
  std::optional<FlightWriter> writer_;  // last: it uses the recorder
};

}  // namespace cansyncd
