#include "cansync/config/drive_settings.h"

#include <algorithm>

namespace cansyncd {
namespace {

/// Four register bytes, that of word 0 the lowest.
std::uint32_t registers_of(const cansync::TelegramMapping& mapping) noexcept {
  std::uint32_t out = 0;
  for (unsigned i = 0; i < cansync::kWords; ++i)
    out |= std::uint32_t{cansync::to_register(mapping.word[i])} << (8 * i);
  return out;
}

/// What the drive holds at its start: what it tells of its own settings, or what makes it recognised.
std::uint32_t initial_value(const profile::Profile& profile, const profile::Parameter& parameter,
                            const cansync::SlaveSideSettings& slave) noexcept {
  switch (parameter.tells) {
    case profile::Tells::block_limit:
      return slave.block_limit;
    case profile::Tells::reference_mapping_1:
      return registers_of(slave.reference_mapping[0]);
    case profile::Tells::reference_mapping_2:
      return registers_of(slave.reference_mapping[1]);
    case profile::Tells::actual_mapping_1:
      return registers_of(slave.actual_mapping[0]);
    case profile::Tells::actual_mapping_2:
      return registers_of(slave.actual_mapping[1]);
    case profile::Tells::status_word:
    case profile::Tells::none:
      break;
  }
  for (const profile::Recognition& recognition : profile.recognised_by)
    if (recognition.number == parameter.number) return recognition.value;
  if (!parameter.limited) return 0;
  return static_cast<std::uint32_t>(std::clamp<std::int64_t>(0, parameter.minimum, parameter.maximum));
}

sim::ParameterDefinition definition_of(const profile::Parameter& parameter, std::uint32_t initial) {
  using Access = sim::ParameterDefinition::Access;
  sim::ParameterDefinition out;
  out.number = parameter.number;
  out.doubleword = parameter.format == profile::Format::doubleword;
  out.access = Access::not_available;
  if (parameter.access == profile::Access::read_write) out.access = Access::read_write;
  if (parameter.access == profile::Access::read_only) out.access = Access::read_only;
  out.initial = initial;
  out.limited = parameter.limited;
  out.minimum = parameter.minimum;
  out.maximum = parameter.maximum;
  return out;
}

/// The parameters of the slave's profile that no simulated drive has of itself.
void add_parameters(const profile::Profile& profile, sim::DriveSettings& settings) {
  const std::vector<sim::ParameterDefinition> own = sim::standard_parameters();
  for (const profile::Parameter& parameter : profile.parameters) {
    const bool known = std::any_of(own.begin(), own.end(), [&](const sim::ParameterDefinition& definition) {
      return definition.number == parameter.number;
    });
    if (known || parameter.number == settings.status_parameter) continue;
    settings.parameters.push_back(
        definition_of(parameter, initial_value(profile, parameter, settings.slave)));
  }
}

}  // namespace

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
  const auto& profile = config.slaves[number.value()].parameters;
  if (profile) add_parameters(*profile, settings);
  return settings;
}

}  // namespace cansyncd
