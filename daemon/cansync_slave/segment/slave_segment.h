#pragma once

#include <memory>
#include <span>
#include <string>

#include "cansync_slave/config/file.h"
#include "daemon/bus/bus_choice.h"
#include "daemon/cansync_slave/exchange.h"
#include "daemon/cansync_slave/gateway/slave_gateway.h"
#include "daemon/cansync_slave/realtime/slave_machine.h"
#include "daemon/segment/deadline_segment.h"

namespace cansyncd {

/// The bus of a configuration, with the simulated master. Main thread.
BusPlan slave_bus_plan(const SlaveRoleConfig& config);

/// What the realtime thread needs of a configuration; `line` and `wire` may be null.
SlaveMachineSettings slave_machine_settings(const SlaveRoleConfig& config, FlightTap* tap,
                                            const SyncFollower::Inputs& inputs);

/// A slave on one bus. Main thread.
struct SlaveParts : DeadlineParts {
  using File = SlaveRoleFile;
  using Exchange = SlaveExchange;
  using Gateway = SlaveGateway;
  using Machine = SlaveMachine;

  static SlaveRoleFile load(const config::Source& source, std::span<const std::string> overrides);
  static SlaveRoleFile build(config::Settings settings, const std::string& path) {
    return build_slave_config(std::move(settings), path);
  }
  static BusPlan bus_plan(const SlaveRoleConfig& config) { return slave_bus_plan(config); }
  static SlaveExchange exchange(const SlaveRoleConfig& config) {
    return SlaveExchange(config.realtime.report_queue);
  }
  static const SlaveRoleConfig& given(const SlaveRoleFile& file) { return file.config; }
  /// Null on a simulated bus, and without an input.
  static std::unique_ptr<SyncLine> sync_line(const SlaveRoleFile& file);
  static FlightProtocol flight(const SlaveRoleConfig& config);
  static SlaveMachineSettings machine_settings(const SlaveRoleConfig& config, FlightTap* tap,
                                               const SyncSources& sync);
  static std::string words(const SlaveRoleConfig& config);
  static std::string check_text(const SlaveRoleConfig& config);
};

using SlaveSegment = DeadlineSegment<SlaveParts>;

}  // namespace cansyncd
