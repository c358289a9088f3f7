#include "cansync_cluster/config/file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "cansync/config/options.h"
#include "cansync_cluster/config/levels.h"
#include "cansync_cluster/config/options.h"
#include "cansync_slave/config/options.h"
#include "config/document.h"
#include "daemon_config/check_daemon.h"

namespace cansyncd {
namespace {

using cansync::LeadSource;
using Excluded = LevelOptions::Excluded;

constexpr std::string_view kWakes =
    "the frames of the upper bus wake the thread, and those of the lower do not";
constexpr std::string_view kFollows = "the lower SYNC follows that of the upper bus";

constexpr auto kExcludedAbove = std::to_array<Excluded>({{"bus.wake_on_frame", kWakes}});
constexpr auto kExcludedBelow = std::to_array<Excluded>({{"bus.wake_on_frame", kWakes},
                                                         {"sync.input", kFollows},
                                                         {"sync.input_gpio_chip", kFollows},
                                                         {"sync.input_gpio_line", kFollows},
                                                         {"sync.input_edge", kFollows},
                                                         {"sync.pps_device", kFollows},
                                                         {"sync.pps_edge", kFollows},
                                                         {"sync.input_offset_ns", kFollows},
                                                         {"sync.holdover_ms", kFollows},
                                                         {"sync.greatest_step_ns", kFollows},
                                                         {"sync.phc_device", kFollows},
                                                         {"sync.phc_pin", kFollows},
                                                         {"sync.phc_channel", kFollows}});

void take_settings(ClusterDraft& draft, config::Settings& settings, std::vector<config::Problem>& problems) {
  const auto wrong = [&](const config::Setting& setting) {
    draft.number = setting.numbers.empty() ? 0 : static_cast<unsigned>(setting.numbers.front());
    auto text = cluster_option_rows().apply(*setting.option, setting.value, draft);
    if (!text) return false;
    problems.push_back({setting.where, setting.key, *std::move(text)});
    return true;
  };
  std::erase_if(settings.items, wrong);
}

/// What a numbered section does not say, where its number stands.
void missing(Findings& findings, const std::string& section, std::string_view name,
             std::string_view allowed) {
  const config::Setting* number = findings.place(section + ".number");
  findings.problems().push_back({number != nullptr ? number->where : config::Position{findings.path(), 0, 0},
                                 fmt::format("{}.{}", section, name),
                                 fmt::format("is missing; allowed: {}", allowed)});
}

void take_routes(const ClusterDraft& draft, cansync::GatewaySettings& gateway, Findings& findings) {
  for (const auto& [number, given] : draft.sub_slaves) {
    const std::string key = fmt::format("sub_slave.{}", number);
    if (!given.slave) {
      missing(findings, key, "slave", "0..31, a slave of the lower bus");
      continue;
    }
    const cansync::SubSlave address{static_cast<std::uint16_t>(number)};
    gateway.routes.push_back(
        {address, *cansync::SlaveNumber::from(*given.slave), given.gateway ? address : cansync::SubSlave{}});
  }
}

void take_leads(const ClusterDraft& draft, cansync::LeadSources& sources, Findings& findings) {
  for (const auto& [number, given] : draft.leads) {
    const std::string key = fmt::format("lead.{}", number);
    const bool monitored = given.from == LeadSource::Kind::monitored;
    if (!given.value) missing(findings, key, "value", "0..7, a value of the upper bus");
    if (monitored && !given.slave) missing(findings, key, "slave", "0..31, the slave whose value it is");
    if (!monitored && given.slave)
      findings.problem(key + ".slave",
                       "found beside another source; allowed: with from = \"monitored\" alone");
    if (!given.value || monitored != given.slave.has_value()) continue;
    sources[number] = {given.from, static_cast<std::uint8_t>(*given.value),
                       *cansync::SlaveNumber::from(given.slave.value_or(0)), given.is_signed};
  }
}

/// The option behind a field of `cansync::ClusterSettings`.
std::string key_of(const std::string& field, const cansync::GatewaySettings& gateway) {
  const auto place = [&field] { return std::stoul(field.substr(field.find('[') + 1)); };
  if (field.starts_with("gateway.routes["))
    return fmt::format("sub_slave.{}.{}", gateway.routes[place()].number.value,
                       field.substr(field.rfind('.') + 1));
  if (field.starts_with("lead[")) return fmt::format("lead.{}.number", place());
  if (field == "lower.process.too_old_after") return "lower.failsafe.reference_max_intervals";
  return field == "gateway.monitoring" ? "cluster.monitoring_ms" : field;
}

void finish_cluster(const ClusterDraft& draft, ClusterConfig& config, Findings& findings) {
  cansync::ClusterSettings& cluster = config.cluster;
  cluster.upper = config.upper.slave;
  cluster.lower = config.lower.master;
  cluster.lead_reserve = draft.lead_reserve;
  cluster.gateway.own_number = {draft.own_number};
  cluster.gateway.monitoring = draft.monitoring;
  cluster.gateway.block_monitoring = draft.block_monitoring;
  cluster.gateway.asker_gone = draft.asker_gone;
  cluster.gateway.transfer_gone = draft.transfer_gone;
  take_routes(draft, cluster.gateway, findings);
  take_leads(draft, cluster.lead, findings);
  for (const cansync::SettingProblem& problem : check(cluster)) {
    const std::string key = key_of(problem.field, cluster.gateway);
    const bool time = key == "cluster.monitoring_ms";
    findings.problem(
        key, fmt::format("found {}; allowed: {}", problem.found,
                         time ? "1 and more, and shorter than cluster.asker_gone_ms" : problem.allowed));
  }
}

void check_levels(const ClusterConfig& config, std::vector<config::Problem>& problems,
                  const std::string& path) {
  if (config.lower.sync.output == SyncOutput::phc)
    problems.push_back({{path, 0, 0},
                        "lower.sync.output",
                        fmt::format("found \"phc\"; allowed: none, gpio or can, because {}", kFollows)});
  if (config.upper.bus.kind == BusKind::socketcan && config.upper.bus.interface == config.lower.bus.interface)
    problems.push_back({{path, 0, 0},
                        "lower.bus.interface",
                        fmt::format("found {}, which is upper.bus.interface; allowed: another one",
                                    config.lower.bus.interface)});
  if (config.upper.bus.kind == BusKind::socketcan && config.upper.sync.input == SyncInput::none)
    problems.push_back({{path, 0, 0},
                        "upper.sync.input",
                        "is \"none\" on a CAN interface; allowed: gpio, pps or can, where the SYNC of the "
                        "upper bus comes from: without it nothing begins below"});
}

}  // namespace

ClusterFile load_cluster_config(const config::Source& source, std::span<const std::string> overrides) {
  const LevelOptions above{"upper", slave_options(), cluster_options(), kExcludedAbove};
  const LevelOptions below{"lower", options(), cluster_options(), kExcludedBelow};
  ClusterFile file;
  const std::string& path = source.path;
  file.path = path;
  config::Document document = config::read_document(source);
  if (!document.problems.empty()) {
    file.problems = std::move(document.problems);
    return file;
  }
  const config::Document upper = take_level(document, above.name);
  const config::Document lower = take_level(document, below.name);
  config::Settings settings = config::resolve(document, cluster_options());
  for (const std::string& assignment : overrides) {
    if (!assignment.starts_with("upper.") && !assignment.starts_with("lower."))
      config::override_setting(settings, assignment, cluster_options());
  }
  file.problems = std::move(settings.problems);
  ClusterDraft draft;
  draft.daemon.bus.name = "cluster";
  take_settings(draft, settings, file.problems);
  const std::string& bus = draft.daemon.bus.name;
  file.upper = build_slave_config(level_settings(upper, above, overrides, settings.items, bus), path);
  file.lower = build_config(level_settings(lower, below, overrides, settings.items, bus), path);
  name_level(file.upper.problems, above);
  name_level(file.lower.problems, below);
  name_level(file.lower.profile_problems, below);
  const bool whole = file.problems.empty();
  for (const auto* level : {&file.upper.problems, &file.lower.problems}) {
    // Beside something wrong, what is missing may be so because of that.
    std::ranges::copy_if(*level, std::back_inserter(file.problems), [whole](const config::Problem& problem) {
      return whole || problem.where.line != 0;
    });
  }
  file.config.upper = file.upper.config;
  file.config.lower = file.lower.config;
  file.config.upper.bus.wake_on_frame = true;
  file.settings = std::move(settings.items);
  if (file.problems.empty()) {
    Findings findings(file.settings, path);
    finish_cluster(draft, file.config, findings);
    file.problems = std::move(findings.problems());
    check_levels(file.config, file.problems, path);
  }
  file.config.daemon = std::move(draft.daemon);
  config::sort_by_place(file.problems);
  return file;
}

}  // namespace cansyncd
