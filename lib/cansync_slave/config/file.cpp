#include "cansync_slave/config/file.h"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "cansync/telegram/mapping.h"
#include "cansync_slave/config/options.h"
#include "daemon_config/check_profiles.h"

namespace cansyncd {
namespace {

using cansync::Channel;

void finish_mapping(const MappingBytes& bytes, Channel channel, const std::string& key,
                    cansync::TelegramMapping& mapping, Findings& findings) {
  if (!bytes) return;
  for (unsigned word = 0; word < cansync::kWords; ++word) {
    const auto decoded = cansync::from_register((*bytes)[word]);
    if (!decoded) {
      findings.problem(
          key,
          fmt::format("found 0x{:02X} in word {}; allowed: 0 for an unused word, else bit 0 set, bit 1 for "
                      "the high word, value number 0..7 in bits 2..6",
                      (*bytes)[word], word));
      return;
    }
    mapping.word[word] = *decoded;
  }
  if (cansync::values_fit(mapping, channel)) return;
  findings.problem(key, channel == Channel::one
                            ? "found a value over 3; allowed: values 0..3 in the first telegram"
                            : "found a value under 4; allowed: values 4..7 in the second telegram");
}

void finish_mappings(const MappingBytesOfBoth& bytes, const std::string& prefix,
                     cansync::ProcessMapping& mapping, Findings& findings) {
  for (const Channel channel : {Channel::one, Channel::two}) {
    const unsigned place = index(channel);
    finish_mapping(bytes[place], channel, fmt::format("{}_{}", prefix, place + 1), mapping[place], findings);
  }
}

void finish_slave(SlaveRoleDraft& draft, Findings& findings) {
  cansync::SlaveSideSettings& slave = draft.config.slave;
  if (!draft.numbered)
    findings.problem("slave.number", "is missing; allowed: 0..31, the slave's number on the bus");
  finish_mappings(draft.reference, "slave.reference_registers", slave.reference_mapping, findings);
  finish_mappings(draft.actual, "slave.actual_registers", slave.actual_mapping, findings);
  for (unsigned n = 0; n < cansync::kSlaves; ++n) {
    if (!draft.monitored[n].given) continue;
    if (draft.numbered && n == slave.number.value()) {
      findings.problem(fmt::format("monitored.{}.number", n),
                       fmt::format("found {}, which is slave.number; allowed: numbers of other slaves", n));
    }
    cansync::ProcessMapping mapping = {cansync::default_mapping(Channel::one),
                                       cansync::default_mapping(Channel::two)};
    finish_mappings(draft.monitored[n].mapping, fmt::format("monitored.{}.registers", n), mapping, findings);
    slave.monitored[n] = mapping;
  }
}

void find_profile(SlaveRoleConfig& config, Findings& findings) {
  if (config.profile.empty()) return;
  const std::string key = "slave.profile";
  const config::Setting* setting = findings.place(key);
  const bool typed = setting != nullptr && setting->overridden;
  ProfileFiles files(std::filesystem::path(findings.path()).parent_path().string());
  LoadedProfile loaded = files.load(config.profile, typed);
  config.parameters = std::move(loaded.profile);
  if (!loaded.problem.empty()) findings.problem(key, std::move(loaded.problem));
  for (config::Problem& wrong : loaded.problems) findings.problems().push_back(std::move(wrong));
}

/// The table with what the daemon itself answers.
void finish_service(SlaveRoleDraft& draft, Findings& findings) {
  cansync::SlaveServiceSettings& service = draft.config.service;
  service.jobs.unknown = static_cast<cansync::ParameterError>(draft.unknown_parameter_error);
  find_profile(draft.config, findings);
  service.parameters = cansync_slave::definitions_of(cansync_slave::named_parameters(
      draft.parameters, draft.config.parameters.get(),
      [&findings](const std::string& key, const std::string& text) { findings.problem(key, text); }));
  // What the profile says of the status word is for people: the daemon answers.
  std::erase_if(service.parameters, [&draft](const cansync::ParameterDefinition& one) {
    return one.number == draft.config.status_parameter;
  });
  if (draft.parameters.parameters.contains(draft.config.status_parameter)) {
    findings.problem(
        fmt::format("parameter.{}.number", draft.config.status_parameter),
        fmt::format("found {}, which is slave.status_parameter and answered with the status word; "
                    "allowed: other numbers",
                    draft.config.status_parameter));
  }
  cansync::ParameterDefinition status;
  status.number = draft.config.status_parameter;
  status.access = cansync::ParameterDefinition::Access::read_only;
  status.initial = draft.config.status_bits;
  service.parameters.push_back(status);
}

void finish_jobs(SlaveRoleDraft& draft, Findings& findings) {
  for (auto& [number, job] : draft.jobs) {
    const std::string key = fmt::format("sim.job.{}.number", number);
    const int kinds = int{job.parameter.has_value()} + int{job.bytes != 0} +
                      int{job.control_word.has_value()} + int{job.action.has_value()};
    if (kinds != 1) {
      findings.problem(key,
                       fmt::format("found {} of parameter, bytes, control_word and action; allowed: one of "
                                   "them",
                                   kinds == 0 ? "none" : "several"));
    } else if (draft.config.bus.kind != BusKind::simulated) {
      findings.problem(key,
                       "found a job of the simulated master; allowed: with bus.interface = \"sim\" alone");
    }
    if (job.address == 0) job.address = 0x100;
    draft.config.simulated_jobs.push_back(job);
  }
}

void check_input(const SlaveRoleConfig& config, Findings& findings) {
  if (config.bus.kind == BusKind::simulated && config.sync.input != SyncInput::none) {
    findings.problem(
        "sync.input",
        "found an input beside the simulated bus; allowed: \"none\", because the simulated master "
        "brings its own SYNC");
  }
}

}  // namespace

SlaveRoleFile build_slave_config(config::Settings settings, const std::string& path) {
  return build_file(std::move(settings), path, slave_option_rows(),
                    [](SlaveRoleDraft& draft, Findings& findings) {
                      finish_slave(draft, findings);
                      finish_service(draft, findings);
                      finish_jobs(draft, findings);
                      check_input(draft.config, findings);
                    });
}

SlaveRoleFile load_slave_config(const config::Source& source, std::span<const std::string> overrides) {
  return build_slave_config(config::read_settings(source, overrides, slave_options()), source.path);
}

}  // namespace cansyncd
