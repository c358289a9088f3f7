#include "daemon/cansync_cluster/segment/cluster_protocol.h"

#include <fmt/format.h>

#include <memory>
#include <span>
#include <utility>

#include "cansync/cluster/cluster.h"
#include "cansync/config/bus_budget.h"
#include "cansync/config/bus_budget_text.h"
#include "cansync/config/check_sync.h"
#include "cansync/config/dbc.h"
#include "cansync_cluster/config/options.h"
#include "daemon/cansync_cluster/segment/cluster_segment.h"

namespace cansyncd {
namespace {

std::string cluster_text(const ClusterConfig& config) {
  std::string text = fmt::format("above: slave {} at {} bit/s\n", config.upper.slave.number.value(),
                                 config.upper.bus.bits_per_second);
  for (const std::string& line : cansync::describe_lead_axis(config.cluster))
    text += fmt::format("lead axis: {}\n", line);
  return text + sync_warning(config.lower) + budget_text(bus_budget(budget_input(config.lower)));
}

LoadedConfig load_cluster(const config::Source& source, std::span<const std::string> overrides) {
  const auto file = std::make_shared<ClusterFile>(load_cluster_checked(source, overrides));
  LoadedConfig loaded;
  loaded.problems = file->problems;
  loaded.profile_problems = file->lower.profile_problems;
  loaded.script_problems = file->script_problems;
  loaded.daemon = file->config.daemon;
  if (!loaded.problems.empty()) return loaded;
  loaded.buses = {file->config.upper, file->config.lower};
  loaded.check_text = cluster_text(file->config);
  loaded.dbc_text = [file] { return dbc_text(file->config.lower); };
  loaded.make_segment = [file](JournalSink& journal, std::span<gateway::dds::Participant> participants) {
    return std::make_unique<ClusterSegment>(std::move(*file), journal, std::move(participants[0]),
                                            std::move(participants[1]));
  };
  return loaded;
}

}  // namespace

const ProtocolInfo cansync_cluster_protocol = {kClusterProtocol, cluster_options, load_cluster,
                                               &cluster_document_heads};

}  // namespace cansyncd
