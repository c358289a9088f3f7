#include "daemon/recorder/flight_desk.h"

#include <fmt/format.h>

#include <cstdlib>
#include <string_view>

#include "daemon/service/service_log.h"

namespace cansyncd {

std::string flight_folder(const DaemonConfig& config, const char* state_directory) {
  if (config.recorder.folder) return *config.recorder.folder;
  if (state_directory != nullptr && *state_directory != '\0') {
    // More than one are separated by colons; the unit asks for one.
    const std::string_view all(state_directory);
    return std::string(all.substr(0, all.find(':')));
  }
  return "/var/lib/cansync/" + config.bus.name;
}

FlightDesk::FlightDesk(const DaemonConfig& config, const FlightProtocol& protocol, can::Bus& bus,
                       const FlightWriter::Tell& tell, JournalSink& journal)
    : bus_(bus) {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing in this process changes its environment
  const std::string folder = flight_folder(config, std::getenv("STATE_DIRECTORY"));
  if (folder.empty()) return;
  if (const std::string problem = prepare_flight_folder(folder); !problem.empty()) {
    ServiceLog(config.bus.name, journal)
        .say(config.recorder.folder ? LogPriority::warning : LogPriority::info, "recorder_off",
             fmt::format("the flight recorder is off: {}; create that folder for the daemon's user, or set "
                         "recorder.folder",
                         problem));
    return;
  }
  const FlightFileSettings files{
      folder,  config.recorder.files, config.bus.name, config.bus.interface, config.bus.bits_per_second,
      protocol};
  remove_half_recordings(files);
  parts_.emplace(config, bus);
  writer_.emplace(parts_->recorder, files, tell);
}

bool FlightDesk::request() noexcept {
  if (!parts_) return false;
  parts_->recorder.request();
  return true;
}

void FlightDesk::stop() noexcept {
  if (parts_) parts_->recorder.finish();
  writer_.reset();
}

}  // namespace cansyncd
