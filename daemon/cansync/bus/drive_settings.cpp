#include "daemon/cansync/bus/drive_settings.h"

namespace cansyncd {

sim::DriveSettings drive_settings(const Config& config, cansync::SlaveNumber number) {
  const cansync::SlaveSettings& slave = config.master.slaves[number.value()];
  sim::DriveSettings settings;
  settings.slave.number = number;
  settings.slave.bit_rate = config.master.bit_rate;
  settings.slave.reference_mapping = config.master.process.reference_mapping;
  settings.slave.actual_mapping = slave.actual_mapping;
  settings.slave.full_length = config.master.process.full_length;
  settings.slave.block_limit = slave.block_limit;
  settings.slave.activate_command = config.master.startup.activate_command;
  settings.slave.activate_data = config.master.startup.activate_data;
  settings.lock_time = config.drives.lock_time;
  settings.misses_until_fault = config.drives.missing_references;
  settings.edges_until_fault = config.drives.missing_edges;
  settings.status_parameter = slave.status_parameter;
  settings.memory.size = config.drives.memory;
  settings.memory.address_step = config.master.command_channel.address_step;
  return settings;
}

}  // namespace cansyncd
