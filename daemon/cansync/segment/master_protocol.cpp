#include "daemon/cansync/segment/master_protocol.h"

#include <memory>
#include <span>
#include <utility>

#include "cansync/config/bus_budget.h"
#include "cansync/config/bus_budget_text.h"
#include "cansync/config/check_sync.h"
#include "cansync/config/dbc.h"
#include "cansync/config/options.h"
#include "daemon/cansync/segment/load_checked.h"
#include "daemon/cansync/segment/master_segment.h"

namespace cansyncd {
namespace {

LoadedConfig load(const config::Source& source, std::span<const std::string> overrides) {
  // Shared: both functions below have it, and only one of them is called.
  const auto file = std::make_shared<ConfigFile>(load_checked(source, overrides));
  LoadedConfig loaded;
  loaded.problems = file->problems;
  loaded.profile_problems = file->profile_problems;
  loaded.script_problems = file->script_problems;
  loaded.daemon = file->config;
  if (!loaded.problems.empty()) return loaded;
  loaded.check_text = sync_warning(file->config) + budget_text(bus_budget(budget_input(file->config)));
  loaded.dbc_text = [file] { return dbc_text(file->config); };
  loaded.make_segment = [file](JournalSink& journal, std::span<gateway::dds::Participant> participants) {
    return std::make_unique<MasterSegment>(std::move(*file), journal, std::move(participants.front()));
  };
  return loaded;
}

}  // namespace

const ProtocolInfo cansync_protocol = {kMasterProtocol, options, load, &master_document_heads};

}  // namespace cansyncd
