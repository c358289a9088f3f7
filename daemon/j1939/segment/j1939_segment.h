#pragma once

#include <span>
#include <string>

#include "daemon/bus/bus_choice.h"
#include "daemon/j1939/exchange.h"
#include "daemon/j1939/gateway/message_gateway.h"
#include "daemon/j1939/realtime/message_machine.h"
#include "daemon/segment/deadline_segment.h"
#include "j1939/config/file.h"

namespace cansyncd {

/// J1939 on one bus. Main thread.
struct J1939Parts : DeadlineParts {
  using File = J1939File;
  using Exchange = J1939Exchange;
  using Gateway = MessageGateway;
  using Machine = MessageMachine;

  static J1939File load(const config::Source& source, std::span<const std::string> overrides);
  static J1939File build(config::Settings settings, const std::string& path) {
    return build_j1939_config(std::move(settings), path);
  }
  /// With the simulated nodes.
  static BusPlan bus_plan(const J1939Config& config);
  static J1939Exchange exchange(const J1939Config& config) {
    return {config.realtime.request_queue, config.realtime.report_queue, config.transport.most_bytes};
  }
  static const J1939Config& given(const J1939File& file) { return file.config; }
  static MessageMachineSettings machine_settings(const J1939Config& config, FlightTap* tap,
                                                 const SyncSources& = {});
  static std::string words(const J1939Config& config);
  static std::string check_text(const J1939Config& config);
};

using J1939Segment = DeadlineSegment<J1939Parts>;

}  // namespace cansyncd
