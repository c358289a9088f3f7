#pragma once

#include <span>
#include <string>

#include "daemon/bus/bus_choice.h"
#include "daemon/layer2/exchange.h"
#include "daemon/layer2/gateway/frame_gateway.h"
#include "daemon/layer2/realtime/frame_machine.h"
#include "daemon/segment/deadline_segment.h"
#include "layer2/config/file.h"

namespace cansyncd {

/// General frames on one bus. Main thread.
struct Layer2Parts : DeadlineParts {
  using File = Layer2File;
  using Exchange = Layer2Exchange;
  using Gateway = FrameGateway;
  using Machine = FrameMachine;

  static Layer2File load(const config::Source& source, std::span<const std::string> overrides);
  static Layer2File build(config::Settings settings, const std::string& path) {
    return build_layer2_config(std::move(settings), path);
  }
  /// With the simulated nodes.
  static BusPlan bus_plan(const Layer2Config& config);
  static Layer2Exchange exchange(const Layer2Config& config) {
    return {config.realtime.request_queue, config.realtime.report_queue};
  }
  static const Layer2File& given(const Layer2File& file) { return file; }
  static FrameMachineSettings machine_settings(const Layer2Config& config, FlightTap* tap,
                                               const SyncSources& = {});
  static std::string words(const Layer2Config& config);
  static std::string check_text(const Layer2Config& config);
};

using Layer2Segment = DeadlineSegment<Layer2Parts>;

}  // namespace cansyncd
