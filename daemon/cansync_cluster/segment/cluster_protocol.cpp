#include "daemon/cansync_cluster/segment/cluster_protocol.h"

#include <fmt/format.h>

#include <memory>
#include <span>
#include <utility>

#include "cansync/cluster/cluster.h"
#include "daemon/cansync/config/bus_budget.h"
#include "daemon/cansync/config/bus_budget_text.h"
#include "daemon/cansync/config/dbc.h"
#include "daemon/cansync_cluster/config/options.h"
#include "daemon/cansync_cluster/segment/cluster_segment.h"

namespace cansyncd {
namespace {

std::string cluster_text(const ClusterConfig& config) {
  std::string text = fmt::format("above: slave {} at {} bit/s\n", config.upper.slave.number.value(),
                                 config.upper.bus.bits_per_second);
  for (const std::string& line : cansync::describe_lead_axis(config.cluster))
    text += fmt::format("lead axis: {}\n", line);
  return text + budget_text(bus_budget(budget_input(config.lower)));
}

LoadedConfig load_cluster(const std::string& path, std::span<const std::string> overrides) {
  const auto file = std::make_shared<ClusterFile>(load_cluster_checked(path, overrides));
  LoadedConfig loaded;
  loaded.problems = file->problems;
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
